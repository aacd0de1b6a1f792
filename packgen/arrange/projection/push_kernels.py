"""Which listed pairs overlap, and how they push each other apart: the innermost loops of a sweep.

Two loops: the first finds the pairs that overlap, one in five of the listed ones, without a branch that the
processor could guess wrong (a third of a sweep's time); the second pushes these.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.list_kernels import Pairs
from packgen.arrange.neighbors.seam_pairs import SeamPairs
from packgen.arrange.projection.pair_rules import PARTING_X, PARTING_Y
from packgen.compiled import inlined, inner_loop

NEARLY = 1.0 - 1e-15
"""Factor within which a product and a quotient are rounded alike."""


@inner_loop
def rows_of(owner: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return where the pairs of each owner begin, and the end of all, of the owners of pairs, rising."""
    rows, count = np.empty(len(owner) + 1, np.int32), 0
    for k in range(len(owner)):
        rows[count] = k
        count += k == 0 or owner[k] != owner[k - 1]
    rows[count] = len(owner)
    return rows[: count + 1]


@inner_loop
def touching_pairs(
    ball: NDArray[np.float64],
    pairs: Pairs,
    rows: NDArray[np.int32],
    one: NDArray[np.int32],
    other: NDArray[np.int32],
) -> int:
    """Find the listed pairs that overlap.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        pairs: The listed pairs, P of them.
        rows: Where those of each owner begin; see ``rows_of``.
        one: Out: owners of the pairs that overlap, at least P + 1 entries.
        other: Out: their other spheres, likewise.

    Returns:
        How many there are.
    """
    owner, neighbor = pairs
    count = 0
    for row in range(len(rows) - 1):
        i = np.uint64(owner[rows[row]])
        x, y, z, radius = ball[i, 0], ball[i, 1], ball[i, 2], ball[i, 3]
        for k in range(rows[row], rows[row + 1]):
            # Unsigned: no code for negative indices in the innermost loop.
            j = np.uint64(neighbor[np.uint64(k)])
            dx = x - ball[j, 0]
            dy = y - ball[j, 1]
            dz = z - ball[j, 2]
            reach = radius + ball[j, 3]
            at = np.uint64(count)
            one[at], other[at] = i, j
            count += dx * dx + dy * dy + dz * dz < reach * reach
    return count


@inlined
def parting(i: int | np.uint64, j: int | np.uint64) -> tuple[float, float, float]:
    """Return a direction along which the coincident spheres i and j part, by their numbers."""
    across, along = PARTING_X * (i + j), PARTING_Y * (i + j)
    return across - math.floor(across) - 0.5, along - math.floor(along) - 0.5, 0.5 - (i & 1)


@inlined
def push_apart(
    i: int | np.uint64,
    j: int | np.uint64,
    dx: float,
    dy: float,
    dz: float,
    ball: NDArray[np.float64],
    weight: NDArray[np.float64],
    shift: NDArray[np.float64],
    worst: float,
) -> float:
    """Add the push of one overlapping pair to the shifts of both.

    Args:
        i: One sphere.
        j: The other one.
        dx: From the other one, or its image, to the one [m].
        dy: The same.
        dz: The same.
        ball: Centres and radii [m], shape (N, 4).
        weight: Weight of each sphere in a push; see ``push_weights``; shape (N,).
        shift: Sum of the pushes on each sphere [m], shape (N, 3); grows.
        worst: Largest overlap so far, as a fraction of the smaller radius.

    Returns:
        Largest overlap, this pair's included.
    """
    reach = ball[i, 3] + ball[j, 3]
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    overlap = reach - distance
    smaller = min(ball[i, 3], ball[j, 3])
    if overlap > worst * smaller * NEARLY:
        # The largest of all quotients, whatever the order of the pairs.
        worst = max(worst, overlap / smaller)
    if distance < 1e-9 * reach:
        # Coincident centres have no normal: the numbers of the spheres give a direction.
        dx, dy, dz = parting(i, j)
        distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    push = overlap / (distance * (weight[i] + weight[j]))
    own, back = push * weight[i], push * weight[j]
    shift[i, 0] += own * dx
    shift[i, 1] += own * dy
    shift[i, 2] += own * dz
    shift[j, 0] -= back * dx
    shift[j, 1] -= back * dy
    shift[j, 2] -= back * dz
    return worst


@inner_loop
def push_pairs(
    ball: NDArray[np.float64],
    weight: NDArray[np.float64],
    one: NDArray[np.int32],
    other: NDArray[np.int32],
    shift: NDArray[np.float64],
) -> float:
    """Add up the pushes of overlapping pairs.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        weight: Weight of each sphere in a push; see ``push_weights``; shape (N,).
        one: One sphere of each pair that overlaps, shape (T,).
        other: The other one, shape (T,).
        shift: Sum of the pushes on each sphere [m], shape (N, 3); grows.

    Returns:
        Largest overlap as a fraction of the smaller radius.
    """
    worst = 0.0
    for k in range(len(one)):
        i, j = np.uint64(one[k]), np.uint64(other[k])
        dx = ball[i, 0] - ball[j, 0]
        dy = ball[i, 1] - ball[j, 1]
        dz = ball[i, 2] - ball[j, 2]
        worst = push_apart(i, j, dx, dy, dz, ball, weight, shift, worst)
    return worst


