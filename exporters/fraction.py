"""The solid-fraction field of a bed, exact in every cell, for CFD: as VTK and as OpenFOAM's volScalarField.

On a regular grid over the container: ``fraction.vti`` and, as an OpenFOAM case has them, ``0/voidfraction``
and the ``system/blockMeshDict`` that makes this grid with its cells in the order of the field. On the user's
own mesh (``mesh``, anything that meshio reads with hexahedra, wedges or tetrahedra): ``fraction.vtu`` and
``0/voidfraction`` in the order of the mesh's cells, which for a file of ``foamToVTK`` is OpenFOAM's own.
``fraction.json`` has the sums. The field ``voidfraction`` is the one that CFDEMcoupling reads.

Reference: OpenFOAM user guide, sections "Basic input/output file format" and "Mesh generation with
blockMesh".
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from exporters import cells, deck, meshcells, table, vtkxml
from packgen.bed import Bed, with_images
from packgen.errors import ExportError

NAME = "fraction"
CELL_DIAMETERS = 3.0  # of the mean diameter: what unresolved CFD-DEM asks of a cell at least
CELLS_MAX = 50_000_000

Float64Array = NDArray[np.float64]


class Options(BaseModel):
    """What a user may choose of the field.

    Attributes:
        cell_size: Size of the grid's cells [m], made a little smaller where the container's size is no
            multiple of it; None: three mean diameters.
        mesh: A mesh to take instead of a grid.
        scale: Metres in one unit of the mesh.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    cell_size: float | None = Field(default=None, gt=0)
    mesh: Path | None = None
    scale: float = Field(default=1.0, gt=0)


@dataclass(frozen=True, eq=False, slots=True)
class Grid:
    """A regular grid: lower corner and size of a cell [m], each of shape (3,), and cells along x, y, z."""

    low: Float64Array
    spacing: Float64Array
    shape: tuple[int, int, int]


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the field of a bed into an existing folder and return the paths of its files.

    Raises:
        ExportError: The bed is empty, or the mesh cannot be read or has cells of another kind.
    """
    deck.check_exportable(bed, NAME)
    position, radius = with_images(bed)
    (folder / "0").mkdir(exist_ok=True)
    if options.mesh is not None:
        paths, volume = _write_mesh(position, radius, folder, options.mesh, options.scale)
    else:
        paths, volume = _write_grid(bed, position, radius, folder, options.cell_size)
    solid = 4 / 3 * np.pi * float((bed.radius**3).sum())
    sums = {"spheres_volume": solid, "volume_in_cells": volume, "share_in_cells": volume / solid}
    paths.append(deck.write_text(folder / "fraction.json", json.dumps(sums, indent=2) + "\n"))
    return paths


def choose_grid(bed: Bed, cell_size: float | None) -> Grid:
    """Return a grid of about cubic cells over the container.

    Raises:
        ExportError: It would have more than `CELLS_MAX` cells.
    """
    low, high = bed.container.bounds
    size = CELL_DIAMETERS * 2 * float(bed.radius.mean()) if cell_size is None else cell_size
    count = np.maximum(1, np.ceil((high - low) / size * (1 - 1e-12)))
    if count.prod() > CELLS_MAX:
        raise ExportError(
            f"{NAME}: a grid of {count.prod():.3g} cells, expected at most {CELLS_MAX}; enlarge cell_size"
        )
    shape = (int(count[0]), int(count[1]), int(count[2]))
    return Grid(low, (high - low) / count, shape)


def _write_grid(
    bed: Bed, position: Float64Array, radius: Float64Array, folder: Path, cell_size: float | None
) -> tuple[list[Path], float]:
    grid = choose_grid(bed, cell_size)
    volume = cells.grid_volumes(position, radius, grid.low, grid.spacing, grid.shape)
    # Both VTK and blockMesh count along x first.
    solid = (volume / grid.spacing.prod()).ravel(order="F")
    (folder / "system").mkdir(exist_ok=True)
    paths = [
        _write_image(folder / "fraction.vti", grid, solid),
        _write_foam_field(folder / "0" / "voidfraction", 1 - solid),
        deck.write_text(folder / "system" / "blockMeshDict", _block_mesh(grid)),
    ]
    return paths, float(volume.sum())


def _write_mesh(
    position: Float64Array, radius: Float64Array, folder: Path, path: Path, scale: float
) -> tuple[list[Path], float]:
    import meshio

    try:
        mesh = meshio.read(path)
    except SystemExit as error:  # meshio ends the program over an unknown extension
        raise ExportError(f"{NAME}: mesh: {path} is of no kind that meshio reads") from error
    except Exception as error:
        raise ExportError(f"{NAME}: mesh: {path} cannot be read: {error}") from error
    blocks = [block for block in mesh.cells if block.dim == 3]
    strange = sorted({block.type for block in blocks} - set(meshcells.FACES))
    if strange or not blocks:
        found = ", ".join(strange) or "no cells"
        known = ", ".join(meshcells.FACES)
        raise ExportError(f"{NAME}: mesh: {path} has {found}, expected {known}; split other cells first")
    points = np.asarray(mesh.points, dtype=np.float64) * scale
    try:
        both = [meshcells.mesh_volumes(position, radius, block.type, points[block.data]) for block in blocks]
    except ValueError as error:
        raise ExportError(f"{NAME}: mesh: {path}: {error}; split cells with warped faces first") from error
    solid = np.concatenate([volume / size for volume, size in both])
    parts = [(block.type, block.data) for block in blocks]
    data = {"solid_fraction": solid, "void_fraction": 1 - solid}
    paths = [
        vtkxml.write_unstructured(folder / "fraction.vtu", points, parts, cell_data=data),
        _write_foam_field(folder / "0" / "voidfraction", 1 - solid),
    ]
    return paths, float(sum(volume.sum() for volume, _ in both))


def _write_image(path: Path, grid: Grid, solid: Float64Array) -> Path:
    """Write a field as VTK's ImageData."""
    extent = " ".join(f"0 {count}" for count in grid.shape)
    origin, spacing = (" ".join(map(repr, each.tolist())) for each in (grid.low, grid.spacing))
    data = {"solid_fraction": solid, "void_fraction": 1 - solid}
    return vtkxml.write(
        path,
        "ImageData",
        [vtkxml.Section("CellData", data, {"Scalars": "solid_fraction"})],
        piece={"Extent": extent},
        grid={"WholeExtent": extent, "Origin": origin, "Spacing": spacing},
    )


