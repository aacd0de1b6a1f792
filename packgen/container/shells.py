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
from packgen.container.topology import (
    Rim,
    boundary_edges,
    capped,
    find_rim,
    with_consistent_winding,
)
from packgen.geometry import Surface

SAMPLES = 128
"""Points of a body that are looked at to tell whether it lies within another."""

STRICTLY = 0.9
"""Winding number beyond which such a point is within: on the other's surface it is less."""

ANGLES = 10_000_000
POINTS = (64, 2048)
"""Solid angles, and points at least and at most, that tell whether a surface crosses itself."""

VOLUME_POINTS = 20_000

EMPTY = 1.0e-9
"""A shell that encloses less than this fraction of its bounding box is a sheet."""


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


@dataclass(frozen=True, eq=False, slots=True)
class _Shell:
    walls: Surface
    closed: Surface
    volume: float
    lidded: bool
    turned: int


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
        walls.append(_flipped(shell.walls) if flip else shell.walls)
        closed.append(_flipped(shell.closed) if flip else shell.closed)
        volume += abs(shell.volume) if outward else -abs(shell.volume)
    both_sides = [each for sheet in sheets for each in (sheet, _flipped(sheet))]
    whole = _stacked([*closed, *both_sides])
    notes = _notes(shells, depth, crossing)
    if not crossing:
        notes += _self_crossings(whole)
    if crossing or (notes and len(shells) == 1):
        volume = _volume_by_points(whole)
    return Vessel(
        _stacked([*walls, *sheets]), whole, volume,
        sum(shell.turned for shell in shells), len(shells), len(sheets), tuple(notes),
    )  # fmt: skip


def _pieces(surface: Surface, up: Float64Array) -> tuple[list[_Shell], list[Surface]]:
    """Return the shells and sheets of a mesh, not yet told apart by what lies within what."""
    shells: list[_Shell] = []
    sheets: list[Surface] = []
    for body in _bodies(surface, manifold=False):
        rest = body
        while len(rest.faces):
            hanging = _hanging(rest, up)
            if not hanging.any():
                break
            loose = Surface(rest.vertices, rest.faces[hanging])
            sheets += _bodies(loose, manifold=False)
            rest = Surface(rest.vertices, rest.faces[~hanging])
        parts = _bodies(rest, manifold=bool(_branches(rest).any())) if len(rest.faces) else []
        for part in parts:
            shell = _shell(part, up)
            if shell is None:
                sheets.append(part)
            else:
                shells.append(shell)
    return shells, sheets


def _shell(part: Surface, up: Float64Array) -> _Shell | None:
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


def _bodies(surface: Surface, *, manifold: bool) -> list[Surface]:
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


def _flipped(surface: Surface) -> Surface:
    return Surface(surface.vertices, surface.faces[:, ::-1])


def _stacked(surfaces: list[Surface]) -> Surface:
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


def _depths(shells: list[_Shell]) -> tuple[list[int], list[int]]:
    """Return within how many larger shells each one lies, at least in part, and which reach out of one."""
    from packgen.arrange.kernels.inside import winding_numbers

    depth, crossing = [0] * len(shells), []
    for index, shell in enumerate(shells):
        points = _spread_points(shell.walls)
        for larger in shells[:index]:
            low, high = larger.closed.vertices.min(axis=0), larger.closed.vertices.max(axis=0)
            near = ((points > low) & (points < high)).all(axis=1)
            if near.any():
                corner = larger.closed.vertices[larger.closed.faces].reshape(-1, 9)
                winding = np.abs(winding_numbers(corner, points[near]))
                if (winding > STRICTLY).any():
                    depth[index] += 1
                    beyond = ((points < low) | (points > high)).any(axis=1)
                    if beyond.any() or (winding < 1.0 - STRICTLY).any():
                        crossing.append(index)
    return depth, crossing


def _spread_points(surface: Surface) -> Float64Array:
    """Return `SAMPLES` points of a surface, as many on any part of it as its area has (N, 3) [m]."""
    corners = surface.vertices[surface.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    rng = np.random.default_rng(0)
    a, b, c = np.moveaxis(corners[rng.choice(len(corners), SAMPLES, p=area / area.sum())], 1, 0)
    first, second = rng.random((2, SAMPLES, 1))
    folded = first + second > 1.0
    first, second = np.where(folded, 1.0 - first, first), np.where(folded, 1.0 - second, second)
    points: Float64Array = a + first * (b - a) + second * (c - a)
    return points


def _notes(shells: list[_Shell], depth: list[int], crossing: list[int]) -> list[str]:
    """Return a sentence for each shell that may not be what was meant."""
    separate = depth.count(0)
    notes = []
    if separate > 1:
        notes.append(
            f"{separate} separate shells: each of them will be filled; remove from the file what is no vessel"
        )
    for index in crossing:
        x, y, z = shells[index].walls.vertices.mean(axis=0)
        notes.append(
            f"the shell around x={x:.4g} y={y:.4g} z={z:.4g} m crosses a larger one and counts as a solid "
            "body (a lance, a tube); if both are one vessel, unite them"
        )
    return notes


def _self_crossings(closed: Surface) -> list[str]:
    """Return a sentence where a surface winds round points twice or backwards, as one that crosses itself."""
    from packgen.arrange.kernels.inside import winding_numbers

    low, high = closed.vertices.min(axis=0), closed.vertices.max(axis=0)
    count = int(np.clip(ANGLES // len(closed.faces), *POINTS))
    points = low + np.random.default_rng(0).random((count, 3)) * (high - low)
    winding = winding_numbers(closed.vertices[closed.faces].reshape(-1, 9), points)
    wrong = (winding < -0.75) | (winding > 1.75)
    if not wrong.any():
        return []
    x, y, z = points[wrong].mean(axis=0)
    return [
        f"the surface crosses itself, such as around x={x:.4g} y={y:.4g} z={z:.4g} m: {wrong.mean():.1%} of "
        "its bounding box is inside twice, or inside out and taken as outside; repair it"
    ]


def _volume_by_points(closed: Surface) -> float:
    """Return the volume [m3] of the points that a surface winds round, to about 1 %."""
    from packgen.check.inside import inside

    low, high = closed.vertices.min(axis=0), closed.vertices.max(axis=0)
    points = low + np.random.default_rng(0).random((VOLUME_POINTS, 3)) * (high - low)
    return float(inside(closed.vertices[closed.faces], points).mean() * np.prod(high - low))
