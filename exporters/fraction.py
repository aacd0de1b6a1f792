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
from pydantic import BaseModel, ConfigDict, Field, FilePath, model_validator

from exporters.fields import grid_cells as cells
from exporters.fields import mesh_cells as meshcells
from exporters.protocol import Outlook
from exporters.shared import deck, table, vtkxml
from packgen.bed import Bed, with_images
from packgen.errors import ExportError

NAME = "fraction"
NEEDS = ("walls",)
CELL_DIAMETERS = 3.0  # least size of a cell for unresolved CFD-DEM [mean diameters]
CELLS_MAX = 50_000_000
SHARE_ERROR = 1.0e-6  # of the spheres' volume

Float64Array = NDArray[np.float64]


class Options(BaseModel):
    """Options of the field.

    Attributes:
        cell_size: Size of the grid's cells [m], made a little smaller where the container's size is no
            multiple of it; None: three mean diameters.
        mesh: A mesh to take instead of a grid.
        scale: Metres in one unit of the mesh.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    cell_size: float | None = Field(default=None, gt=0)
    mesh: FilePath | None = None
    scale: float = Field(default=1.0, gt=0)

    @model_validator(mode="after")
    def _one_or_the_other(self) -> Options:
        if self.mesh is not None and self.cell_size is not None:
            raise ValueError("cell_size is of a grid, mesh takes the place of one; leave one of them out")
        if self.mesh is None and "scale" in self.model_fields_set:
            raise ValueError("scale is of a mesh; give mesh=FILE, or leave scale out")
        return self


@dataclass(frozen=True, eq=False, slots=True)
class Grid:
    """A regular grid: lower corner and size of a cell [m], each of shape (3,), and cells along x, y, z."""

    low: Float64Array
    spacing: Float64Array
    shape: tuple[int, int, int]


def write(bed: Bed, folder: Path, options: Options) -> list[Path]:
    """Write the field of a bed into an existing folder and return the paths of its files.

    Raises:
        ExportError: The bed is empty; the mesh cannot be read or has cells of another kind; or the mesh does
            not fit the bed: it holds no sphere, or more than there is.
    """
    deck.check_exportable(bed, NAME, NEEDS)
    position, radius = with_images(bed)
    (folder / "0").mkdir(exist_ok=True)
    if options.mesh is not None:
        field = mesh_field(position, radius, options.mesh, options.scale)
        _check_share(options.mesh, field, bed)
        paths, volume = _write_mesh(field, folder), float(field.volume.sum())
    else:
        paths, volume = _write_grid(bed, position, radius, folder, options.cell_size)
    solid = solid_volume(bed)
    sums = {"spheres_volume": solid, "volume_in_cells": volume, "share_in_cells": volume / solid}
    paths.append(deck.write_text(folder / "fraction.json", json.dumps(sums, indent=2) + "\n"))
    return paths


def check_outlook(outlook: Outlook, options: Options) -> None:
    """Refuse a grid of too many cells, and a mesh that cannot be read or lies beside the container.

    Raises:
        ExportError: The grid has too many cells, or the mesh cannot be used.
    """
    bounds = outlook.container.bounds
    if options.mesh is not None:
        points, _ = _read_mesh(options.mesh, options.scale)
        if (points.max(axis=0) <= bounds[0]).any() or (points.min(axis=0) >= bounds[1]).any():
            raise _beside(options.mesh, points, bounds)
    elif options.cell_size is not None:
        _grid(bounds, options.cell_size)
    else:  # the largest spheres make the largest cells
        _grid(bounds, CELL_DIAMETERS * 2 * outlook.radius_max)


def choose_grid(bed: Bed, cell_size: float | None) -> Grid:
    """Return a grid of about cubic cells over the container.

    Raises:
        ExportError: It would have more than `CELLS_MAX` cells.
    """
    size = CELL_DIAMETERS * 2 * float(bed.radius.mean()) if cell_size is None else cell_size
    return _grid(bed.container.bounds, size)


def _grid(bounds: Float64Array, size: float) -> Grid:
    low, high = bounds
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
    solid = _tidy((volume / grid.spacing.prod()).ravel(order="F"))
    (folder / "system").mkdir(exist_ok=True)
    paths = [
        _write_image(folder / "fraction.vti", grid, solid),
        _write_foam_field(folder / "0" / "voidfraction", 1 - solid),
        deck.write_text(folder / "system" / "blockMeshDict", _block_mesh(grid, bed.container.periodic)),
    ]
    return paths, float(volume.sum())


@dataclass(frozen=True, eq=False, slots=True)
class MeshField:
    """The volume of spheres in the cells of a mesh.

    Attributes:
        points: The mesh's points [m], shape (P, 3).
        blocks: Kind and points of the cells, block by block.
        volume: Volume of spheres in each cell [m3], shape (C of all blocks,).
        of_cell: Volume of each cell [m3].
    """

    points: Float64Array
    blocks: list[tuple[str, NDArray[np.int64]]]
    volume: Float64Array
    of_cell: Float64Array


def mesh_field(position: Float64Array, radius: Float64Array, path: Path, scale: float) -> MeshField:
    """Return the volume of spheres (N, 3), (N,) [m] in the cells of a mesh with ``scale`` metres a unit.

    Raises:
        ExportError: The mesh cannot be read, has cells of another kind, or one without volume.
    """
    points, blocks = _read_mesh(path, scale)
    try:
        both = [meshcells.mesh_volumes(position, radius, kind, points[cells]) for kind, cells in blocks]
    except ValueError as error:
        raise ExportError(f"{NAME}: mesh: {path}: {error}; mend the mesh") from error
    volume, of_cell = (np.concatenate([each[part] for each in both]) for part in range(2))
    return MeshField(points, blocks, volume, of_cell)


def _read_mesh(path: Path, scale: float) -> tuple[Float64Array, list[tuple[str, NDArray[np.int64]]]]:
    """Return the points [m], shape (P, 3), and the kind and points of the cells, block by block.

    Raises:
        ExportError: The mesh cannot be read, or has cells of another kind.
    """
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
    return points, [(block.type, block.data) for block in blocks]


def solid_volume(bed: Bed) -> float:
    """Return the volume of a bed's spheres [m3]."""
    return 4 / 3 * np.pi * float((bed.radius**3).sum())


