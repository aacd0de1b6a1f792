"""Which walls are near: maps of wall features by cell, and the lists of spheres' walls."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.space.feature_kernels import (
    HALF_DIAGONAL,
    TRIANGLE,
    Features,
    closest_on_triangle,
    out_of_reach,
    wall_gap,
)
from packgen.compiled import inlined, inner_loop, loop

PIECE = 6.0
"""Longest edge, in cells, of the pieces that triangles are looked at in: the box around a long one is mostly
empty."""

STACK = 256

BLOCK = 8


class Grid(NamedTuple):
    """A regular grid of cubes, numbered with z slowest and x fastest.

    Attributes:
        origin: Lower corner [m], shape (3,), float64.
        size: Cell size [m].
        cells: Cells along x, y, z, shape (3,), int64.
    """

    origin: NDArray[np.float64]
    size: float
    cells: NDArray[np.int64]


class FeatureMap(NamedTuple):
    """The wall features near each cell of a grid.

    Attributes:
        grid: The grid, of C cells.
        start: First entry of each cell, shape (C + 1,), int32.
        item: Features, cell by cell, int32; triangles last.
        boundless: The features that are no triangles, int32. A point beyond the grid may be far behind any of
            them, and the cell next to it does not list them all.
    """

    grid: Grid
    start: NDArray[np.int32]
    item: NDArray[np.int32]
    boundless: NDArray[np.int32]


class WallList(NamedTuple):
    """The wall features that each of some spheres can reach.

    Attributes:
        begin: First entry of each sphere, shape (N + 1,), int64.
        item: Features, sphere by sphere, at least ``begin[N]``, int32.
        room: How far the sphere is from each feature when the list is made [m], as long as ``item``, float64.
    """

    begin: NDArray[np.int64]
    item: NDArray[np.int32]
    room: NDArray[np.float64]


@inner_loop
def halved(piece: NDArray[np.float64], longest_max: float, other: NDArray[np.float64]) -> bool:
    """Halve a triangle across its longest edge where that is longer than allowed: one half in place."""
    longest, turn = 0.0, 0
    for k in range(3):
        a, b = 3 * k, 3 * ((k + 1) % 3)
        dx, dy, dz = piece[b] - piece[a], piece[b + 1] - piece[a + 1], piece[b + 2] - piece[a + 2]
        square = dx * dx + dy * dy + dz * dz
        if square > longest:
            longest, turn = square, k
    if longest <= longest_max * longest_max:
        return False
    a, b = 3 * turn, 3 * ((turn + 1) % 3)
    for k in range(9):
        other[k] = piece[k]
    for axis in range(3):
        middle = 0.5 * (piece[a + axis] + piece[b + axis])
        piece[b + axis] = middle
        other[a + axis] = middle
    return True


@inner_loop
def next_piece(
    stack: NDArray[np.float64],
    depth: int,
    grid: Grid,
    reach: float,
    low: NDArray[np.int64],
    high: NDArray[np.int64],
) -> int:
    """Take the next piece of a triangle off a stack; pieces that are too long are halved first.

    Args:
        stack: Pieces [m], shape (STACK, 9); changes. The first ``depth`` of them are still to be taken.
        depth: How many.
        grid: The grid; pieces that reach none of its cells are left out.
        reach: Distance from a piece at which cells count as reached [m].
        low: Out: lowest cell that the piece reaches along each axis, shape (3,).
        high: Out: highest one, shape (3,).

    Returns:
        Number of pieces left, which is also the place of the piece on the stack; -1: there was none.
    """
    while depth > 0:
        if depth < STACK and halved(stack[depth - 1], PIECE * grid.size, stack[depth]):
            depth += 1
            continue
        depth -= 1
        piece = stack[depth]
        outside = False
        for axis in range(3):
            least = min(piece[axis], piece[3 + axis], piece[6 + axis]) - reach - grid.origin[axis]
            most = max(piece[axis], piece[3 + axis], piece[6 + axis]) + reach - grid.origin[axis]
            if most < 0.0 or least > grid.cells[axis] * grid.size:
                outside = True
                break
            low[axis] = max(math.floor(least / grid.size), 0)
            high[axis] = min(math.floor(most / grid.size), grid.cells[axis] - 1)
        if not outside:
            return depth
    return -1


@loop
def map_triangles(corner: NDArray[np.float64], grid: Grid, reach: float):  # type: ignore[no-untyped-def]
    """List for each cell of a grid the triangles closer than ``reach`` to any point of it.

    Args:
        corner: Triangles [m], shape (F, 9) or wider.
        grid: The grid.
        reach: Distance [m].

    Returns:
        (first entry of each cell, int32, shape (cells + 1,); triangles, int32).
    """
    origin, size, cells = grid
    start = np.zeros(cells[0] * cells[1] * cells[2] + 1, np.int32)
    item = np.empty(0, np.int32)
    fill = start
    last = np.full(len(start), -1, np.int32)
    radius = reach + HALF_DIAGONAL * size
    stack = np.empty((STACK, 9))
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for counting in (True, False):
        if not counting:
            for cell in range(len(start) - 1):
                start[cell + 1] += start[cell]
            item = np.empty(start[-1], np.int32)
            fill = start[:-1].copy()
            last[:] = -1
        for f in range(len(corner)):
            stack[0] = corner[f, :9]
            depth = next_piece(stack, 1, grid, radius, low, high)
            while depth >= 0:
                piece = stack[depth]
                gx = (piece[0] + piece[3] + piece[6]) / 3.0
                gy = (piece[1] + piece[4] + piece[7]) / 3.0
                gz = (piece[2] + piece[5] + piece[8]) / 3.0
                wide = 0.0
                for k in range(0, 9, 3):
                    square = (piece[k] - gx) ** 2 + (piece[k + 1] - gy) ** 2 + (piece[k + 2] - gz) ** 2
                    wide = max(wide, square)
                far = (radius + math.sqrt(wide)) ** 2
                for cz in range(low[2], high[2] + 1):
                    z = origin[2] + (cz + 0.5) * size
                    for cy in range(low[1], high[1] + 1):
                        y = origin[1] + (cy + 0.5) * size
                        across = (y - gy) ** 2 + (z - gz) ** 2
                        if across >= far:
                            continue
                        # Of the row, what a ball around the centroid reaches.
                        middle, half = (gx - origin[0]) / size - 0.5, math.sqrt(far - across) / size
                        first = (cz * cells[1] + cy) * cells[0]
                        least_x = max(low[0], math.ceil(middle - half))
                        for cx in range(least_x, min(high[0], math.floor(middle + half)) + 1):
                            cell = first + cx
                            if last[cell] == f:
                                continue
                            x = origin[0] + (cx + 0.5) * size
                            # The distance to the centroid decides nearly always.
                            square = (x - gx) ** 2 + across
                            if square >= radius * radius:
                                px, py, pz = closest_on_triangle(x, y, z, piece)
                                px, py, pz = px - x, py - y, pz - z
                                if px * px + py * py + pz * pz >= radius * radius:
                                    continue
                            last[cell] = f
                            if counting:
                                start[cell + 1] += 1
                            else:
                                item[fill[cell]] = f
                                fill[cell] += 1
                depth = next_piece(stack, depth, grid, radius, low, high)
    return start, item


@loop
def merged_maps(  # type: ignore[no-untyped-def]
    start: NDArray[np.int32],
    item: NDArray[np.int32],
    start_other: NDArray[np.int32],
    item_other: NDArray[np.int32],
):
    """Return two lists by cell as one: (first entry of each cell, entries)."""
    both = start + start_other
    joined = np.empty(len(item) + len(item_other), np.int32)
    for cell in range(len(start) - 1):
        at = both[cell]
        for k in range(start[cell], start[cell + 1]):
            joined[at] = item[k]
            at += 1
        for k in range(start_other[cell], start_other[cell + 1]):
            joined[at] = item_other[k]
            at += 1
    return both, joined


@loop
def map_features(features: Features, grid: Grid, reach: float):  # type: ignore[no-untyped-def]
    """List for each cell of a grid the features closer than ``reach`` to any point of it.

    Blocks of cells come first. Most cells then never look at most features.

    Args:
        features: The features.
        grid: The grid.
        reach: Distance [m].

    Returns:
        (first entry of each cell, int32, shape (cells + 1,); features, int32).
    """
    kind, row = features
    origin, size, cells = grid
    start = np.zeros(cells[0] * cells[1] * cells[2] + 1, np.int32)
    item = np.empty(0, np.int32)
    fill = start
    radius = reach + HALF_DIAGONAL * size
    block_radius = reach + HALF_DIAGONAL * BLOCK * size
    near = np.empty(len(kind), np.int64)
    for counting in (True, False):
        if not counting:
            for cell in range(len(start) - 1):
                start[cell + 1] += start[cell]
            item = np.empty(start[-1], np.int32)
            fill = start[:-1].copy()
        for bz in range(0, cells[2], BLOCK):
            for by in range(0, cells[1], BLOCK):
                for bx in range(0, cells[0], BLOCK):
                    half = 0.5 * BLOCK
                    x = origin[0] + (bx + half) * size
                    y = origin[1] + (by + half) * size
                    z = origin[2] + (bz + half) * size
                    count = 0
                    for feature in range(len(kind)):
                        near[count] = feature
                        count += wall_gap(kind[feature], row[feature], x, y, z, 0.0)[0] < block_radius
                    if count == 0:
                        continue
                    for cz in range(bz, min(bz + BLOCK, cells[2])):
                        for cy in range(by, min(by + BLOCK, cells[1])):
                            for cx in range(bx, min(bx + BLOCK, cells[0])):
                                x = origin[0] + (cx + 0.5) * size
                                y = origin[1] + (cy + 0.5) * size
                                z = origin[2] + (cz + 0.5) * size
                                cell = (cz * cells[1] + cy) * cells[0] + cx
                                for k in range(count):
                                    feature = near[k]
                                    gap = wall_gap(kind[feature], row[feature], x, y, z, 0.0)[0]
                                    if gap < radius:
                                        if counting:
                                            start[cell + 1] += 1
                                        else:
                                            item[fill[cell]] = feature
                                            fill[cell] += 1
    return start, item


@inlined
def cell_of(x: float, y: float, z: float, grid: Grid) -> int:
    """Return the cell that a point lies in; the nearest one of a point outside of the grid."""
    cx = min(max(int((x - grid.origin[0]) / grid.size), 0), grid.cells[0] - 1)
    cy = min(max(int((y - grid.origin[1]) / grid.size), 0), grid.cells[1] - 1)
    cz = min(max(int((z - grid.origin[2]) / grid.size), 0), grid.cells[2] - 1)
    return int((cz * grid.cells[1] + cy) * grid.cells[0] + cx)


@inlined
def count_boundless(x: float, y: float, z: float, near: FeatureMap) -> int:
    """Return how many features concern a point beyond those of its cell: all boundless ones, or none."""
    origin, size, cells = near.grid
    x, y, z = x - origin[0], y - origin[1], z - origin[2]
    within = 0.0 <= x <= size * cells[0] and 0.0 <= y <= size * cells[1] and 0.0 <= z <= size * cells[2]
    return 0 if within else len(near.boundless)


@inlined
def candidate(k: int, low: int, boundless: int, kind: NDArray[np.int8], near: FeatureMap) -> int:
    """Return the k-th feature to look at for a point, or -1.

    Args:
        k: From ``low - boundless`` up to the end of the cell's entries.
        low: First entry of the point's cell.
        boundless: How many features concern the point beyond those of its cell; they come first.
        kind: Kind of each feature, shape (F,), int8.
        near: The map.
    """
    if k < low:
        return int(near.boundless[k - low + boundless])
    feature = int(near.item[k])
    return -1 if boundless > 0 and kind[feature] != TRIANGLE else feature


@loop
def least_gap(
    position: NDArray[np.float64], radius: float, features: Features, near: FeatureMap
) -> NDArray[np.float64]:
    """Return each point's least gap to the features near it, for spheres of one radius [m], shape (N,)."""
    kind, row = features
    gap = np.full(len(position), np.inf)
    for i in range(len(position)):
        x, y, z = position[i, 0], position[i, 1], position[i, 2]
        cell = cell_of(x, y, z, near.grid)
        low, boundless = near.start[cell], count_boundless(x, y, z, near)
        for k in range(low - boundless, near.start[cell + 1]):
            feature = candidate(k, low, boundless, kind, near)
            if feature >= 0 and not out_of_reach(kind[feature], row[feature], x, y, z, radius + gap[i]):
                gap[i] = min(gap[i], wall_gap(kind[feature], row[feature], x, y, z, radius)[0])
    return gap


