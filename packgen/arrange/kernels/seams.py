"""Pairs across the seams of a periodic box: what ``sweep`` does to all others, done to their images."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from packgen.arrange.kernels.pushes import parting


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
