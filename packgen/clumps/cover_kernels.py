"""Which points spheres cover: the greedy choice of spheres, and its improvement one sphere at a time."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.clumps.tree_kernels import closest_point
from packgen.compiled import inner_loop, loop

GROWN = 1.3
"""How many times its radius a sphere that may stick out grows or shrinks in a round, at most."""

BINS = 96
"""Radii that are tried at once for a sphere that may stick out of the body."""


@inner_loop
def covered_of(point: NDArray[np.float64], count: int, ball: NDArray[np.float64]) -> int:
    """Return how many of the first points (N, 3) a sphere (4,) covers."""
    x, y, z, square = ball[0], ball[1], ball[2], ball[3] * ball[3]
    found = 0
    for k in range(count):
        dx, dy, dz = point[k, 0] - x, point[k, 1] - y, point[k, 2] - z
        found += 1 if dx * dx + dy * dy + dz * dz <= square else 0
    return found


@loop
def choose(
    point: NDArray[np.float64], ball: NDArray[np.float64], taken: int, most: int, rest: int
) -> NDArray[np.int64]:
    """Choose spheres one by one, always one that covers most of what is uncovered yet.

    Args:
        point: Points to be covered [m], shape (N, 3).
        ball: Spheres to choose from [m], shape (K, 4); the first ``taken`` are chosen already.
        taken: How many.
        most: Largest number of spheres, those included.
        rest: Number of points that may stay uncovered.

    Returns:
        The chosen spheres beside the first ones, in this order, int64; they end where none covers anything
        new.
    """
    left = point.copy()
    count = len(left)
    chosen = np.empty(max(most - taken, 0), np.int64)
    # What a sphere covers only falls as others are chosen: an old count is an upper bound.
    bound = np.full(len(ball), len(point) + 1, np.int64)
    bound[:taken] = 0
    number = 0
    for step in range(most):
        if step < taken:
            best = step
        else:
            if count <= rest:
                break
            best = -1
            while True:
                top = int(np.argmax(bound))
                if top == best:
                    break
                bound[top] = covered_of(left, count, ball[top])
                if best < 0 or bound[top] >= bound[best]:
                    best = top
            if bound[best] == 0:
                break
            chosen[number] = best
            number += 1
        kept = 0
        x, y, z, square = ball[best, 0], ball[best, 1], ball[best, 2], ball[best, 3] * ball[best, 3]
        for k in range(count):
            dx, dy, dz = left[k, 0] - x, left[k, 1] - y, left[k, 2] - z
            if dx * dx + dy * dy + dz * dz > square:
                left[kept, 0], left[kept, 1], left[kept, 2] = left[k, 0], left[k, 1], left[k, 2]
                kept += 1
        count = kept
        bound[best] = 0
    return chosen[:number]


@inner_loop
def count_covers(
    point: NDArray[np.float64], ball: NDArray[np.float64], by: int, covers: NDArray[np.int32]
) -> None:
    """Add ``by`` to the number of spheres that cover each point in a sphere (4,)."""
    x, y, z, square = ball[0], ball[1], ball[2], ball[3] * ball[3]
    for k in range(len(point)):
        dx, dy, dz = point[k, 0] - x, point[k, 1] - y, point[k, 2] - z
        if dx * dx + dy * dy + dz * dz <= square:
            covers[k] += by


@inner_loop
def free_near(
    point: NDArray[np.float64],
    sign: NDArray[np.int32],
    covers: NDArray[np.int32],
    ball: NDArray[np.float64],
    reach: float,
    near: NDArray[np.float64],
    worth: NDArray[np.int32],
) -> int:
    """Find the points that no sphere covers, near a sphere (4,); return how many."""
    x, y, z, square = ball[0], ball[1], ball[2], reach * reach
    found = 0
    for k in range(len(point)):
        if covers[k] == 0:
            dx, dy, dz = point[k, 0] - x, point[k, 1] - y, point[k, 2] - z
            if dx * dx + dy * dy + dz * dz <= square:
                near[found, 0], near[found, 1], near[found, 2] = point[k, 0], point[k, 1], point[k, 2]
                worth[found] = sign[k]
                found += 1
    return found


@inner_loop
def best_radius(
    near: NDArray[np.float64],
    worth: NDArray[np.int32],
    count: int,
    ball: NDArray[np.float64],
    low: float,
    high: float,
    gain: NDArray[np.int64],
) -> int:
    """Give a sphere the radius of the largest gain; return the gain.

    Args:
        near: Uncovered points [m], shape (N, 3).
        worth: 1 for each in the body, -1 outside, shape (N,).
        count: How many of them there are.
        ball: The sphere [m], shape (4,); its radius changes.
        low: Least radius [m].
        high: Largest radius [m].
        gain: Room, shape (BINS + 1,).
    """
    gain[:] = 0
    scale = BINS / (high - low)
    for k in range(count):
        dx, dy, dz = near[k, 0] - ball[0], near[k, 1] - ball[1], near[k, 2] - ball[2]
        away = math.sqrt(dx * dx + dy * dy + dz * dz)
        if away <= high:
            gain[max(math.ceil((away - low) * scale), 0)] += worth[k]
    total, best, place = 0, -len(near), 0
    for k in range(BINS + 1):
        total += gain[k]
        if total > best:
            best, place = total, k
    ball[3] = low + place / scale
    return best


@loop
def polish(
    box: NDArray[np.float64],
    corner: NDArray[np.float64],
    point: NDArray[np.float64],
    sign: NDArray[np.int32],
    ball: NDArray[np.float64],
    step: NDArray[np.float64],
    direction: NDArray[np.float64],
    least: float,
    equal: float,
    inscribed: bool,
) -> None:
    """Move spheres, one after the other, to where they cover more that no other one covers.

    Args:
        box: Tree of the surface, as in `closest_point`.
        corner: Its triangles, as in `closest_point`.
        point: Points [m], shape (N, 3).
        sign: 1 for points in the body, -1 outside, shape (N,).
        ball: The spheres [m], shape (K, 4); change.
        step: How far centres try to move in each round, in radii, shape (R,).
        direction: Unit vectors of trials in each round, shape (R, D, 3).
        least: Least radius [m].
        equal: Radius of all spheres [m]; 0: each has its own.
        inscribed: Whether spheres stay in the body.
    """
    covers = np.zeros(len(point), np.int32)
    near, worth = np.empty((len(point), 3)), np.empty(len(point), np.int32)
    found, trial, gain = np.empty(3), np.empty(4), np.zeros(BINS + 1, np.int64)
    for i in range(len(ball)):
        count_covers(point, ball[i], 1, covers)
    for turn in range(len(step)):
        for i in range(len(ball)):
            count_covers(point, ball[i], -1, covers)
            # A sphere in the body grows at most as far as it moves.
            reach = ball[i, 3] * (1.0 + 2.0 * step[turn])
            if not inscribed and equal == 0.0:
                reach = ball[i, 3] * (GROWN + step[turn])
            count = free_near(point, sign, covers, ball[i], reach, near, worth)
            best = -len(point) - 1
            start = ball[i].copy()
            for k in range(-1, len(direction[turn])):
                trial[:] = start
                if k >= 0:
                    for axis in range(3):
                        trial[axis] += step[turn] * start[3] * direction[turn, k, axis]
                if inscribed:
                    away = closest_point(box, corner, trial[0], trial[1], trial[2], reach, 0.0, found)
                    if away < max(least, equal):
                        continue
                    trial[3] = equal if equal > 0.0 else away
                    gained = covered_of(near, count, trial)
                elif equal > 0.0:
                    gained = 0
                    for j in range(count):
                        square = (near[j, 0] - trial[0]) ** 2 + (near[j, 1] - trial[1]) ** 2
                        if square + (near[j, 2] - trial[2]) ** 2 <= equal * equal:
                            gained += worth[j]
                else:
                    low, high = max(start[3] / GROWN, least), max(GROWN * start[3], 1.01 * least)
                    gained = best_radius(near, worth, count, trial, low, high, gain)
                if gained > best:
                    best = gained
                    ball[i] = trial
            count_covers(point, ball[i], 1, covers)


@loop
def covered_alone(point: NDArray[np.float64], ball: NDArray[np.float64]) -> NDArray[np.int64]:
    """Return how many points (N, 3) each sphere (K, 4) covers that no other one does, shape (K,), int64."""
    covers = np.zeros(len(point), np.int32)
    for i in range(len(ball)):
        count_covers(point, ball[i], 1, covers)
    alone = np.zeros(len(ball), np.int64)
    for i in range(len(ball)):
        x, y, z, square = ball[i, 0], ball[i, 1], ball[i, 2], ball[i, 3] * ball[i, 3]
        for k in range(len(point)):
            if covers[k] == 1:
                dx, dy, dz = point[k, 0] - x, point[k, 1] - y, point[k, 2] - z
                alone[i] += 1 if dx * dx + dy * dy + dz * dz <= square else 0
    return alone


@loop
def gaps(point: NDArray[np.float64], ball: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the gaps of points (N, 3) to the nearest sphere (K, 4), below 0 inside, shape (N,), float64."""
    result = np.full(len(point), np.inf)
    for k in range(len(point)):
        for i in range(len(ball)):
            dx, dy, dz = point[k, 0] - ball[i, 0], point[k, 1] - ball[i, 1], point[k, 2] - ball[i, 2]
            result[k] = min(result[k], math.sqrt(dx * dx + dy * dy + dz * dz) - ball[i, 3])
    return result
