"""The neighbour list: cells sorted in memory, one grid an octave of radius, every pair owned by one sphere.

A pair is owned by the sphere of the finer grid level (within a level by the one that comes first), whose
contacts lie together. Owners that move come first, fixed owners (a small fixed sphere under a large moving
one) after them.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

LEVELS_MAX = 40


@njit(cache=True, error_model="numpy")
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


@njit(cache=True, error_model="numpy")
def level_grids(  # type: ignore[no-untyped-def]
    ball: NDArray[np.float64], count: int, skin: float
):
    """Lay one grid an octave of radius over the spheres.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        count: How many of them to look at.
        skin: Relative reach beyond touching that the list has to cover.

    Returns:
        (box (7,), level of each sphere (N,) int8, cell size (L,), cells along each axis (L, 3),
        first cell of each level (L + 1,)).
    """
    box = bounding_box(ball, count)
    level = np.zeros(count, np.int8)
    members = np.zeros(LEVELS_MAX, np.int64)
    radius_max = box[6]
    for i in range(count):
        octave = 0
        edge = 0.5 * radius_max
        while ball[i, 3] <= edge and octave < LEVELS_MAX - 1:
            edge *= 0.5
            octave += 1
        level[i] = octave
        members[octave] += 1
    levels = 1
    for octave in range(LEVELS_MAX):
        if members[octave] > 0:
            levels = octave + 1
    size = np.empty(levels)
    cells = np.empty((levels, 3), np.int64)
    first = np.zeros(levels + 1, np.int64)
    extent = np.empty(3)
    for axis in range(3):
        extent[axis] = box[3 + axis] - box[axis]
    for octave in range(levels):
        size[octave] = 2.0 * radius_max * 0.5**octave * (1.0 + 0.5 * skin) * (1.0 + 1e-9)
        # Few small spheres in a large box: wider cells keep the grid in proportion to its members.
        budget = 4.0 * members[octave] + 64.0
        while True:
            total = 1.0
            for axis in range(3):
                total *= math.floor(extent[axis] / size[octave]) + 1.0
            if total <= budget or members[octave] == 0:
                break
            size[octave] *= 1.26
        if members[octave] == 0:
            size[octave] = 1e300  # one cell that everything lies in
        for axis in range(3):
            # By the same product as a sphere's cell is: a quotient may round to one cell less.
            cells[octave, axis] = int(extent[axis] * (1.0 / size[octave])) + 1
        first[octave + 1] = first[octave] + cells[octave, 0] * cells[octave, 1] * cells[octave, 2]
    return box, level, size, cells, first


@njit(cache=True, error_model="numpy")
def cell_keys(  # type: ignore[no-untyped-def]
    ball: NDArray[np.float64],
    begin: int,
    end: int,
    box: NDArray[np.float64],
    level: NDArray[np.int8],
    size: NDArray[np.float64],
    cells: NDArray[np.int64],
    first: NDArray[np.int64],
):
    """Return the cell of each sphere in ``begin:end``, the first slot of each cell, and the sorted order."""
    count = end - begin
    key = np.empty(count, np.int32)
    start = np.zeros(first[-1] + 1, np.int32)
    for i in range(count):
        octave = level[begin + i]
        inverse = 1.0 / size[octave]
        cx = int((ball[begin + i, 0] - box[0]) * inverse)
        cy = int((ball[begin + i, 1] - box[1]) * inverse)
        cz = int((ball[begin + i, 2] - box[2]) * inverse)
        key[i] = first[octave] + (cz * cells[octave, 1] + cy) * cells[octave, 0] + cx
        start[key[i] + 1] += 1
    for cell in range(first[-1]):
        start[cell + 1] += start[cell]
    order = np.empty(count, np.int32)
    fill = start[:-1].copy()
    for i in range(count):
        order[fill[key[i]]] = i
        fill[key[i]] += 1
    return key, start, order


@njit(cache=True, error_model="numpy", inline="always")
def append_range(  # type: ignore[no-untyped-def]
    ball: NDArray[np.float64],
    i: int,
    begin: int,
    end: int,
    grow: float,
    neighbor: NDArray[np.int32],
    total: int,
):
    """Append the spheres of ``begin:end`` in reach of sphere i; written without a branch to mispredict."""
    x, y, z, radius = ball[i, 0], ball[i, 1], ball[i, 2], ball[i, 3]
    for candidate in range(begin, end):
        j = np.uint64(candidate)  # unsigned: no code for negative indices
        dx = x - ball[j, 0]
        dy = y - ball[j, 1]
        dz = z - ball[j, 2]
        reach = (radius + ball[j, 3]) * grow
        neighbor[np.uint64(total)] = candidate
        total += dx * dx + dy * dy + dz * dz < reach * reach
    return total


@njit(cache=True, error_model="numpy")
def fill_list(
    ball: NDArray[np.float64],
    moving: int,
    owners: int,
    skin: float,
    box: NDArray[np.float64],
    level: NDArray[np.int8],
    size: NDArray[np.float64],
    cells: NDArray[np.int64],
    first: NDArray[np.int64],
    start_moving: NDArray[np.int32],
    start_fixed: NDArray[np.int32],
    begin: NDArray[np.int64],
    neighbor: NDArray[np.int32],
) -> int:
    """Fill the neighbour list of spheres that lie sorted by level and cell, moving ones first.

    Args:
        ball: Centres and radii [m], shape (N, 4), sorted.
        moving: How many of them move.
        owners: How many can own pairs: the moving ones, or all where there is more than one level.
        skin: A pair is listed when closer than (1 + skin / 2) times the sum of its radii.
        box: Of ``level_grids``.
        level: Of ``level_grids``, in sorted order.
        size: Of ``level_grids``.
        cells: Of ``level_grids``.
        first: Of ``level_grids``.
        start_moving: First moving sphere of each cell.
        start_fixed: First fixed sphere of each cell, counted from ``moving``.
        begin: Out: first list entry of each owner, shape (owners + 1,).
        neighbor: Out: the other sphere of each pair.

    Returns:
        Number of pairs, or -1 where ``neighbor`` is too short.
    """
    grow = 1.0 + 0.5 * skin
    total = 0
    capacity = len(neighbor)
    for i in range(owners):
        begin[i] = total
        own = level[i]
        fixed_owner = i >= moving
        for octave in range(own, -1, -1):
            if fixed_owner and octave == own:
                continue
            if start_moving[first[octave]] == start_moving[first[octave + 1]] and fixed_owner:
                continue
            nx, ny, nz = cells[octave, 0], cells[octave, 1], cells[octave, 2]
            inverse = 1.0 / size[octave]
            cx = int((ball[i, 0] - box[0]) * inverse)
            cy = int((ball[i, 1] - box[1]) * inverse)
            cz = int((ball[i, 2] - box[2]) * inverse)
            x_low, x_high = max(cx - 1, 0), min(cx + 1, nx - 1)
            z_low, z_high = max(cz - 1, 0), min(cz + 1, nz - 1)
            y_low, y_high = max(cy - 1, 0), min(cy + 1, ny - 1)
            # Within a level half of the neighbouring cells will do: the other half owns the pair.
            for dz in range(cz if octave == own else z_low, z_high + 1):
                plane = first[octave] + dz * ny * nx
                if start_moving[plane] == start_moving[plane + ny * nx]:
                    continue
                for dy in range(cy if octave == own and dz == cz else y_low, y_high + 1):
                    row = plane + dy * nx
                    low, high = start_moving[row + x_low], start_moving[row + x_high + 1]
                    if octave == own:
                        low = max(low, i + 1)
                    if total + high - low >= capacity:
                        return -1
                    total = append_range(ball, i, low, high, grow, neighbor, total)
            if fixed_owner:
                continue
            for dz in range(z_low, z_high + 1):
                plane = first[octave] + dz * ny * nx
                if start_fixed[plane] == start_fixed[plane + ny * nx]:
                    continue
                for dy in range(y_low, y_high + 1):
                    row = plane + dy * nx
                    low = moving + start_fixed[row + x_low]
                    high = moving + start_fixed[row + x_high + 1]
                    if total + high - low >= capacity:
                        return -1
                    total = append_range(ball, i, low, high, grow, neighbor, total)
    begin[owners] = total
    return total


@njit(cache=True, error_model="numpy")
def gather(
    ball: NDArray[np.float64],
    previous: NDArray[np.float64],
    identity: NDArray[np.int64],
    level: NDArray[np.int8],
    order: NDArray[np.int32],
    order_fixed: NDArray[np.int32],
    ball_out: NDArray[np.float64],
    previous_out: NDArray[np.float64],
    identity_out: NDArray[np.int64],
    level_out: NDArray[np.int8],
) -> None:
    """Copy spheres in the order of their cells: moving ones by ``order``, fixed ones by ``order_fixed``."""
    moving = len(order)
    for i in range(moving):
        k = order[i]
        for column in range(4):
            ball_out[i, column] = ball[k, column]
        for axis in range(3):
            previous_out[i, axis] = previous[k, axis]
        identity_out[i] = identity[k]
        level_out[i] = level[k]
    for i in range(len(order_fixed)):
        k = moving + order_fixed[i]
        for column in range(4):
            ball_out[moving + i, column] = ball[k, column]
        level_out[moving + i] = level[k]
