"""What spheres at rest can meet: pairs and walls, with their distances."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.listing import list_pairs
from packgen.arrange.neighbors.seam_pairs import seam_pairs
from packgen.arrange.space.feature_kernels import wall_gap
from packgen.arrange.space.map_kernels import WallList
from packgen.arrange.space.seams import is_periodic
from packgen.arrange.space.walls import WallTable, walls_in_reach
from packgen.compiled import loop


@loop
def near_pairs(  # type: ignore[no-untyped-def]
    center: NDArray[np.float64], half: NDArray[np.float64], walls: WallTable, within: float
):
    """List the pairs whose surfaces are nearer than a distance.

    Args:
        center: Centres, in the periodic box [m], shape (N, 3).
        half: Radii [m], shape (N,).
        walls: Where space wraps around.
        within: The distance [m].

    Returns:
        (first, second: spheres of each pair, shape (P,), int64; separation: from the second one, or from its
        nearest image, to the first [m], shape (P, 3)).
    """
    count = len(half)
    ball, reach = np.empty((count, 4)), np.empty(count)
    for i in range(count):
        for axis in range(3):
            ball[i, axis] = center[i, axis]
        ball[i, 3] = half[i]
        reach[i] = half[i] + 0.5 * within
    order, _, (owner, item) = list_pairs(ball, reach, count, np.empty(0, np.int32))
    one, other, offset = np.empty(0, np.int32), np.empty(0, np.int32), np.empty((0, 3))
    if is_periodic(walls.seams.period):
        one, other, offset = seam_pairs(ball, reach, count, walls.seams)
    inner, total = len(owner), len(owner) + len(one)
    first, second = np.empty(total, np.int64), np.empty(total, np.int64)
    separation = np.empty((total, 3))
    for k in range(total):
        if k < inner:
            first[k], second[k] = order[owner[k]], order[item[k]]
        else:
            first[k], second[k] = one[k - inner], other[k - inner]
        for axis in range(3):
            separation[k, axis] = center[first[k], axis] - center[second[k], axis]
            if k >= inner:
                separation[k, axis] -= offset[k - inner, axis]
    return first, second, separation


@loop
def near_walls(  # type: ignore[no-untyped-def]
    center: NDArray[np.float64], half: NDArray[np.float64], walls: WallTable, within: float
):
    """List the walls that are nearer to spheres' surfaces than a distance.

    Args:
        center: Centres [m], shape (N, 3).
        half: Radii [m], shape (N,).
        walls: The walls.
        within: The distance [m].

    Returns:
        (sphere, feature of each, shape (W,), int64).
    """
    count = len(half)
    ball = np.empty((count, 4))
    for i in range(count):
        for axis in range(3):
            ball[i, axis] = center[i, axis]
        ball[i, 3] = half[i]
    none = WallList(np.empty(0, np.int64), np.empty(0, np.int32), np.empty(0))
    begin, item, _ = walls_in_reach(ball, np.full(count, within), walls, none)
    sphere, feature = np.empty(begin[count], np.int64), np.empty(begin[count], np.int64)
    for i in range(count):
        for k in range(begin[i], begin[i + 1]):
            sphere[k], feature[k] = i, item[k]
    return sphere, feature


@loop
def wall_distances(  # type: ignore[no-untyped-def]
    center: NDArray[np.float64], sphere: NDArray[np.int64], feature: NDArray[np.int64], walls: WallTable
):
    """Return how far centres are from walls, and the way that leads away from these.

    Args:
        center: Centres [m], shape (N, 3).
        sphere: Sphere of each row, shape (W,).
        feature: Its wall, shape (W,).
        walls: The walls.

    Returns:
        (distance [m], shape (W,), negative outside; unit vectors, shape (W, 3)).
    """
    kind, row = walls.features
    distance, away = np.empty(len(sphere)), np.empty((len(sphere), 3))
    for k in range(len(sphere)):
        i, f = sphere[k], feature[k]
        distance[k], away[k, 0], away[k, 1], away[k, 2] = wall_gap(
            kind[f], row[f], center[i, 0], center[i, 1], center[i, 2], 0.0
        )
    return distance, away