@inner_loop
def push_seam_pairs(
    ball: NDArray[np.float64], weight: NDArray[np.float64], seam: SeamPairs, shift: NDArray[np.float64]
) -> float:
    """Add the pushes of overlaps across the seams to those of ``push_pairs``.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        weight: Weight of each sphere in a push; see ``push_weights``; shape (N,).
        seam: The pairs that are close across a seam.
        shift: Sum of the pushes on each sphere [m], shape (N, 3); grows.

    Returns:
        Largest overlap as a fraction of the smaller radius.
    """
    first, second, offset = seam
    worst = 0.0
    for k in range(len(first)):
        i, j = np.uint64(first[k]), np.uint64(second[k])
        dx = ball[i, 0] - (ball[j, 0] + offset[k, 0])
        dy = ball[i, 1] - (ball[j, 1] + offset[k, 1])
        dz = ball[i, 2] - (ball[j, 2] + offset[k, 2])
        reach = ball[i, 3] + ball[j, 3]
        if dx * dx + dy * dy + dz * dz < reach * reach:  # also skips removed spheres (NaN)
            worst = push_apart(i, j, dx, dy, dz, ball, weight, shift, worst)
    return worst


@inlined
def blame_one(
    i: int,
    j: int,
    dx: float,
    dy: float,
    dz: float,
    ball: NDArray[np.float64],
    scale: float,
    height: NDArray[np.float64],
    overlap: NDArray[np.float64],
) -> float:
    """Blame the overlap of a pair on the one that has to go: it moves, is the smaller, else the higher.

    Args:
        i: One sphere.
        j: The other one.
        dx: From the other one, or its image, to the one [m].
        dy: The same.
        dz: The same.
        ball: Centres and arranged radii [m], shape (N, 4).
        scale: True radius over arranged radius.
        height: Height of each moving sphere [m], shape (moving,).
        overlap: Largest overlap that each moving sphere is blamed for, as a fraction of the smaller true
            radius, shape (moving,); grows.

    Returns:
        The overlap of the true spheres as a fraction of the smaller radius; 0 where they are apart.
    """
    moving = len(height)
    radius, other = scale * ball[i, 3], scale * ball[j, 3]
    reach = radius + other
    square = dx * dx + dy * dy + dz * dz
    depth = 0.0
    if square < reach * reach:  # also skips removed spheres (NaN)
        depth = (reach - math.sqrt(square)) / min(radius, other)
        blamed = i
        if i >= moving or (j < moving and (other < 0.6 * radius or height[j] > height[i])):
            blamed = j
        if i < moving and radius < 0.6 * other:
            blamed = i
        overlap[blamed] = max(overlap[blamed], depth)
    return depth


@inner_loop
def blame_pairs(
    ball: NDArray[np.float64],
    scale: float,
    pairs: Pairs,
    seam: SeamPairs,
    height: NDArray[np.float64],
    overlap: NDArray[np.float64],
) -> float:
    """Blame the overlap of each pair, seams included; see ``blame_one``.

    Args:
        ball: Centres and arranged radii [m], shape (N, 4).
        scale: True radius over arranged radius.
        pairs: The listed pairs.
        seam: The pairs that are close across a seam.
        height: Height of each moving sphere [m], shape (moving,).
        overlap: Largest overlap that each moving sphere is blamed for, shape (moving,); grows.

    Returns:
        Largest overlap as a fraction of the smaller true radius.
    """
    owner, neighbor = pairs
    worst = 0.0
    for k in range(len(owner)):
        # Unsigned: no code for negative indices in the innermost loop.
        i, j = np.uint64(owner[k]), np.uint64(neighbor[k])
        dx = ball[i, 0] - ball[j, 0]
        dy = ball[i, 1] - ball[j, 1]
        dz = ball[i, 2] - ball[j, 2]
        reach = scale * ball[i, 3] + scale * ball[j, 3]
        if dx * dx + dy * dy + dz * dz < reach * reach:
            depth = blame_one(owner[k], neighbor[k], dx, dy, dz, ball, scale, height, overlap)
            worst = max(worst, depth)
    first, second, offset = seam
    for k in range(len(first)):
        i, j = first[k], second[k]
        dx = ball[i, 0] - (ball[j, 0] + offset[k, 0])
        dy = ball[i, 1] - (ball[j, 1] + offset[k, 1])
        dz = ball[i, 2] - (ball[j, 2] + offset[k, 2])
        worst = max(worst, blame_one(i, j, dx, dy, dz, ball, scale, height, overlap))
    return worst
