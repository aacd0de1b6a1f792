"""The neighbour list: cells sorted in memory, one grid a range of radii, every pair owned by one sphere.

A pair is owned by the sphere of the coarser grid level (within a level by the one that comes first): the few
large spheres look for the many small ones around them. Owners that move come first, fixed owners (a large
fixed sphere under small moving ones) after them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.compiled import inlined, inner_loop

LEVELS_MAX = 40

SLICES = 4
"""Width of a cell across x over that along x: a row of cells is one range, which then ends near the reach."""

LEVEL_RATIO = 4.0
"""Largest to smallest radius of a level: finer levels have fewer candidates in more and emptier cells."""


class LevelGrids(NamedTuple):
    """One grid a range of radii (a level), the largest radii first; cells are numbered through all levels.

    Attributes:
        box: Lowest and highest centre coordinates and the largest radius [m], shape (7,), float64.
        reach: Largest reach of each level [m], shape (L,), float64.
        size: Cell size along y and z [m], shape (L,), float64; along x cells are ``SLICES`` times narrower.
        cells: Cells along each axis, shape (L, 3), int64.
        first: First cell of each level, shape (L + 1,), int64.
    """

    box: NDArray[np.float64]
    reach: NDArray[np.float64]
    size: NDArray[np.float64]
    cells: NDArray[np.int64]
    first: NDArray[np.int64]


class SortedSpheres(NamedTuple):
    """Spheres by level and cell, those that move before those that are fixed.

    Attributes:
        ball: Centres and radii [m], shape (N, 4), float64.
        reach: A pair is close when closer than the sum of these [m], shape (N,), float64.
        level: Level of each, shape (N,), int8.
    """

    ball: NDArray[np.float64]
    reach: NDArray[np.float64]
    level: NDArray[np.int8]


class CellStarts(NamedTuple):
    """Where each of the C cells begins among sorted spheres.

    Attributes:
        moving: First moving sphere of each cell, shape (C + 1,), int32.
        fixed: First fixed sphere of each cell, counted from the first fixed one, shape (C + 1,), int32.
    """

    moving: NDArray[np.int32]
    fixed: NDArray[np.int32]


class Pairs(NamedTuple):
    """A neighbour list: P pairs of spheres that are close, each once.

    Attributes:
        owner: The sphere that owns each pair, shape (P,), int32.
        neighbor: The other one, shape (P,) or longer, int32.
    """

    owner: NDArray[np.int32]
    neighbor: NDArray[np.int32]


@inner_loop
def bounding_box(ball: NDArray[np.float64], count: int) -> NDArray[np.float64]:
    """Return lowest and highest centre coordinates and the largest radius, shape (7,)."""
    box = np.empty(7)
    for axis in range(3):
        box[axis] = 1e300
        box[3 + axis] = -1e300
    box[6] = 0.0
    for i in range(count):
        for axis in range(3):
            box[axis] = min(box[axis], ball[i, axis])
            box[3 + axis] = max(box[3 + axis], ball[i, axis])
        box[6] = max(box[6], ball[i, 3])
    return box


@inner_loop
def level_grids(  # type: ignore[no-untyped-def]
    ball: NDArray[np.float64], reach: NDArray[np.float64]
):
    """Lay one grid a range of radii over the spheres, the largest first.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        reach: Radius and margin of each sphere [m], shape (N,).

    Returns:
        (the grids, level of each sphere (N,) int8).
    """
    count = len(ball)
    box = bounding_box(ball, count)
    level = np.zeros(count, np.int8)
    members = np.zeros(LEVELS_MAX, np.int64)
    reaches = np.zeros(LEVELS_MAX)
    radius_max = box[6]
    for i in range(count):
        grade = 0
        edge = radius_max / LEVEL_RATIO
        while ball[i, 3] <= edge and grade < LEVELS_MAX - 1:
            edge /= LEVEL_RATIO
            grade += 1
        level[i] = grade
        members[grade] += 1
        reaches[grade] = max(reaches[grade], reach[i])
    levels = 1
    for grade in range(LEVELS_MAX):
        if members[grade] > 0:
            levels = grade + 1
    size = np.empty(levels)
    cells = np.empty((levels, 3), np.int64)
    first = np.zeros(levels + 1, np.int64)
    extent = np.empty(3)
    for axis in range(3):
        extent[axis] = box[3 + axis] - box[axis]
    for grade in range(levels):
        size[grade] = 2.0 * reaches[grade] * (1.0 + 1e-9)
        # Few small spheres in a large box: wider cells keep the grid in proportion to its members.
        budget = SLICES * (4.0 * members[grade] + 64.0)
        while members[grade] > 0:
            total = 1.0
            for axis in range(3):
                total *= math.floor(extent[axis] / size[grade] * (SLICES if axis == 0 else 1)) + 1.0
            if total <= budget:
                break
            size[grade] *= 1.26
        if members[grade] == 0:
            size[grade] = 1e300  # one cell that everything lies in
        for axis in range(3):
            # By the same product as a sphere's cell is: a quotient may round to one cell less.
            inverse = (1.0 / size[grade]) * (SLICES if axis == 0 else 1)
            cells[grade, axis] = int(extent[axis] * inverse) + 1
        first[grade + 1] = first[grade] + cells[grade, 0] * cells[grade, 1] * cells[grade, 2]
    return LevelGrids(box, reaches[:levels], size, cells, first), level


@inner_loop
def cell_keys(  # type: ignore[no-untyped-def]
    ball: NDArray[np.float64], level: NDArray[np.int8], grids: LevelGrids
):
    """Return (first slot of each cell, order by cell) of spheres (N, 4) of some levels (N,)."""
    box, _, size, cells, first = grids
    count = len(ball)
    key = np.empty(count, np.int32)
    start = np.zeros(first[-1] + 1, np.int32)
    for i in range(count):
        grade = level[i]
        inverse = 1.0 / size[grade]
        cx = int((ball[i, 0] - box[0]) * (inverse * SLICES))
        cy = int((ball[i, 1] - box[1]) * inverse)
        cz = int((ball[i, 2] - box[2]) * inverse)
        key[i] = first[grade] + (cz * cells[grade, 1] + cy) * cells[grade, 0] + cx
        start[key[i] + 1] += 1
    for cell in range(first[-1]):
        start[cell + 1] += start[cell]
    order = np.empty(count, np.int32)
    fill = start[:-1].copy()
    for i in range(count):
        order[fill[key[i]]] = i
        fill[key[i]] += 1
    return start, order


@inlined
def append_range(  # type: ignore[no-untyped-def]
    ball: NDArray[np.float64],
    reach: NDArray[np.float64],
    i: int,
    begin: int,
    end: int,
    neighbor: NDArray[np.int32],
    total: int,
):
    """Append the spheres of ``begin:end`` in reach of sphere i; written without a branch to mispredict."""
    x, y, z, own = ball[i, 0], ball[i, 1], ball[i, 2], reach[i]
    for candidate in range(begin, end):
        j = np.uint64(candidate)  # unsigned: no code for negative indices
        dx = x - ball[j, 0]
        dy = y - ball[j, 1]
        dz = z - ball[j, 2]
        both = own + reach[j]
        neighbor[np.uint64(total)] = candidate
        total += dx * dx + dy * dy + dz * dz < both * both
    return total


@inlined
def beyond(value: float, low: float, width: float) -> float:
    """Return how far a coordinate is outside of ``low`` to ``low + width``, 0 inside."""
    return max(low - value, value - low - width, 0.0)


@inner_loop
def fill_list(
    spheres: SortedSpheres,
    moving: int,
    grids: LevelGrids,
    starts: CellStarts,
    owners: NDArray[np.int32],
    begin: NDArray[np.int64],
    neighbor: NDArray[np.int32],
) -> int:
    """Fill the neighbour list of spheres that lie sorted by level and cell, moving ones first.

    Args:
        spheres: The spheres.
        moving: How many of them move.
        grids: Of ``level_grids``.
        starts: Of ``cell_keys``.
        owners: The spheres whose pairs are listed, shape (O,); see ``pair_owners``.
        begin: Out: first list entry of each owner, shape (O + 1,).
        neighbor: Out: the other sphere of each pair.

    Returns:
        Number of pairs, or -1 where ``neighbor`` is too short.
    """
    ball, reach, level = spheres
    box, reaches, size, cells, first = grids
    start_moving, start_fixed = starts
    total = 0
    capacity, levels = len(neighbor), len(size)
    for each in range(len(owners)):
        begin[each] = total
        i = int(owners[each])
        own = level[i]
        x, y, z = ball[i, 0], ball[i, 1], ball[i, 2]
        fixed_owner = i >= moving
        for grade in range(own + fixed_owner, levels):
            some_move = start_moving[first[grade]] < start_moving[first[grade + 1]]
            some_rest = not fixed_owner and start_fixed[first[grade]] < start_fixed[first[grade + 1]]
            if not (some_move or some_rest):
                continue
            width = size[grade]
            inverse = 1.0 / width
            nx, ny, nz = cells[grade, 0], cells[grade, 1], cells[grade, 2]
            both = (reach[i] + reaches[grade]) * (1.0 + 1e-9)
            z_low, z_high = cell_range(z - box[2], both, inverse, nz)
            y_low, y_high = cell_range(y - box[1], both, inverse, ny)
            x_low, x_high = cell_range(x - box[0], both, inverse * SLICES, nx)
            cy, cz = 0, 0
            if grade == own:
                cy, cz = int((y - box[1]) * inverse), int((z - box[2]) * inverse)
            for dz in range(z_low, z_high + 1):
                plane = first[grade] + dz * ny * nx
                plane_end = plane + ny * nx
                # Within a level half of the neighbouring cells will do: the other half owns the pair.
                movers = dz >= cz and start_moving[plane] < start_moving[plane_end]
                rests = some_rest and start_fixed[plane] < start_fixed[plane_end]
                if not (movers or rests):
                    continue
                left = both * both - beyond(z - box[2], dz * width, width) ** 2
                for dy in range(y_low, y_high + 1):
                    row = plane + dy * nx
                    if grade > own:
                        # Around a large sphere only the small ones' cells within its reach.
                        chord = left - beyond(y - box[1], dy * width, width) ** 2
                        if chord < 0.0:
                            continue
                        x_low, x_high = cell_range(x - box[0], math.sqrt(chord), inverse * SLICES, nx)
                    if movers and (dz > cz or dy >= cy):
                        low, high = start_moving[row + x_low], start_moving[row + x_high + 1]
                        if grade == own:
                            low = max(low, i + 1)
                        if total + high - low >= capacity:
                            return -1
                        total = append_range(ball, reach, i, low, high, neighbor, total)
                    if rests:
                        low = moving + start_fixed[row + x_low]
                        high = moving + start_fixed[row + x_high + 1]
                        if total + high - low >= capacity:
                            return -1
                        total = append_range(ball, reach, i, low, high, neighbor, total)
    begin[len(owners)] = total
    return total


@inlined
def cell_range(value: float, reach: float, inverse: float, count: int) -> tuple[int, int]:
    """Return the first and last of ``count`` cells within a reach of a coordinate."""
    return max(int((value - reach) * inverse), 0), min(int((value + reach) * inverse), count - 1)
