"""Start positions for spheres of broad sizes: the large ones first, and no small one inside them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.seams import Seams
from packgen.arrays import Float64Array, Int64Array

APART = 0.9
"""Large spheres start at least this fraction of the sum of their radii apart, as long as there is room."""


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
    free = np.ones(len(points), bool)
    octave = np.floor(np.log2(radius.max() / radius) + 1e-9).astype(np.int64)
    largest = float(radius.max())
    for number in np.unique(octave):
        members = np.flatnonzero(octave == number)
        edge = largest * 0.5**number
        _close(points, free, seams, radius_of=edge, position=position_fixed, radius=radius_fixed)
        coarse = number < octave.max()
        picked = _pick(points, free, seams, len(members), APART * 1.5 * edge if coarse else 0.0)
        placed = members[: len(picked)]
        chosen[placed] = picked
        free[picked] = False
        _close(points, free, seams, radius_of=0.5 * edge, position=points[picked], radius=radius[placed])
    return chosen, chosen >= 0


def _pick(
    points: Float64Array, free: NDArray[np.bool_], seams: Seams, count: int, apart: float
) -> Int64Array:
    """Return the first free points, by random sequential addition where they have to be apart [m]."""
    candidates = np.flatnonzero(free)
    if apart == 0.0 or count == 0:
        return candidates[:count]
    candidates = candidates[: 20 * count]
    tree, placed = seams.tree(points[candidates]), seams.placed(points[candidates])
    blocked = np.zeros(len(candidates), bool)
    picked: list[int] = []
    for index in range(len(candidates)):
        if len(picked) == count:
            break
        if not blocked[index]:
            picked.append(index)
            blocked[tree.query_ball_point(placed[index], apart)] = True
    if len(picked) < count:
        # No more room: the rest overlap, and the sweeps part them or throw them back.
        rest = np.setdiff1d(np.arange(len(candidates)), picked)[: count - len(picked)]
        picked.extend(rest.tolist())
    return candidates[np.array(picked, np.int64)]


def _close(
    points: Float64Array,
    free: NDArray[np.bool_],
    seams: Seams,
    *,
    radius_of: float,
    position: Float64Array,
    radius: Float64Array,
) -> None:
    """Close the points that lie inside a sphere more than twice as large as ``radius_of`` [m]."""
    large = radius > 1.5 * radius_of
    if not large.any():
        return
    reach = radius[large] + 0.5 * radius_of
    for near in seams.tree(points).query_ball_point(seams.placed(position[large]), reach):
        free[near] = False
