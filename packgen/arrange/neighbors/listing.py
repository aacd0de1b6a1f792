"""The neighbour list of a group of spheres: sorted by cell, then listed pair by pair."""

from __future__ import annotations

import numpy as np

from packgen.arrange.neighbors.list_kernels import (
    CellStarts,
    SortedSpheres,
    cell_keys,
    fill_list,
    level_grids,
)
from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.compiled import inner_loop, loop


@loop
def list_pairs(  # type: ignore[no-untyped-def]
    ball: Float64Array, reach: Float64Array, moving: int, neighbor: Int32Array
):
    """Sort spheres by cell and list the pairs that are close.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        reach: A pair is listed when closer than the sum of these [m], shape (N,).
        moving: Number of spheres that move, which come first; pairs of two others are left out.
        neighbor: Array for the list; where it is too short a longer one takes its place.

    Returns:
        (place of each sorted sphere among those given, shape (N,); the arrays of ``SortedSpheres`` and of
        ``Pairs``).
    """
    count = len(ball)
    grids, level = level_grids(ball, reach)
    start_moving, order_moving = cell_keys(ball[:moving], level[:moving], grids)
    start_fixed, order_fixed = cell_keys(ball[moving:], level[moving:], grids)
    order = np.empty(count, np.int64)
    spheres = SortedSpheres(np.empty((count, 4)), np.empty(count), np.empty(count, np.int8))
    for i in range(count):
        place = order_moving[i] if i < moving else moving + order_fixed[i - moving]
        order[i] = place
        for axis in range(4):
            spheres.ball[i, axis] = ball[place, axis]
        spheres.reach[i], spheres.level[i] = reach[place], level[place]
    begin = np.empty((moving if len(grids.size) == 1 else count) + 1, np.int64)
    starts = CellStarts(start_moving, start_fixed)
    while True:
        total = fill_list(spheres, moving, grids, starts, begin, neighbor)
        if total >= 0:
            return order, (spheres.ball, spheres.reach, spheres.level), (owners(begin), neighbor)
        neighbor = np.empty(max(2 * len(neighbor), 24 * count + 4096), np.int32)


@inner_loop
def owners(begin: Int64Array) -> Int32Array:
    """Return the owner of each pair, shape (P,), of the first pair of each owner, shape (owners + 1,)."""
    owner = np.empty(begin[-1], np.int32)
    for i in range(len(begin) - 1):
        for k in range(begin[i], begin[i + 1]):
            owner[k] = i
    return owner
