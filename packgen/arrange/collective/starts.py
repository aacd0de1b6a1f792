"""Start positions for spheres of broad sizes: the large ones first, and no small one inside them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.point_kernels import close_points, pick_apart, point_grid
from packgen.arrange.space.seams import Seams
from packgen.arrays import Float64Array, Int64Array
from packgen.portable import octaves

APART = 1.1
"""Large spheres of an octave start this fraction of its mean diameter apart, as long as there is room: only
the largest of them overlap."""

CANDIDATES_A_SPHERE = 20
"""Points tried for each large sphere before it may start inside another one."""


def assign_starts(
    points: Float64Array,
    radius: Float64Array,
    position_fixed: Float64Array,
    radius_fixed: Float64Array,
    seams: Seams,
) -> tuple[Int64Array, NDArray[np.bool_]]:
    """Give each sphere one of the points, octave by octave of radius, the largest first.

    A point inside a larger sphere, new or at rest, is no start for a smaller one: such a sphere would have to
    be pushed out over a distance of many of its own radii.

    Args:
        points: Candidates in random order [m], shape (P, 3).
        radius: Radii of the new spheres [m], shape (N,).
        position_fixed: Centres of the spheres at rest nearby [m], shape (F, 3).
        radius_fixed: Their radii [m], shape (F,).
        seams: Where space wraps around.

    Returns:
        (point of each sphere, shape (N,), int64; which spheres got one, shape (N,)).
    """
    chosen = np.full(len(radius), -1, np.int64)
    if len(points) == 0 or len(radius) == 0:
        return chosen, chosen >= 0
    points = np.ascontiguousarray(seams.wrapped(points))
    grid = point_grid(points, seams.low, seams.period)
    closed = np.zeros(len(points), bool)
    largest = float(radius.max())
    octave = octaves(largest / radius)
    position_large, radius_large = seams.wrapped(position_fixed), radius_fixed
    for number in np.unique(octave):
        members, edge = np.flatnonzero(octave == number), largest * 0.5 ** int(number)
        # A sphere hardly larger than a newcomer is a neighbour like any other.
        large = radius_large > 1.5 * edge
        close_points(position_large[large], radius_large[large] + 0.5 * edge, grid, closed)
        position_large, radius_large = position_large[~large], radius_large[~large]
        free = np.flatnonzero(~closed)
        if number < octave.max():
            apart = APART * 1.5 * edge
            picked = pick_apart(free[: CANDIDATES_A_SPHERE * len(members)], len(members), apart, grid)
        else:
            picked = free[: len(members)]
        placed = members[: len(picked)]
        chosen[placed] = picked
        closed[picked] = True
        position_large = np.concatenate([position_large, points[picked]])
        radius_large = np.concatenate([radius_large, radius[placed]])
    return chosen, chosen >= 0
