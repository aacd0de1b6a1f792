"""The lowest place of a sphere in a region, however slender: boxes are halved until one is known to hold it.

A sphere's clearance changes by no more than the way that its centre goes. A box whose middle lacks more than
half the box's diagonal has no place for it, and is left out; where a middle has a place, boxes above are.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from packgen.arrange.space.map_kernels import least_gap
from packgen.arrange.space.region import Region
from packgen.arrays import BoolArray, Float64Array
from packgen.portable import components

__all__ = ["Place", "lowest_place"]

RESOLUTION = 0.02
"""Half the diagonal of the last boxes, in radii."""

PRECISION = 1.0e-4
"""How far above the lowest place the one returned may be, in radii, where boxes go on being halved."""

HALVINGS_MAX = 120
"""Halvings of the boxes, along one axis each."""

BOXES_MAX = 20_000
"""Boxes looked at together; the highest ones beyond that are left alone."""


NO_SPHERES = np.empty((0, 4))


class Place(NamedTuple):
    """Where a sphere may lie.

    Attributes:
        altitude: No place has its centre below this [m]; infinite where there is none at all.
        center: A place about as low [m], shape (3,); None: none is known for sure.
    """

    altitude: float
    center: Float64Array | None


def lowest_place(region: Region, radius: float, others: Float64Array = NO_SPHERES) -> Place:
    """Return the lowest place that a region has for a sphere.

    Args:
        region: The region.
        radius: The sphere's [m].
        others: Centres and radii of spheres that it may not overlap [m], shape (N, 4); a few.
    """
    least, most = region.rectangle()
    low = np.array([*least, region.floor])
    half = 0.5 * (np.array([*most, region.ceiling]) - low)
    middle = (low + half)[None]
    altitude, best, best_altitude = math.inf, None, math.inf
    for _ in range(HALVINGS_MAX):
        diagonal = math.sqrt(float((half * half).sum()))
        clearance, within = _clearance(region, middle, radius, diagonal, others)
        certain = np.flatnonzero(within & (clearance >= 0.0))
        if len(certain):
            lowest = certain[np.argmin(middle[certain, 2])]
            if middle[lowest, 2] < best_altitude:
                best_altitude, best = float(middle[lowest, 2]), middle[lowest]
        bottom = middle[:, 2] - half[2]
        middle = middle[(clearance + diagonal >= 0.0) & (bottom < best_altitude - PRECISION * radius)]
        if len(middle) == 0:
            break
        if len(middle) > BOXES_MAX:
            middle = middle[np.argsort(middle[:, 2], kind="stable")]
            altitude = min(altitude, float(middle[BOXES_MAX, 2] - half[2]))
            middle = middle[:BOXES_MAX]
        if diagonal < RESOLUTION * radius and best is None:
            altitude = min(altitude, float(middle[:, 2].min() - half[2]))
            break
        middle, half = _halved(middle, half)
    altitude = min(altitude, best_altitude)
    return Place(altitude, None if best is None else components(best[None], region.frame.T)[0])


def _clearance(
    region: Region, middle: Float64Array, radius: float, diagonal: float, others: Float64Array
) -> tuple[Float64Array, BoolArray]:
    """Return how far inside at most each middle is [m], (N,), and which are known to be in the region."""
    position, walls = np.ascontiguousarray(components(middle, region.frame.T)), region.walls
    gap: Float64Array = least_gap(position, radius, walls.features, walls.near)
    inside = region.holds(position)
    if region.sides is not None:
        # From outside a mesh a centre has to go to the nearest facet first. So near to one that its cell is
        # cut, the side is not certain.
        distance = np.minimum(gap + radius, walls.reach)
        outside = ~inside & (distance > math.sqrt(3.0) * region.sides.grid.size)
        gap[outside] = -distance[outside] - radius
    beyond = np.maximum(region.bounds[0] - position, position - region.bounds[1]).max(axis=1)
    gap[beyond > diagonal] = -np.inf
    for *center, other in others:
        apart = position - np.array(center)
        gap = np.minimum(gap, np.sqrt((apart * apart).sum(axis=1)) - (other + radius))
    return gap, inside & (beyond <= 0.0)


def _halved(middle: Float64Array, half: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return the halves of boxes across their longest side: middles (2 N, 3), and half their sides (3,)."""
    axis = int(np.argmax(half))
    half = np.where(np.arange(3) == axis, 0.5 * half, half)
    step = np.where(np.arange(3) == axis, half, 0.0)
    return np.concatenate([middle - step, middle + step]), half
