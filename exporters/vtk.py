"""VTK: ``bed.vtp`` with one vertex a sphere, and the walls as ``wall.vtp``; for ParaView and pyvista.

ParaView shows points only where there are cells, so every point has a vertex. To see the sizes: Point
Gaussian, or Glyph of a sphere scaled by ``diameter`` with factor 1 (the glyph's own radius is 0.5).

Where shape and place of bodies are known, ``bed.vtp`` has the number of each sphere's ``body``, to colour by,
and ``bodies.vtp`` a vertex a body at its centre of mass: template, size, mass, quaternion, and the template's
axes as they are turned, ``axis_x``, ``axis_y`` and ``axis_z``.

A bed in pieces becomes ``bed.pvtp``, which names a file a piece in ``bed/``: ParaView reads them as one.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from exporters.shared import contact, deck, vtkxml
from exporters.shared.clumps import body_density
from exporters.walls import facets as walls
from packgen.bed import AnyBed, Bed, Bodies, numbered, rotations
from packgen.errors import ExportError

NAME = "vtk"
NEEDS: tuple[str, ...] = ()
STREAMS = True
CELLS = True
CLUMPS = True


class Options(BaseModel):
    """Options of the VTK files.

    Attributes:
        unstructured: Write ``bed.vtu`` too, for meshio and other programs that read no PolyData.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    unstructured: bool = False


def write(bed: AnyBed, folder: Path, options: Options) -> list[Path]:
    """Write the spheres and the walls of a bed into an existing folder and return the paths of the files.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS, clumps=True)
    if isinstance(bed, Bed):
        paths = [_write_spheres(folder / "bed.vtp", bed, sphere_arrays(bed))]
        if bed.bodies is not None:
            paths.append(_write_bodies(folder / "bodies.vtp", bed, bed.bodies))
    else:
        paths = _write_pieces(folder, bed, options)
    if walls.has_wall(bed) and bed.container.walls_known:
        surface = bed.container.surface
        faces = surface.faces[~walls.on_periodic_side(bed.container)]
        paths.append(vtkxml.write_polydata(folder / "wall.vtp", surface.vertices, "Polys", faces, {}))
    if options.unstructured and isinstance(bed, Bed):
        each, arrays = np.arange(bed.count, dtype=np.int64), sphere_arrays(bed)
        vertices = [("vertex", each[:, None])]
        path = folder / "bed.vtu"
        paths.append(vtkxml.write_unstructured(path, bed.position, vertices, point_data=arrays))
    return paths


def _write_spheres(path: Path, bed: Bed, arrays: Mapping[str, NDArray[Any]]) -> Path:
    each = np.arange(bed.count, dtype=np.int64)
    return vtkxml.write_polydata(path, bed.position, "Verts", each[:, None], arrays)


def _write_bodies(path: Path, bed: Bed, bodies: Bodies) -> Path:
    """Write a vertex a body at its centre of mass, with its orientation as quaternion and as axes."""
    each = np.arange(len(bodies), dtype=np.int64)
    turn = rotations(bodies.orientation)
    arrays: dict[str, NDArray[Any]] = {
        "body": each,
        "template": bodies.template_index,
        "spheres": bodies.sphere_count,
        "scale": bodies.scale,
        "equivalent_diameter": 2.0 * bodies.equivalent_radius,
        "volume": bodies.volume,
        "quaternion_wxyz": bodies.orientation,
        **{f"axis_{axis}": np.ascontiguousarray(turn[:, :, place]) for place, axis in enumerate("xyz")},
    }
    density = body_density(bed)
    if np.isfinite(density).all():
        arrays["mass"] = density * bodies.volume
    return vtkxml.write_polydata(path, bodies.position, "Verts", each[:, None], arrays)


def _write_pieces(folder: Path, bed: AnyBed, options: Options) -> list[Path]:
    """Write the spheres of a bed in pieces, a file each, and the file that names them."""
    if options.unstructured:
        raise ExportError("vtk: bed.vtu is not written of a bed in pieces; leave vtk.unstructured out")
    types = _types(bed)
    (folder / "bed").mkdir()
    paths: list[Path] = []
    form: dict[str, str] = {}
    for start, chunk in numbered(bed):
        arrays = sphere_arrays(chunk, first=start + 1, types=types)
        form = {name: vtkxml.type_of(values) for name, values in arrays.items()}
        paths.append(_write_spheres(folder / "bed" / f"bed_{len(paths):06d}.vtp", chunk, arrays))
    names = [f"bed/{path.name}" for path in paths]
    return [vtkxml.write_parallel_polydata(folder / "bed.pvtp", names, form), *paths]


def _types(bed: AnyBed) -> contact.Types | None:
    return contact.number_types(bed, has_wall=walls.has_wall(bed)) if bed.materials else None


def sphere_arrays(
    bed: Bed, *, first: int = 1, types: contact.Types | None = None
) -> Mapping[str, NDArray[Any]]:
    """Return the arrays of the spheres by name, each of shape (N,).

    ``id`` is the index in the bed plus ``first``, ``type`` counts materials from one, as in the solvers'
    decks; a bed whose materials are not known has no ``type``.
    """
    arrays: dict[str, NDArray[Any]] = {
        "radius": bed.radius,
        "diameter": 2 * bed.radius,
        "id": np.arange(first, first + bed.count, dtype=np.int64),
        "set": bed.set_index,
        "zone": bed.zone_index,
        "batch": bed.batch_index,
    }
    if bed.body_index is not None:
        arrays["body"] = bed.body_index
    types = types or _types(bed)
    if types is not None:
        arrays["type"] = np.array(types.by_set, dtype=np.int32)[bed.set_index]
    return arrays
