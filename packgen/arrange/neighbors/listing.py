"""The neighbour list of a group of spheres: sorted by cell, then listed pair by pair."""

from __future__ import annotations

import numpy as np

from packgen.arrange.neighbors.list_kernels import (
    CellStarts,
    Pairs,
    SortedSpheres,
    cell_keys,
    fill_list,
    level_grids,
)
from packgen.arrays import Float64Array, Int32Array, Int64Array, filled


def list_pairs(
    ball: Float64Array, reach: Float64Array, moving: int, neighbor: Int32Array | None = None
) -> tuple[Int64Array, SortedSpheres, Pairs]:
    """Sort spheres by cell and list the pairs that are close.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        reach: A pair is listed when closer than the sum of these [m], shape (N,).
        moving: Number of spheres that move, which come first; pairs of two others are left out.
        neighbor: Array of an earlier list to write over; None: there is none.

    Returns:
        (place of each sorted sphere among those given, shape (N,); the spheres, sorted; their pairs).
    """
    grids, level = level_grids(ball, reach)
    start_moving, order = cell_keys(ball, level, grids, 0, moving)
    start_fixed, order_fixed = cell_keys(ball, level, grids, moving, len(ball))
    order = np.concatenate([order, moving + order_fixed]).astype(np.int64)
    spheres = SortedSpheres(ball.take(order, axis=0), reach.take(order), level.take(order))
    owners = moving if len(grids.size) == 1 else len(ball)
    begin = np.empty(owners + 1, np.int64)
    if neighbor is None:
        neighbor = np.empty(24 * len(ball) + 4096, np.int32)
    starts = CellStarts(start_moving, start_fixed)
    (neighbor,) = filled(fill_list, spheres, moving, grids, starts, begin, out=(neighbor,))
    owner = np.repeat(np.arange(owners, dtype=np.int32), np.diff(begin))
    return order, spheres, Pairs(owner, neighbor)
