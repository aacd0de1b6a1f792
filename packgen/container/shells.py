"""What the pieces of a mesh are: the vessel's shell, bodies in it, and sheets such as baffles.

A mesh falls into bodies that share no edge. A body that is closed, or open at its own top only and not
within another, is a shell; shells within shells are solid bodies (and hollows in those). Everything else is a
sheet: walls with space on both sides. The volume of a vessel is what its shells enclose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from packgen.arrays import Float64Array, Int64Array, unique_rows
from packgen.container.convex import enclosed_volume
from packgen.container.crossings import (
    _depths,
    _notes,
    _self_crossings,
    _Shell,
    _volume_by_points,
)
from packgen.container.topology import (
    Rim,
    boundary_edges,
    capped,
    find_rim,
    with_consistent_winding,
)
from packgen.geometry import Surface

EMPTY = 1.0e-9
"""Least volume of a shell, as a fraction of its bounding box; a body that encloses less is a sheet."""


@dataclass(frozen=True, eq=False, slots=True)
class Vessel:
    """A mesh, sorted.

    Attributes:
        walls: Its triangles without lids, the shells' normals pointing out of the vessel's inside.
        closed: The same with lids on open tops, sheets on either side: winds once around inside points.
        volume: What it encloses [m3].
        turned: Facets turned to agree with their neighbours.
        shells: Number of shells.
        sheets: Number of sheets.
        notes: A sentence for each thing that may not be what was meant.
    """

    walls: Surface
    closed: Surface
    volume: float
    turned: int
    shells: int
    sheets: int
    notes: tuple[str, ...] = ()


def sorted_vessel(surface: Surface, up: Float64Array) -> Vessel | None:
    """Return what the pieces of a mesh are.

    Args:
        surface: The mesh, without duplicate corners and degenerate facets.
        up: Unit vector against gravity, shape (3,).

    Returns:
        The vessel; None where no shell is closed or open at its top only.

    Raises:
        GeometryError: A shell's facets cannot be wound consistently.
    """
    shells, sheets = _pieces(surface, up)
    if not shells:
        return None
    shells.sort(key=lambda shell: -abs(shell.volume))
    depth, crossing = _depths(shells)
    # An open-topped bowl in a vessel can be filled: it is no solid body.
    bowls = [index for index, shell in enumerate(shells) if shell.lidded and depth[index] > 0]
    if bowls:
        sheets += [shells[index].walls for index in bowls]
        shells = [shell for index, shell in enumerate(shells) if index not in bowls]
        depth, crossing = _depths(shells)
    if _is_larger(sheets, shells):
        return None
    walls, closed, volume = [], [], 0.0
    for shell, level in zip(shells, depth, strict=True):
        outward = level % 2 == 0
        flip = (shell.volume > 0.0) != outward
        walls.append(flipped(shell.walls) if flip else shell.walls)
        closed.append(flipped(shell.closed) if flip else shell.closed)
        volume += abs(shell.volume) if outward else -abs(shell.volume)
    both_sides = [each for sheet in sheets for each in (sheet, flipped(sheet))]
    whole = stacked([*closed, *both_sides])
    notes = _notes(shells, depth, crossing)
    if not crossing:
        notes += _self_crossings(whole)
    if crossing or (notes and len(shells) == 1):
        volume = _volume_by_points(whole)
    return Vessel(
        stacked([*walls, *sheets]), whole, volume,
        sum(shell.turned for shell in shells), len(shells), len(sheets), tuple(notes),
    )  # fmt: skip


def _pieces(surface: Surface, up: Float64Array) -> tuple[list[_Shell], list[Surface]]:
    """Return the shells and sheets of a mesh, not yet told apart by what lies within what."""
    shells: list[_Shell] = []
    sheets: list[Surface] = []
    for body in bodies(surface, manifold=False):
        rest = body
        while len(rest.faces):
            hanging = _hanging(rest, up)
            if not hanging.any():
                break
            loose = Surface(rest.vertices, rest.faces[hanging])
            sheets += bodies(loose, manifold=False)
            rest = Surface(rest.vertices, rest.faces[~hanging])
        parts = bodies(rest, manifold=bool(_branches(rest).any())) if len(rest.faces) else []
        for part in parts:
            shell = shell_of(part, up)
            if shell is None:
                sheets.append(part)
            else:
                shells.append(shell)
    return shells, sheets


def shell_of(part: Surface, up: Float64Array) -> _Shell | None:
    """Return a piece as a shell with its lid; None where it is open, or encloses nothing."""
    rim = find_rim(part, up)
    if (rim is not None and not rim.level) or _branches(part).any():
        return None
    part, turned = with_consistent_winding(part)
    closed = part
    if rim is not None:
        closed = capped(part, Rim(boundary_edges(part), rim.height, rim.level))
    volume = enclosed_volume(closed.vertices, closed.faces)
    box = float(np.ptp(part.vertices, axis=0).max()) ** 3
    if abs(volume) <= EMPTY * box:
        return None
    return _Shell(part, closed, volume, rim is not None, turned)


def _edges(surface: Surface) -> tuple[Int64Array, Int64Array]:
    """Return (number of each face's edges, shape (F, 3); how many faces share each edge, shape (E,))."""
    faces = surface.faces
    ends = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    key = ends[:, 0] * len(surface.vertices) + ends[:, 1]
    _, number, count = np.unique(key, return_inverse=True, return_counts=True)
    return number.reshape(-1, 3), count


def bodies(surface: Surface, *, manifold: bool = False) -> list[Surface]:
    """Return the parts of a surface that hang together by edges; ``manifold``: by edges of two faces only."""
    number, count = _edges(surface)
    face = np.repeat(np.arange(len(number)), 3)
    edge = number.ravel()
    joins = count[edge] == 2 if manifold else np.ones(len(edge), bool)
    size = len(number) + len(count)
    graph = coo_array(
        (np.ones(int(joins.sum()), np.int8), (face[joins], len(number) + edge[joins])), shape=(size, size)
    )
    _, part = connected_components(graph, directed=False)
    part = part[: len(number)]
    if (part == part[0]).all():
        return [surface]
    order = np.argsort(part, kind="stable")
    cuts = np.flatnonzero(np.diff(part[order])) + 1
    return [_compact(surface.vertices, surface.faces[rows]) for rows in np.split(order, cuts)]


def _branches(surface: Surface) -> NDArray[np.bool_]:
    """Tell for each face whether three or more faces meet at one of its edges, shape (F,)."""
    number, count = _edges(surface)
    return np.asarray((count[number] > 2).any(axis=1))


def _hanging(surface: Surface, up: Float64Array) -> NDArray[np.bool_]:
    """Tell which faces belong to sheets attached to a shell: three faces meet at their foot, shape (F,)."""
    number, count = _edges(surface)
    none = np.zeros(len(number), bool)
    if not (count > 2).any():
        return none
    height = surface.vertices @ up
    top = height.max() - 1e-6 * float(np.ptp(surface.vertices, axis=0).max())
    face = np.repeat(np.arange(len(number)), 3)
    edge = number.ravel()
    joins = count[edge] == 2
    size = len(number) + len(count)
    graph = coo_array(
        (np.ones(int(joins.sum()), np.int8), (face[joins], len(number) + edge[joins])), shape=(size, size)
    )
    _, patch = connected_components(graph, directed=False)
    patch = patch[: len(number)]
    ends = surface.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    free = (count[edge] == 1) & (height[ends].min(axis=1) < top)
    hangs = np.zeros(size, bool)
    hangs[patch[face[free]]] = True
    return np.asarray(hangs[patch]) if not hangs[patch].all() else none


def _compact(vertices: Float64Array, faces: Int64Array) -> Surface:
    used, compact = np.unique(faces, return_inverse=True)
    return Surface(vertices[used], compact.reshape(-1, 3))


def flipped(surface: Surface) -> Surface:
    """Return a surface seen from its other side."""
    return Surface(surface.vertices, surface.faces[:, ::-1])


def stacked(surfaces: list[Surface]) -> Surface:
    """Return several surfaces as one; corners at the same place become one again."""
    if len(surfaces) == 1:
        return surfaces[0]
    first = np.cumsum([0, *(len(each.vertices) for each in surfaces)])
    vertices = np.concatenate([each.vertices for each in surfaces])
    faces = np.concatenate([each.faces + start for each, start in zip(surfaces, first, strict=False)])
    keep, back = unique_rows(vertices)
    return Surface(vertices[keep], back[faces])


def _is_larger(sheets: list[Surface], shells: list[_Shell]) -> bool:
    """Tell whether some sheet is larger than all shells: then it is the vessel, and has a hole."""
    extent = max(float(np.linalg.norm(np.ptp(shell.walls.vertices, axis=0))) for shell in shells)
    return any(float(np.linalg.norm(np.ptp(sheet.vertices, axis=0))) > 1.001 * extent for sheet in sheets)
