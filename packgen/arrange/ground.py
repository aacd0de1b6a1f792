"""What a later zone stands on: the beds of earlier zones that reach up into it, column by column.

What towers beside a zone, or hangs above it, is no ground: spheres start below and around it.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter

from packgen.arrange.region import ColumnMap, Region
from packgen.arrange.spheres import Spheres
from packgen.arrays import Float64Array

HANGING = 1.5
"""Spheres over a gap higher than so many diameters hang."""


def ground_of_zones(front: Spheres, region: Region, columns: ColumnMap, diameter: float) -> Float64Array:
    """Return the tops of the beds that stand below a zone and in it.

    Args:
        front: The spheres of all earlier zones.
        region: The zone's space.
        columns: Columns over it.
        diameter: Of the zone's spheres [m].

    Returns:
        Altitude of each column's top [m], -inf where nothing stands, shape (columns.count,), float64.
    """
    ground = np.full(columns.count, -np.inf)
    altitude = front.position @ region.frame[2]
    within = columns.covers(front.position)
    within &= (altitude < region.floor) | (region.clearance(front.position, 0.0) > 0.0)
    if not within.any():
        return ground
    altitude, radius = altitude[within], front.radius[within]
    column = columns.index(front.position[within])
    order = np.lexsort((altitude - radius, column))
    column, bottom, top = column[order], (altitude - radius)[order], (altitude + radius)[order]
    first = np.diff(column, prepend=-1) > 0
    # The highest top so far in each column, by one running maximum over all of them.
    step = 2.0 * (float(top.max()) - float(bottom.min())) + diameter
    highest = np.maximum.accumulate(top + column * step) - column * step
    before = np.where(first, -np.inf, np.concatenate([[-np.inf], highest[:-1]]))
    hangs = np.cumsum(bottom - np.maximum(before, region.floor) > HANGING * diameter)
    # Whatever stands on something that hangs does so, too.
    start = np.flatnonzero(first)
    earlier = np.concatenate([[0], hangs])[start]
    stands = hangs == np.repeat(earlier, np.diff(np.append(start, len(top))))
    np.maximum.at(ground, column[stands], top[stands])
    return ground


def lowest_ground(ground: Float64Array, region: Region, columns: ColumnMap, radius: float) -> float:
    """Return the lowest altitude [m] at which a sphere of some radius [m] could stand: on a bed or the floor.

    Gaps between earlier beds that are narrower than a sphere do not count.
    """
    if not np.isfinite(ground).any():
        return region.floor
    wide = columns.nearby(np.maximum(ground, region.floor), radius, maximum_filter)
    fits = region.clearance(columns.points(wide + radius), radius) > -0.5 * radius
    return float(wide[fits].min()) if fits.any() else region.floor