@inner_loop
def wall_candidates(
    ball: NDArray[np.float64],
    margin: NDArray[np.float64],
    features: Features,
    near: FeatureMap,
    begin: NDArray[np.int64],
    item: NDArray[np.int32],
    room: NDArray[np.float64],
) -> int:
    """List the wall features that each moving sphere can reach before the next rebuild.

    Args:
        ball: Centres and radii [m], shape (N, 4); the first ones move.
        margin: How far each moving sphere moves at most until then [m], shape (moving,).
        features: The features.
        near: Which of them are near.
        begin: Out: first entry of each sphere, shape (moving + 1,).
        item: Out: features.
        room: Out: how far the sphere is from each [m], as long as ``item``.

    Returns:
        Number of entries, or -1 where ``item`` is too short; of triangles a sphere's nearest one comes first.
    """
    kind, row = features
    moving, total = len(margin), 0
    for i in range(moving):
        begin[i] = total
        x, y, z, radius = ball[i, 0], ball[i, 1], ball[i, 2], ball[i, 3]
        cell = cell_of(x, y, z, near.grid)
        low, high = near.start[cell], near.start[cell + 1]
        boundless = count_boundless(x, y, z, near)
        if total + high - low + boundless > len(item):
            return -1
        for k in range(low - boundless, high):
            feature = candidate(k, low, boundless, kind, near)
            if feature < 0 or out_of_reach(kind[feature], row[feature], x, y, z, radius + margin[i]):
                continue
            gap = wall_gap(kind[feature], row[feature], x, y, z, radius)[0]
            if gap < margin[i]:
                item[total] = feature
                room[total] = gap
                if kind[feature] == TRIANGLE and gap < room[begin[i]]:
                    # The nearest first: a rough wall's push goes its way, not that of some far facet.
                    nearest = begin[i]
                    item[total], item[nearest] = item[nearest], feature
                    room[total], room[nearest] = room[nearest], gap
                total += 1
    begin[moving] = total
    return total
