"""VTK: ``bed.vtp`` with one vertex a sphere, and the walls as ``wall.vtp``; for ParaView and pyvista.

ParaView shows points only where there are cells, so every point has a vertex. To see the sizes: Point
Gaussian, or Glyph of a sphere scaled by ``diameter`` with factor 1 (the glyph's own radius is 0.5).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict

from exporters.shared import contact, deck, vtkxml
from exporters.walls import facets as walls
from packgen.bed import Bed

NAME = "vtk"
NEEDS: tuple[str, ...] = ()


class Options(BaseModel):
    """Options of the VTK files.

    Attributes:
        unstructured: Write ``bed.vtu`` too, for meshio and other programs that read no PolyData.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    unstructured: bool = False


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the spheres and the walls of a bed into an existing folder and return the paths of the files.

    Raises:
        ExportError: The bed is empty, or a number in it is not finite.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    arrays = sphere_arrays(bed)
    each = np.arange(bed.count, dtype=np.int64)
    paths = [vtkxml.write_polydata(folder / "bed.vtp", bed.position, "Verts", each[:, None], arrays)]
    if walls.has_wall(bed) and bed.container.walls_known:
        surface = bed.container.surface
        faces = surface.faces[~walls.on_periodic_side(bed.container)]
        paths.append(vtkxml.write_polydata(folder / "wall.vtp", surface.vertices, "Polys", faces, {}))
    if options.unstructured:
        vertices = [("vertex", each[:, None])]
        path = folder / "bed.vtu"
        paths.append(vtkxml.write_unstructured(path, bed.position, vertices, point_data=arrays))
    return paths


def sphere_arrays(bed: Bed) -> Mapping[str, NDArray[Any]]:
    """Return the arrays of the spheres by name, each of shape (N,).

    ``id`` is the index in the bed plus one and ``type`` counts materials from one, as in the solvers' decks;
    a bed whose materials are not known has no ``type``.
    """
    arrays: dict[str, NDArray[Any]] = {
        "radius": bed.radius,
        "diameter": 2 * bed.radius,
        "id": np.arange(1, bed.count + 1, dtype=np.int64),
        "set": bed.set_index,
        "zone": bed.zone_index,
        "batch": bed.batch_index,
    }
    if bed.materials:
        types = contact.number_types(bed, has_wall=walls.has_wall(bed))
        arrays["type"] = np.array(types.by_set, dtype=np.int32)[bed.set_index]
    return arrays
