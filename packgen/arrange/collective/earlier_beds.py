"""What a later zone stands on: the beds of earlier zones that reach up into it.

A bed that towers beside a zone, or hangs above it, is no ground until its top is reached: spheres start below
and around it first.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import maximum_filter

from packgen.arrange.space.columns import ColumnMap
from packgen.arrange.space.region import Region
from packgen.arrange.spheres import Spheres
from packgen.portable import components

HANGING = 1.5
"""Height of a gap [diameters] above which spheres hang."""


def beds_of_zones(
    front: Spheres, region: Region, columns: ColumnMap, diameter: float
) -> tuple[Spheres, Spheres]:
    """Return the beds of earlier zones in a zone and below it.

    Args:
        front: The spheres of all earlier zones.
        region: The zone's space.
        columns: Columns over it.
        diameter: Of the zone's spheres [m].

    Returns:
        (all of their spheres, those of them that stand: nothing below them hangs).
    """
    altitude = components(front.position, region.frame[2])
    within = columns.covers(front.position)
    within &= (altitude < region.floor) | (region.clearance(front.position, 0.0) > 0.0)
    beds = front[within]
    if len(beds) == 0:
        return beds, beds
    altitude, radius = altitude[within], beds.radius
    column = columns.index(beds.position)
    order = np.lexsort((altitude - radius, column))
    column, bottom, top = column[order], (altitude - radius)[order], (altitude + radius)[order]
    first = np.diff(column, prepend=-1) > 0
    # The highest top so far in each column, by one running maximum over all of them.
    step = 2.0 * (float(top.max()) - float(bottom.min())) + diameter
    highest = np.maximum.accumulate(top + column * step) - column * step
    before = np.where(first, -np.inf, np.concatenate([[-np.inf], highest[:-1]]))
    hangs = np.cumsum(bottom - np.maximum(before, region.floor) > HANGING * diameter)
    # A sphere that stands on a hanging one hangs, too.
    start = np.flatnonzero(first)
    earlier = np.concatenate([[0], hangs])[start]
    stands = hangs == np.repeat(earlier, np.diff(np.append(start, len(top))))
    return beds, beds[order[stands]]


def lowest_ground(ground: Spheres, region: Region, radius: float) -> float:
    """Return the lowest altitude [m] at which a sphere of some radius [m] could stand: on a bed or the floor.

    Gaps between the ground's spheres that are narrower than a sphere do not count.
    """
    if len(ground) == 0:
        return region.floor
    columns = ColumnMap.over(region, 0.5 * radius)
    tops = np.maximum(columns.tops(ground.position, ground.radius), region.floor)
    wide = columns.nearby(tops, float(ground.radius.max()) + radius, maximum_filter)
    fits = region.clearance(columns.points(wide + radius), radius) > -0.5 * radius
    return float(wide[fits].min() if fits.any() else wide.min())