def _foam_head(kind: str, name: str) -> str:
    return f"FoamFile\n{{\n    version 2.0;\n    format ascii;\n    class {kind};\n    object {name};\n}}\n\n"


def _write_foam_field(path: Path, values: Float64Array) -> Path:
    head = _foam_head("volScalarField", path.name) + (
        f"dimensions [0 0 0 0 0 0 0];\n\ninternalField nonuniform List<scalar>\n{len(values)}\n(\n"
    )
    foot = ')\n;\n\nboundaryField\n{\n    ".*"\n    {\n        type zeroGradient;\n    }\n}\n'
    return table.write_rows(path, [values], head=head, foot=foot)


def _block_mesh(grid: Grid) -> str:
    """Return the dictionary of one block whose cells blockMesh numbers along x first, as the field is."""
    high = grid.low + grid.spacing * grid.shape
    x, y, z = ((float(a), float(b)) for a, b in zip(grid.low, high, strict=True))
    corners = [(a, b, c) for c, b, a in product(z, y, x)]
    corners = [corners[index] for index in (0, 1, 3, 2, 4, 5, 7, 6)]
    vertices = "\n".join(f"    ({a!r} {b!r} {c!r})" for a, b, c in corners)
    count = " ".join(map(str, grid.shape))
    return (
        _foam_head("dictionary", "blockMeshDict")
        + f"scale 1;\n\nvertices\n(\n{vertices}\n);\n\n"
        + f"blocks\n(\n    hex (0 1 2 3 4 5 6 7) ({count}) simpleGrading (1 1 1)\n);\n\n"
        + "edges ();\n\ndefaultPatch\n{\n    name walls;\n    type wall;\n}\n\nboundary ();\n"
    )
