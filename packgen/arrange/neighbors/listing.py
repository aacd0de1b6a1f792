"""The neighbour list of a group of spheres: sorted by cell, then listed pair by pair."""

from __future__ import annotations

import numpy as np

from packgen.arrange.neighbors.list_kernels import (
    CellStarts,
    LevelGrids,
    SortedSpheres,
    cell_keys,
    fill_list,
    level_grids,
)
from packgen.arrays import Float64Array, Int32Array
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
    order, level, grids, starts = cell_order(ball, reach, moving)
    spheres = SortedSpheres(np.empty((len(ball), 4)), np.empty(len(ball)), np.empty(len(ball), np.int8))
    for i in range(len(ball)):
        for axis in range(4):
            spheres.ball[i, axis] = ball[order[i], axis]
        spheres.reach[i], spheres.level[i] = reach[order[i]], level[order[i]]
    owners = pair_owners(np.zeros(0, np.int32), 0, moving, len(ball), len(grids.size))
    owner, neighbor = pairs_of(spheres, moving, grids, starts, owners, neighbor)
    return order, (spheres.ball, spheres.reach, spheres.level), (owner, neighbor)


@inner_loop
def cell_order(  # type: ignore[no-untyped-def]
    ball: Float64Array, reach: Float64Array, moving: int
):
    """Return how spheres lie in the order of their cells, those that move first; see ``list_pairs``.

    Returns:
        (place of each sorted sphere among those given, shape (N,); level of each sphere given, shape (N,);
        the grids; where each cell begins among the sorted spheres).
    """
    grids, level = level_grids(ball, reach)
    start_moving, order_moving = cell_keys(ball[:moving], level[:moving], grids)
    start_fixed, order_fixed = cell_keys(ball[moving:], level[moving:], grids)
    order = np.empty(len(ball), np.int64)
    for i in range(len(ball)):
        order[i] = order_moving[i] if i < moving else moving + order_fixed[i - moving]
    return order, level, grids, CellStarts(start_moving, start_fixed)


@inner_loop
def pair_owners(part: Int32Array, number: int, moving: int, count: int, levels: int) -> Int32Array:
    """Return the spheres of a part that own pairs, rising: those that move, and all where levels are several.

    Args:
        part: The part that each sphere is in, shape (N,); empty: all are in one.
        number: The part.
        moving: How many move, which come first.
        count: How many there are.
        levels: Levels of their radii.
    """
    owners, found = np.empty(moving if levels == 1 else count, np.int32), 0
    for i in range(len(owners)):
        owners[found] = i
        found += len(part) == 0 or part[i] == number
    return owners[:found]


@inner_loop
def pairs_of(  # type: ignore[no-untyped-def]
    spheres: SortedSpheres,
    moving: int,
    grids: LevelGrids,
    starts: CellStarts,
    owners: Int32Array,
    neighbor: Int32Array,
):
    """List the pairs of some owners; see ``fill_list``.

    Returns:
        The arrays of ``Pairs``; ``neighbor``, or a longer one where it is too short, is the second.
    """
    begin = np.empty(len(owners) + 1, np.int64)
    while fill_list(spheres, moving, grids, starts, owners, begin, neighbor) < 0:
        neighbor = np.empty(max(2 * len(neighbor), 24 * len(owners) + 4096), np.int32)
    owner = np.empty(begin[-1], np.int32)
    for each in range(len(owners)):
        for k in range(begin[each], begin[each + 1]):
            owner[k] = owners[each]
    return owner, neighbor
