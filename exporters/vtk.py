"""VTK: ``bed.vtp`` with one vertex a sphere, and the walls as ``wall.vtp``; for ParaView and pyvista.

Format: "VTK XML file formats" (docs.vtk.org), PolyData with its arrays appended raw. ParaView shows
points only where there are cells, so every point has a vertex. To see the sizes: Point Gaussian, or Glyph of
a sphere scaled by ``diameter`` with factor 1 (the glyph's own radius is 0.5).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from exporters import contact, deck, walls
from packgen.bed import Bed

NAME = "vtk"
VTK_TYPES = {"f8": "Float64", "i8": "Int64", "i4": "Int32"}


class Options(BaseModel):
    """What a user may choose of the VTK files.

    Attributes:
        unstructured: Write ``bed.vtu`` too, by meshio, for programs that read no PolyData.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    unstructured: bool = False


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the spheres and the walls of a bed into an existing folder and return the paths of the files.

    Raises:
        ExportError: The bed is empty or holds what is no number.
    """
    deck.check_exportable(bed, NAME)
    arrays = sphere_arrays(bed)
    each = np.arange(bed.count, dtype=np.int64)
    paths = [write_polydata(folder / "bed.vtp", bed.position, "Verts", each[:, None], arrays)]
    if walls.has_wall(bed):
        surface = bed.container.surface
        faces = surface.faces[~walls.on_periodic_side(bed.container)]
        paths.append(write_polydata(folder / "wall.vtp", surface.vertices, "Polys", faces, {}))
    if options.unstructured:
        import meshio

        mesh = meshio.Mesh(bed.position, {"vertex": each[:, None]}, point_data=dict(arrays))
        # Random digits do not get smaller by compression, only later.
        mesh.write(folder / "bed.vtu", compression=None)
        paths.append(folder / "bed.vtu")
    return paths


def sphere_arrays(bed: Bed) -> Mapping[str, NDArray[Any]]:
    """Return what is known of each sphere, by the name of its array: each of shape (N,).

    ``id`` is the index in the bed plus one and ``type`` counts materials from one, as in the solvers' decks.
    """
    types = contact.number_types(bed, has_wall=walls.has_wall(bed))
    return {
        "radius": bed.radius,
        "diameter": 2 * bed.radius,
        "id": np.arange(1, bed.count + 1, dtype=np.int64),
        "type": np.array(types.by_set, dtype=np.int32)[bed.set_index],
        "set": bed.set_index,
        "zone": bed.zone_index,
        "batch": bed.batch_index,
    }


def write_polydata(
    path: Path,
    points: NDArray[np.float64],
    kind: str,
    cells: NDArray[np.int64],
    point_data: Mapping[str, NDArray[Any]],
) -> Path:
    """Write a PolyData file.

    Args:
        path: The file.
        points: Positions [m], shape (N, 3).
        kind: What the cells are: ``Verts`` or ``Polys``.
        cells: Indices of the points of each cell, shape (C, k).
        point_data: Arrays of shape (N,) by name.
    """
    offsets = np.arange(1, len(cells) + 1, dtype=np.int64) * cells.shape[1]
    blocks: list[NDArray[Any]] = []
    position = 0

    def array(name: str, values: NDArray[Any], components: int = 1) -> str:
        nonlocal position
        values = values.astype(values.dtype.newbyteorder("<"), copy=False)
        blocks.append(values)
        start, position = position, position + 8 + values.nbytes
        return (
            f'<DataArray type="{VTK_TYPES[values.dtype.str[1:]]}" Name="{name}"'
            f' NumberOfComponents="{components}" format="appended" offset="{start}"/>\n'
        )

    data = "".join(array(name, values) for name, values in point_data.items())
    counts = {"Verts": 0, "Lines": 0, "Strips": 0, "Polys": 0, kind: len(cells)}
    size = "".join(f' NumberOf{each}="{count}"' for each, count in counts.items())
    active = ' Scalars="diameter"' if "diameter" in point_data else ""
    head = (
        '<?xml version="1.0"?>\n'
        '<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian" header_type="UInt64">\n<PolyData>\n'
        f'<Piece NumberOfPoints="{len(points)}"{size}>\n'
        f"<PointData{active}>\n{data}</PointData>\n"
        f"<Points>\n{array('Points', points, 3)}</Points>\n"
        f"<{kind}>\n{array('connectivity', cells)}{array('offsets', offsets)}</{kind}>\n"
        '</Piece>\n</PolyData>\n<AppendedData encoding="raw">\n_'
    )
    with path.open("wb") as file:
        file.write(head.encode("ascii"))
        for block in blocks:
            file.write(np.uint64(block.nbytes).tobytes())
            file.write(np.ascontiguousarray(block).data)
        file.write(b"\n</AppendedData>\n</VTKFile>\n")
    return path
