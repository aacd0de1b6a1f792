"""The named groups of facets of a mesh that meshio reads, such as patches of a volume mesh: parts by name.

Names are those of gmsh's physical surfaces, of sets of cells, or the numbers in an array of cells that tells
surfaces apart. Of a volume mesh the facets on its boundary count, and those inside where they are a part.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.container.meshfile import (
    TRIMESH_SUFFIXES,
    boundary_polygons,
    check_corners,
    clean_surface,
    fans,
    read_file,
    read_with_meshio,
)
from packgen.container.solids import NamedSurfaces, read_solids
from packgen.errors import GeometryError
from packgen.geometry import Surface

PHYSICAL = "gmsh:physical"
ARRAYS = (PHYSICAL, "CellEntityIds", "PhysicalIds", "medit:ref", "cell_tags", "patch", "patchID", "PatchId")
"""Arrays of cells that tell surfaces apart, the first that a file has: gmsh's, and what others write."""

Corners = tuple[int, ...]


def read_named(path: Path, scale: float, place: str, wanted: Sequence[str]) -> NamedSurfaces:
    """Read the solids of a text STL file, or the groups of facets of a mesh that meshio reads.

    Args:
        path: The file.
        scale: Metres a unit of the file.
        place: Where the scene names the file, for messages.
        wanted: Names of the parts.

    Raises:
        GeometryError: The file cannot be read, has nothing by name, or a facet is of two parts.
    """
    if path.suffix.lower() in TRIMESH_SUFFIXES:
        return read_solids(path, scale, place)
    return _read_patches(path, scale, place, wanted)


@dataclass(frozen=True, eq=False, slots=True)
class _Facets:
    """Triangles of a mesh: those that bound it, and where it has volumes those of its groups inside.

    Attributes:
        points: Corners, in the file's unit, shape (N, 3).
        faces: Indices of their corners, shape (F, 3).
        outer: Which bound it, shape (F,).
        groups: Which of them are of each group, by name, shape (F,) each.
    """

    points: Float64Array
    faces: Int64Array
    outer: BoolArray
    groups: dict[str, BoolArray]


def _read_patches(path: Path, scale: float, place: str, wanted: Sequence[str]) -> NamedSurfaces:
    found = read_file(path, place, _load)
    check_corners(path, place, found.points, found.faces)
    if not found.groups:
        raise GeometryError(
            f"{place}: {path.name} has no groups of facets by name, expected physical surfaces of gmsh, sets "
            f"of cells, or an array of cells such as {ARRAYS[1]}; give each of the `walls` a `path`"
        )
    parts = [name for name in wanted if name in found.groups]
    _check_apart(path, place, found, parts)
    left = found.outer.copy()
    surfaces: dict[str, Surface] = {}
    mended: list[str] = []
    for name in [*parts, *(name for name in found.groups if name not in parts)]:
        chosen = found.groups[name] if name in parts else found.groups[name] & left
        left &= ~chosen
        _add(surfaces, mended, name, (found.points * scale, found.faces[chosen]), f"{place}: {path.name}")
    _add(surfaces, mended, "", (found.points * scale, found.faces[left]), f"{place}: {path.name}")
    return NamedSurfaces(surfaces, tuple(found.groups), tuple(mended))


def _add(
    surfaces: dict[str, Surface],
    mended: list[str],
    name: str,
    mesh: tuple[Float64Array, Int64Array],
    place: str,
) -> None:
    """Add a group to surfaces, and what was mended of it to a list, unless it has no facet.

    Raises:
        GeometryError: None of its facets has an area.
    """
    if len(mesh[1]) == 0:
        return
    try:
        surfaces[name], said = clean_surface(*mesh)
    except GeometryError as error:
        raise GeometryError(f"{place}: group {name or 'without a name'}: {error}") from error
    mended += [f"group {name}: {sentence}" for sentence in said]


def _check_apart(path: Path, place: str, found: _Facets, parts: Sequence[str]) -> None:
    """Refuse parts that have facets in common.

    Raises:
        GeometryError: Two have.
    """
    for first, second in combinations(parts, 2):
        shared = int((found.groups[first] & found.groups[second]).sum())
        if shared:
            raise GeometryError(
                f"{place}: {path.name}: {shared} facets are of {first} and of {second}, expected each facet "
                "in one of the `walls`; leave one of them out"
            )


def _load(path: Path) -> _Facets:
    mesh = read_with_meshio(path)
    flat: list[tuple[Corners, tuple[str, ...]]] = []
    for number, block in enumerate(mesh.raw.cells):
        if block.dim == 2:
            names = _names(mesh.raw, number, len(block.data))
            flat += zip(map(tuple, np.asarray(block.data).tolist()), names, strict=True)
    if not mesh.is_volume:
        return _facets(mesh.points, flat, len(flat))
    outer = {tuple(sorted(polygon)): polygon for polygon in boundary_polygons(mesh.cells)}
    known: dict[Corners, tuple[str, ...]] = {}
    inner: dict[Corners, tuple[Corners, tuple[str, ...]]] = {}
    for polygon, of in flat:
        key = tuple(sorted(polygon))
        known[key] = known.get(key, ()) + of
        if key not in outer:
            inner[key] = (polygon, known[key])
    bounding = [(polygon, known.get(key, ())) for key, polygon in outer.items()]
    return _facets(mesh.points, [*bounding, *inner.values()], len(bounding))


def _names(raw: Any, number: int, count: int) -> list[tuple[str, ...]]:
    """Return the names of the groups of each cell of a block.

    Args:
        raw: What meshio read.
        number: Index of the block.
        count: Its cells.
    """
    names: list[tuple[str, ...]] = [()] * count
    for name, blocks in raw.cell_sets.items():
        if name.startswith("gmsh:") or blocks[number] is None:
            continue
        for cell in np.asarray(blocks[number], np.int64).tolist():
            names[cell] += (name,)
    array = next((each for each in ARRAYS if each in raw.cell_data), None)
    if array is None:
        return names
    told = {int(tag): name for name, (tag, dim) in raw.field_data.items() if dim == 2}
    numbers = np.asarray(raw.cell_data[array][number]).reshape(count, -1)[:, 0]
    for cell, tag in enumerate(numbers.tolist()):
        # Gmsh's 0 is no surface; what meshio has as a set already is not named twice.
        if tag == int(tag) and not (array == PHYSICAL and tag == 0):
            name = told.get(int(tag), str(int(tag)))
            names[cell] += (name,) if name not in names[cell] else ()
    return names


def _facets(points: Float64Array, polygons: Sequence[tuple[Corners, tuple[str, ...]]], outer: int) -> _Facets:
    """Return polygons as triangles, of which so many of the first polygons bound the mesh."""
    table = fans([polygon for polygon, _ in polygons])
    groups: dict[str, BoolArray] = {}
    for index, (_, names) in enumerate(polygons):
        for name in names:
            groups.setdefault(name, np.zeros(len(polygons), np.bool_))[index] = True
    source = table[:, 0]
    return _Facets(
        points, table[:, 1:], source < outer, {name: chosen[source] for name, chosen in groups.items()}
    )