def _check_share(path: Path, field: MeshField, bed: Bed) -> None:
    """Raise an ExportError where a mesh does not fit the bed."""
    share = float(field.volume.sum()) / solid_volume(bed)
    if share > 1 + SHARE_ERROR:
        raise ExportError(
            f"{NAME}: mesh: {path}: its cells hold {share:.6g} times the spheres' volume: some overlap, are "
            "there twice, or reach beyond a periodic side; mend the mesh"
        )
    if share == 0:
        raise _beside(path, field.points, bed.container.bounds)


def _beside(path: Path, points: Float64Array, bounds: Float64Array) -> ExportError:
    low, high, container_low, container_high = (
        np.array2string(each, precision=4) for each in (points.min(0), points.max(0), *bounds)
    )
    return ExportError(
        f"{NAME}: mesh: {path}: no sphere is in it: it goes from {low} to {high} m, the container from "
        f"{container_low} to {container_high} m; is fraction.scale right?"
    )


def _tidy(solid: Float64Array) -> Float64Array:
    """Return solid fractions clipped to 0 to 1, which rounding may leave slightly."""
    solid = np.maximum(solid, 0.0)
    solid[np.abs(solid - 1.0) < 1e-9] = 1.0
    return solid


def _write_mesh(field: MeshField, folder: Path) -> list[Path]:
    solid = _tidy(field.volume / field.of_cell)
    data = {"solid_fraction": solid, "void_fraction": 1 - solid}
    return [
        vtkxml.write_unstructured(folder / "fraction.vtu", field.points, field.blocks, cell_data=data),
        _write_foam_field(folder / "0" / "voidfraction", 1 - solid),
    ]


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
    # Cyclic, empty and other constraint patches get their own types, by OpenFOAM's own table.
    foot = (
        ')\n;\n\nboundaryField\n{\n    #includeEtc "caseDicts/setConstraintTypes"\n\n'
        '    ".*"\n    {\n        type zeroGradient;\n    }\n}\n'
    )
    return table.write_rows(path, [values], head=head, foot=foot)


def _block_mesh(grid: Grid, periodic: tuple[bool, bool, bool]) -> str:
    """Return the dictionary of one block whose cells blockMesh numbers along x first, as the field is."""
    high = grid.low + grid.spacing * grid.shape
    x, y, z = ((float(a), float(b)) for a, b in zip(grid.low, high, strict=True))
    corners = [(a, b, c) for c, b, a in product(z, y, x)]
    corners = [corners[index] for index in (0, 1, 3, 2, 4, 5, 7, 6)]
    vertices = "\n".join(f"    ({a!r} {b!r} {c!r})" for a, b, c in corners)
    count = " ".join(map(str, grid.shape))
    sides = ["(0 4 7 3)", "(1 2 6 5)"], ["(0 1 5 4)", "(3 7 6 2)"], ["(0 3 2 1)", "(4 5 6 7)"]
    cyclic = "".join(
        f"    {axis}_{end}\n    {{\n        type cyclic;\n        neighbourPatch {axis}_{other};\n"
        f"        faces ({faces[place]});\n    }}\n"
        for axis, faces, wraps in zip("xyz", sides, periodic, strict=True)
        if wraps
        for place, (end, other) in enumerate((("low", "high"), ("high", "low")))
    )
    return (
        _foam_head("dictionary", "blockMeshDict")
        + f"scale 1;\n\nvertices\n(\n{vertices}\n);\n\n"
        + f"blocks\n(\n    hex (0 1 2 3 4 5 6 7) ({count}) simpleGrading (1 1 1)\n);\n\n"
        + "edges ();\n\ndefaultPatch\n{\n    name walls;\n    type wall;\n}\n\n"
        + f"boundary\n(\n{cyclic});\n"
    )
