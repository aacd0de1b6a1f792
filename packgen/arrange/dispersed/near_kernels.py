"""What is near each sphere of a zone: neighbours, images across seams and walls, sphere by sphere."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.listing import list_pairs
from packgen.arrange.neighbors.seam_pairs import seam_pairs
from packgen.arrange.projection.pair_rules import list_reach
from packgen.arrange.space.map_kernels import WallList
from packgen.arrange.space.seams import is_periodic, wrapped_coordinate
from packgen.arrange.space.walls import WallTable, walls_in_reach
from packgen.compiled import inner_loop


class Crowd(NamedTuple):
    """The spheres of a zone and those around it; the first M of N move.

    Attributes:
        center: Centres [m], shape (N, 3), float64.
        half: Half of the least distance between the centres of two alike [m], shape (N,), float64: the radius
            and half of the gap.
        wall: Least distance of each centre from a wall [m], shape (M,), float64: the radius and the gap.
    """

    center: NDArray[np.float64]
    half: NDArray[np.float64]
    wall: NDArray[np.float64]


class Near(NamedTuple):
    """What each moving sphere can meet until one of them has moved by more than its margin.

    Attributes:
        begin: First neighbour of each, shape (M + 1,), int64.
        item: Neighbours, sphere by sphere, int32; each pair of two that move is there twice.
        seam_begin: First neighbour beyond a seam of each, shape (M + 1,), int64.
        seam_item: Those neighbours, int32.
        seam_offset: What takes each of them to its image nearby [m], shape (K, 3), float64.
        walls: The walls.
        anchor: Centres when the lists were made [m], shape (M, 3), float64.
        margin: How far each may move [m], shape (M,), float64.
    """

    begin: NDArray[np.int64]
    item: NDArray[np.int32]
    seam_begin: NDArray[np.int64]
    seam_item: NDArray[np.int32]
    seam_offset: NDArray[np.float64]
    walls: WallList
    anchor: NDArray[np.float64]
    margin: NDArray[np.float64]


@inner_loop
def listed(crowd: Crowd, walls: WallTable, skin: float, reference: float):  # type: ignore[no-untyped-def]
    """Move centres that left a periodic box back into it, and list what is near them.

    Args:
        crowd: The spheres, at least one that moves; centres may change by whole periods.
        walls: The walls.
        skin: See ``list_reach``.
        reference: A radius [m], see ``list_reach``.

    Returns:
        The lists, a ``Near``.
    """
    center, half, wall = crowd
    count, moving = len(half), len(wall)
    low, period = walls.seams
    ball = np.empty((count, 4))
    for i in range(count):
        for axis in range(3):
            center[i, axis] = wrapped_coordinate(center[i, axis], low[axis], period[axis])
            ball[i, axis] = center[i, axis]
        ball[i, 3] = half[i]
    reach = list_reach(ball, moving, skin, reference)
    order, _, (owner, neighbor) = list_pairs(ball, reach, moving, np.empty(0, np.int32))
    begin = np.zeros(moving + 1, np.int64)
    for k in range(len(owner)):
        for i in (order[owner[k]], order[neighbor[k]]):
            if i < moving:
                begin[i + 1] += 1
    fill = first_of_each(begin)
    item = np.empty(begin[moving], np.int32)
    for k in range(len(owner)):
        i, j = order[owner[k]], order[neighbor[k]]
        if i < moving:
            item[fill[i]] = j
            fill[i] += 1
        if j < moving:
            item[fill[j]] = i
            fill[j] += 1
    seam_begin, seam_item, seam_offset = listed_across(ball, reach, moving, walls)
    anchor, margin = np.empty((moving, 3)), np.empty(moving)
    for i in range(moving):
        margin[i] = reach[i] - half[i]
        ball[i, 3] = wall[i]
        for axis in range(3):
            anchor[i, axis] = center[i, axis]
    none = WallList(np.empty(0, np.int64), np.empty(0, np.int32), np.empty(0))
    wall_begin, wall_item, room = walls_in_reach(ball, margin, walls, none)
    near_walls = WallList(wall_begin, wall_item, room)
    return Near(begin, item, seam_begin, seam_item, seam_offset, near_walls, anchor, margin)


@inner_loop
def first_of_each(count: NDArray[np.int64]) -> NDArray[np.int64]:
    """Turn counts, one place late, into first places, in place; return a copy of them, shape (M + 1,)."""
    for i in range(len(count) - 1):
        count[i + 1] += count[i]
    return count.copy()


@inner_loop
def listed_across(  # type: ignore[no-untyped-def]
    ball: NDArray[np.float64], reach: NDArray[np.float64], moving: int, walls: WallTable
):
    """Return the arrays ``seam_begin``, ``seam_item``, ``seam_offset`` of ``Near``."""
    begin = np.zeros(moving + 1, np.int64)
    if not is_periodic(walls.seams.period):
        return begin, np.empty(0, np.int32), np.empty((0, 3))
    first, second, offset = seam_pairs(ball, reach, moving, walls.seams)
    for k in range(len(first)):
        for i in (first[k], second[k]):
            if i < moving:
                begin[i + 1] += 1
    fill = first_of_each(begin)
    item, shift = np.empty(begin[moving], np.int32), np.empty((begin[moving], 3))
    for k in range(len(first)):
        for turn in range(2):
            i, j = (first[k], second[k]) if turn == 0 else (second[k], first[k])
            if i < moving:
                item[fill[i]] = j
                for axis in range(3):
                    shift[fill[i], axis] = offset[k, axis] if turn == 0 else -offset[k, axis]
                fill[i] += 1
    return begin, item, shift
