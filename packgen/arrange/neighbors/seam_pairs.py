"""Pairs of spheres that are close across a seam."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from packgen.arrange.neighbors.listing import list_pairs
from packgen.arrange.space.seams import Seams
from packgen.arrays import BoolArray, Float64Array, Int32Array, Int64Array
from packgen.compiled import inlined, inner_loop, loop


class SeamPairs(NamedTuple):
    """Pairs of spheres that are close across a seam, each once.

    Attributes:
        first: One sphere, shape (P,), int32.
        second: The other one, shape (P,), int32.
        offset: What takes the second one to its image near the first [m], shape (P, 3), float64.
    """

    first: Int32Array
    second: Int32Array
    offset: Float64Array


@inlined
def near_side(along: float, longest: float, period: float, step: int) -> bool:
    """Tell whether an image, ``step`` periods away, of a sphere near the side it leaves can touch the box.

    Args:
        along: From the lower side to the sphere's centre [m].
        longest: Reach of the sphere and the farthest-reaching one [m].
        period: Length of the box [m].
        step: -1, 0 or 1.
    """
    if step == 0:
        return True
    return along < longest if step > 0 else along > period - longest


@inlined
def largest(reach: Float64Array) -> float:
    """Return the largest reach, shape (N,); 0 of none."""
    farthest = 0.0
    for i in range(len(reach)):
        farthest = max(farthest, reach[i])
    return farthest


@loop
def images(ball: Float64Array, reach: Float64Array, seams: Seams) -> tuple[Int64Array, Float64Array]:
    """Return the images that spheres of the box can meet in one half of all directions.

    Of the two images that a pair has, one in either sphere's stead, one is enough.

    Args:
        ball: Centres in the box and radii [m], shape (N, 4).
        reach: Spheres closer than the sum of these count as close [m], shape (N,), N at least 1.
        seams: The periods.

    Returns:
        (sphere of each image, shape (M,); its shift [m], shape (M, 3)).
    """
    low, period = seams
    farthest, count, total = largest(reach), len(ball), 0
    sphere, shift = np.empty(13 * count, np.int64), np.empty((13 * count, 3))
    for number in range(14, 27):  # of the 27 steps (-1, -1, -1) to (1, 1, 1) those after (0, 0, 0)
        steps = (number // 9 - 1, number // 3 % 3 - 1, number % 3 - 1)
        wraps = True
        for axis in range(3):
            wraps &= steps[axis] == 0 or period[axis] > 0.0
        for i in range(count if wraps else 0):
            longest, near = reach[i] + farthest, True
            for axis in range(3):
                near &= near_side(ball[i, axis] - low[axis], longest, period[axis], steps[axis])
                shift[total, axis] = steps[axis] * period[axis]
            sphere[total] = i
            total += near
    return sphere[:total], shift[:total]


@inlined
def seam_pairs(ball: Float64Array, reach: Float64Array, moving: int, seams: Seams):  # type: ignore[no-untyped-def]
    """List the pairs that are close across a seam.

    Args:
        ball: Centres in the box and radii [m], shape (N, 4).
        reach: A pair is listed when closer than the sum of these [m], shape (N,), N at least 1.
        moving: Number of spheres that move, which come first; pairs of two others are left out.
        seams: The periods, each more than twice as long as any pair's reach.

    Returns:
        The arrays of ``SeamPairs``.
    """
    image, shift = images(ball, reach, seams)
    partner = near_seams(ball, reach, seams)
    split = len(image)
    if split == 0:
        return np.empty(split, np.int32), np.empty(split, np.int32), np.empty((split, 3))
    both, reaches = np.empty((split + len(partner), 4)), np.empty(split + len(partner))
    for k in range(len(both)):
        i = image[k] if k < split else partner[k - split]
        for axis in range(3):
            both[k, axis] = ball[i, axis] + (shift[k, axis] if k < split else 0.0)
        both[k, 3], reaches[k] = ball[i, 3], reach[i]
    order, _, (owners, others) = list_pairs(both, reaches, split, np.empty(0, np.int32))
    count, most = 0, len(owners)
    found = SeamPairs(np.empty(most, np.int32), np.empty(most, np.int32), np.empty((most, 3)))
    for k in range(most):
        owner, other = owners[k], others[k]
        if (owner < split) == (other < split):
            continue  # two images, or two spheres of the box
        one = order[min(owner, other)]
        first, second = partner[order[max(owner, other)] - split], image[one]
        if first < moving or second < moving:
            found.first[count], found.second[count] = first, second
            for axis in range(3):
                found.offset[count, axis] = shift[one, axis]
            count += 1
    return found.first[:count], found.second[:count], found.offset[:count]


@inlined
def chosen_seam_pairs(seam: SeamPairs, chosen: BoolArray):  # type: ignore[no-untyped-def]
    """Return the arrays of the chosen ones of P pairs, shape (P,); the arrays given are written over."""
    first, second, offset = seam
    count = 0
    for k in range(len(chosen)):
        first[count], second[count] = first[k], second[k]
        for axis in range(3):
            offset[count, axis] = offset[k, axis]
        count += chosen[k]
    return first[:count], second[:count], offset[:count]


@inner_loop
def near_seams(ball: Float64Array, reach: Float64Array, seams: Seams) -> Int64Array:
    """Return the spheres of the box near any of its seams, rising; see ``images``."""
    low, period = seams
    farthest, count = largest(reach), 0
    sphere = np.empty(len(ball), np.int64)
    for i in range(len(ball)):
        longest, near = reach[i] + farthest, False
        for axis in range(3):
            if period[axis] > 0.0:
                along = ball[i, axis] - low[axis]
                near |= near_side(along, longest, period[axis], 1)
                near |= near_side(along, longest, period[axis], -1)
        sphere[count] = i
        count += near
    return sphere[:count]
