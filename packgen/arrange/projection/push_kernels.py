"""Which listed pairs overlap, and how they push each other apart: the innermost loops of a sweep.

Two loops: the first finds the pairs that overlap, one in five of the listed ones, without a branch that the
processor could guess wrong (a third of a sweep's time); the second pushes these.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

PARTING_X, PARTING_Y = 0.7548776662466927, 0.5698402909980532
"""Steps of an even sequence in the plane: powers of the plastic number, the root of x^3 = x + 1."""


@njit(cache=True, error_model="numpy")
def touching_pairs(
    ball: NDArray[np.float64],
    owner: NDArray[np.int32],
    neighbor: NDArray[np.int32],
    touching: NDArray[np.int32],
) -> int:
    """Find the listed pairs that overlap.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        owner: One sphere of each listed pair, shape (P,).
        neighbor: The other one, shape (P,) or longer.
        touching: Out: numbers of the pairs that overlap, at least P + 1 entries.

    Returns:
        How many there are.
    """
    count = 0
    for k in range(len(owner)):
        # Unsigned: no code for negative indices in the innermost loop.
        i, j = np.uint64(owner[k]), np.uint64(neighbor[k])
        dx = ball[i, 0] - ball[j, 0]
        dy = ball[i, 1] - ball[j, 1]
        dz = ball[i, 2] - ball[j, 2]
        reach = ball[i, 3] + ball[j, 3]
        touching[np.uint64(count)] = k
        count += dx * dx + dy * dy + dz * dz < reach * reach
    return count


@njit(cache=True, error_model="numpy", inline="always")
def parting(i: int, j: int) -> tuple[float, float, float]:
    """Return a direction along which the coincident spheres i and j part, by their numbers."""
    across, along = PARTING_X * (i + j), PARTING_Y * (i + j)
    return across - math.floor(across) - 0.5, along - math.floor(along) - 0.5, 0.5 - (i & 1)


@njit(cache=True, error_model="numpy")
def push_pairs(
    ball: NDArray[np.float64],
    lightness: NDArray[np.float64],
    owner: NDArray[np.int32],
    neighbor: NDArray[np.int32],
    touching: NDArray[np.int32],
    shift: NDArray[np.float64],
) -> float:
    """Add up the pushes of overlapping pairs.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        lightness: Each of a pair takes the share of its own in the sum; see ``push_lightness``; shape (N,).
        owner: One sphere of each listed pair.
        neighbor: The other one.
        touching: The pairs that overlap, shape (T,).
        shift: Out: sum of the pushes on each sphere [m], shape (N, 3).

    Returns:
        Largest overlap as a fraction of the smaller radius.
    """
    worst = 0.0
    shift[:] = 0.0
    for k in touching:
        i, j = np.uint64(owner[k]), np.uint64(neighbor[k])
        dx = ball[i, 0] - ball[j, 0]
        dy = ball[i, 1] - ball[j, 1]
        dz = ball[i, 2] - ball[j, 2]
        reach = ball[i, 3] + ball[j, 3]
        distance = math.sqrt(dx * dx + dy * dy + dz * dz)
        overlap = reach - distance
        smaller = min(ball[i, 3], ball[j, 3])
        if overlap > worst * smaller:
            worst = overlap / smaller
        if distance < 1e-9 * reach:
            # Coincident centres have no normal: part them along a direction of their own numbers.
            dx, dy, dz = parting(owner[k], neighbor[k])
            distance = math.sqrt(dx * dx + dy * dy + dz * dz)
        push = overlap / (distance * (lightness[i] + lightness[j]))
        own, back = push * lightness[i], push * lightness[j]
        shift[i, 0] += own * dx
        shift[i, 1] += own * dy
        shift[i, 2] += own * dz
        shift[j, 0] -= back * dx
        shift[j, 1] -= back * dy
        shift[j, 2] -= back * dz
    return worst


@njit(cache=True, error_model="numpy")
def push_seam_pairs(
    ball: NDArray[np.float64],
    lightness: NDArray[np.float64],
    first: NDArray[np.int32],
    second: NDArray[np.int32],
    offset: NDArray[np.float64],
    shift: NDArray[np.float64],
) -> float:
    """Add the pushes of overlaps across the seams to those of ``pushes.push_pairs``.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        lightness: Share of a push that each sphere takes; see ``push_pairs``.
        first: One sphere of each pair.
        second: The other one.
        offset: What takes the second one to its image near the first [m], shape (P, 3).
        shift: Sum of the pushes on each sphere [m], shape (N, 3); grows.

    Returns:
        Largest overlap as a fraction of the smaller radius.
    """
    worst = 0.0
    for k in range(len(first)):
        i, j = first[k], second[k]
        dx = ball[i, 0] - (ball[j, 0] + offset[k, 0])
        dy = ball[i, 1] - (ball[j, 1] + offset[k, 1])
        dz = ball[i, 2] - (ball[j, 2] + offset[k, 2])
        reach = ball[i, 3] + ball[j, 3]
        square = dx * dx + dy * dy + dz * dz
        if not square < reach * reach:  # nor of one that was taken out, which is not a number
            continue
        distance = math.sqrt(square)
        overlap = reach - distance
        worst = max(worst, overlap / min(ball[i, 3], ball[j, 3]))
        if distance < 1e-9 * reach:
            # Coincident: part them along a direction of their own numbers, as all other pairs.
            dx, dy, dz = parting(i, j)
            distance = math.sqrt(dx * dx + dy * dy + dz * dz)
        push = overlap / (distance * (lightness[i] + lightness[j]))
        own, back = push * lightness[i], push * lightness[j]
        shift[i, 0] += own * dx
        shift[i, 1] += own * dy
        shift[i, 2] += own * dz
        shift[j, 0] -= back * dx
        shift[j, 1] -= back * dy
        shift[j, 2] -= back * dz
    return worst


@njit(cache=True, error_model="numpy", inline="always")
def blamed_sphere(
    i: int, j: int, moving: int, radius: float, other: float, height: NDArray[np.float64]
) -> int:
    """Return which of an overlapping pair has to go: one that moves, the smaller, else the higher."""
    blamed = i
    if i >= moving or (j < moving and (other < 0.6 * radius or height[j] > height[i])):
        blamed = j
    if i < moving and radius < 0.6 * other:
        blamed = i
    return blamed


@njit(cache=True, error_model="numpy")
def seam_overlaps(
    ball: NDArray[np.float64],
    scale: float,
    moving: int,
    first: NDArray[np.int32],
    second: NDArray[np.int32],
    offset: NDArray[np.float64],
    height: NDArray[np.float64],
    overlap: NDArray[np.float64],
) -> float:
    """Add the overlaps across the seams to the blame of ``sweep.sphere_overlaps``; return the largest."""
    worst = 0.0
    for k in range(len(first)):
        i, j = first[k], second[k]
        radius, other = scale * ball[i, 3], scale * ball[j, 3]
        dx = ball[i, 0] - (ball[j, 0] + offset[k, 0])
        dy = ball[i, 1] - (ball[j, 1] + offset[k, 1])
        dz = ball[i, 2] - (ball[j, 2] + offset[k, 2])
        reach = radius + other
        square = dx * dx + dy * dy + dz * dz
        if square < reach * reach:
            depth = (reach - math.sqrt(square)) / min(radius, other)
            worst = max(worst, depth)
            blamed = blamed_sphere(i, j, moving, radius, other, height)
            overlap[blamed] = max(overlap[blamed], depth)
    return worst
