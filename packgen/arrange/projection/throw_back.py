"""Which spheres of a layer have to go: those that overlap too much, the worst of each group."""

from __future__ import annotations

import math

import numpy as np

from packgen.arrange.neighbors.listing import list_pairs
from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.compiled import inlined, inner_loop

SQUEEZED = 2.0
"""Spheres nearer than so many sums of their radii are squeezed together."""


@inlined
def spheres_to_go(ball: Float64Array, blame: Float64Array, limit: float, most: int) -> BoolArray:
    """Return which spheres of a layer have to go, as they overlap by more than a limit.

    Of several squeezed together only the worst goes: its place is often enough for the others.

    Args:
        ball: Centres and radii of the moving spheres [m], shape (moving, 4); NaN was taken out.
        blame: Overlap that each is blamed for, as a fraction of the smaller radius, shape (moving,).
        limit: Overlap above which a sphere has to go, at least 0.
        most: Of more than so many the most blamed go: in an overfull layer most spheres overlap, yet removing
            a few is enough.

    Returns:
        Which, shape (moving,).
    """
    blamed = np.empty(len(blame), np.int64)
    count = 0
    for i in range(len(blame)):
        blamed[count] = i
        count += blame[i] > limit
    chosen = np.zeros(len(blame), np.bool_)
    if count == 0:
        return chosen
    worst = worst_of_groups(ball, blame, blamed[:count])
    least, ties = cut(blame, worst, most)
    for i in worst:
        chosen[i] = blame[i] > least or (blame[i] == least and ties > 0)
        ties -= blame[i] == least
    return chosen


@inlined
def worst_of_groups(ball: Float64Array, blame: Float64Array, blamed: Int64Array) -> Int64Array:
    """Return the spheres without a worse one squeezed against them.

    Of two that are blamed alike, the one of larger radius is the worse where the radii differ by octaves
    (counted from the largest of all), else the one that comes first.

    Args:
        ball: Centres and radii [m], shape (moving, 4).
        blame: Overlap that each is blamed for, shape (moving,).
        blamed: Those that are looked at, rising, at least one, shape (B,).

    Returns:
        Those of them without a worse one, rising, shape (W,).
    """
    count = len(blamed)
    group, largest = np.empty((count, 4)), 0.0
    for k in range(count):
        for axis in range(4):
            group[k, axis] = ball[blamed[k], axis]
        largest = max(largest, group[k, 3])
    octave = np.zeros(count, np.int64)
    reach = np.empty(count)
    for k in range(count):
        ratio = largest / group[k, 3]
        while ratio >= 2.0:
            ratio *= 0.5
            octave[k] += 1
        # A little farther than what counts: the list rounds differently.
        reach[k] = SQUEEZED * (1.0 + 1e-9) * group[k, 3]
    order, _, (owner, neighbor) = list_pairs(group, reach, count, np.empty(0, np.int32))
    beaten = np.zeros(count, np.bool_)
    for k in range(len(owner)):
        a, b = order[owner[k]], order[neighbor[k]]
        dx, dy, dz = group[a, 0] - group[b, 0], group[a, 1] - group[b, 1], group[a, 2] - group[b, 2]
        if math.sqrt(dx * dx + dy * dy + dz * dz) > SQUEEZED * (group[a, 3] + group[b, 3]):
            continue
        one, other = blame[blamed[a]], blame[blamed[b]]
        b_is_less = octave[a] < octave[b] if octave[a] != octave[b] else a < b
        beaten[b if one > other or (one == other and b_is_less) else a] = True
    left = 0
    worst = np.empty(count, np.int64)
    for k in range(count):
        worst[left] = blamed[k]
        left += not beaten[k]
    return worst[:left]


@inner_loop
def cut(blame: Float64Array, worst: Int64Array, most: int) -> tuple[float, int]:
    """Return the least blame of the ``most`` most blamed, and how many of that blame are among them.

    Args:
        blame: Overlap that each sphere is blamed for, shape (moving,).
        worst: The spheres that are looked at, blamed for more than 0, shape (W,).
        most: How many are chosen at most, at least 1.

    Returns:
        (least blame; how many of exactly that are chosen); (0, 0) where all are.
    """
    if len(worst) <= most:
        return 0.0, 0
    low, high = 0.0, 0.0
    for i in worst:
        high = max(high, blame[i])
    # `most` or more are above the low one, fewer above the high one: at last no number lies between.
    above = 0
    while True:
        middle = low + 0.5 * (high - low)
        if middle <= low or middle >= high:
            return high, most - above
        count = 0
        for i in worst:
            count += blame[i] > middle
        if count >= most:
            low = middle
        else:
            high, above = middle, count
