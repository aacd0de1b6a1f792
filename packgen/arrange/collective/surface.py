"""The surface of the bed in a zone: its altitude column by column, what lies deep, what hangs above."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter

from packgen.arrange.collective.earlier_beds import beds_of_zones, lowest_ground
from packgen.arrange.collective.loose import LOOSE, is_loose
from packgen.arrange.collective.open_zone import OpenZone
from packgen.arrange.collective.plan import LayerPlan
from packgen.arrange.space.columns import ColumnMap
from packgen.arrange.spheres import Spheres
from packgen.arrays import BoolArray, Float64Array
from packgen.portable import components

COVERED, EVEN = 0.95, 1.0
"""A bed that was there before is gone on with as with a zone's own where it has a top, within `EVEN` layers
of the level, in this share of the columns."""

SEAM_SHARE = 0.75
"""Thickness of the first layer on such a bed, in that of the others: measured, 1 makes the seam 0.004 denser
than a bed of one run, 0.75 makes it 0.001 denser."""

LOOSE_DEPTH = 0.9
"""Depth to which such a bed is re-opened, in that of a zone's own. Its top is evener than that of a bed under
way, for the last spheres took the lowest places. Where none is re-opened the seam is 0.010 looser."""


class Surface:
    """Where the next layer goes.

    Attributes:
        diameter: Mean diameter, each sphere counted by its volume: the unit of the plan [m].
        map: Columns as wide as a sphere of mean volume.
        reach: How far across gravity a sphere covers others [m].
        ground: Top of the earlier zones' spheres that stand, column by column [m]; -inf without any.
        overhead: Top of all spheres of earlier zones, hanging ones included [m].
        base: Altitude at which the first layer starts [m].
        level: Mean altitude of the surface [m].
        climbed: Altitude above which the last throat ended [m]; -inf: none was passed.
        started: Whether the zone has spheres.
        buried_tops: Top of the spheres put away, column by column [m].
        roofed: Columns whose bed ends under a roof, shape (columns,).
    """

    def __init__(self, zone: OpenZone, plan: LayerPlan) -> None:
        """Look at what earlier zones have left in a zone."""
        region, supply, front = zone.region, zone.supply, zone.pile.front
        self._zone, self._plan = zone, plan
        self._radius_reference, self._radius_max = supply.radius_reference, supply.radius_max
        self.diameter = 2.0 * supply.radius_by_volume
        self.map = ColumnMap.over(region, 2.0 * supply.radius_reference)
        # Where large spheres stand out of small ones, the next large ones meet the surface of the large.
        wide = ColumnMap.over(region, 2.0 * max(supply.radius_by_volume, supply.radius_reference))
        self._wide_column = wide.index(self.map.points(np.zeros(self.map.count)))
        # Spheres of earlier zones may be larger and cover more.
        self.reach = 2.0 * max(supply.radius_max, float(front.radius.max(initial=0.0)))
        beds, standing = beds_of_zones(front, region, self.map, self.diameter)
        self.ground = self.map.tops(standing.position, standing.radius)
        self.overhead = self.map.tops(beds.position, beds.radius)
        self.level = self.base = lowest_ground(standing, region, supply.radius_reference)
        self.climbed = -math.inf
        self.started = False
        self.buried_tops = np.full(self.map.count, -np.inf)
        self.roofed = np.zeros(self.map.count, bool)
        self._own = self._goes_on(front)
        self.started = self._at_the_seam = LOOSE in self._own

    def _goes_on(self, front: Spheres) -> tuple[int, ...]:
        """Return the zone numbers of this zone's bed: the loose ones' too where these cover it evenly."""
        alone = (self._zone.index,)
        loose = is_loose(front, self._zone.region)
        if not loose.any():
            return alone
        region, radius = self._zone.region, self._radius_reference
        tops = self.map.tops(front.position[loose], front.radius[loose])
        found = np.isfinite(tops)
        level = float(np.median(tops[found]))
        room = region.clearance(self.map.points(np.full(self.map.count, level + radius)), radius) >= 0.0
        even = np.abs(tops - level) < EVEN * self._plan.thickness * self.diameter
        covered = bool(room.any()) and float((found & even)[room].mean()) > COVERED
        return (*alone, LOOSE) if covered else alone

    def go_on(self, buried_tops: Float64Array, level: float) -> None:
        """Go on with a bed that was begun by other means.

        Args:
            buried_tops: Top of its spheres that are put away, column by column [m].
            level: Altitude up to which it is filled [m].
        """
        self.buried_tops, self.level, self.started = buried_tops, level, True

    @property
    def thickness(self) -> float:
        """Thickness of the next layer [m]."""
        if self.started:
            return self._plan.thickness * self.diameter * (SEAM_SHARE if self._at_the_seam else 1.0)
        return self._plan.thickness * self.diameter * self._plan.first

    def climb(self, has_room: Callable[[], bool]) -> bool:
        """Raise the level to the next room between non-convex walls or earlier beds.

        Args:
            has_room: Tells whether something finds a place at the level.

        Returns:
            Whether there is such a room.
        """
        region = self._zone.region
        if region.sides is None and not np.isfinite(self.overhead).any():
            return False
        while self.level < region.ceiling - self.diameter:
            self.level += 0.5 * self.diameter
            self.climbed = self.level
            if has_room():
                return True
        return False

    def tops(self) -> Float64Array:
        """Return the tops of the columns, spheres far above the new layer left out [m]; set the level."""
        tops = self._own_tops(self._zone.pile.front)
        found = np.isfinite(tops)
        # A bed that ends below a zone leaves the zone to stand on its own floor.
        tops[found] = np.maximum(tops[found], self._zone.region.floor)
        self.roofed = self._roofs(tops, found)
        open_above = found & ~self.roofed
        # Hollows left behind below a throat are not the surface any more.
        open_above &= tops > self.climbed - self.thickness
        if open_above.any():
            # Nor is a hollow under a roof that a column's middle misses: it would hold the level down.
            open_above &= tops > np.median(tops[open_above]) - self.thickness
        level = self._level(tops, open_above) if open_above.any() else self.level
        self.level = max(level, self.climbed)
        if not found.any() or not self.started:
            # Before the first sphere only the foot of earlier beds is found. It is no surface to fill up to.
            self.level = max(self.base, self.climbed)
        tops[~found] = self.level
        return np.maximum(tops, self.ground)

    def _own_tops(self, front: Spheres) -> Float64Array:
        """Return the tops of this zone's bed and of earlier ones that it stands on or has reached [m]."""
        self._at_the_seam &= not (front.zone_index == self._zone.index).any()
        front = front[np.isin(front.zone_index, self._own)]
        altitude = components(front.position, self._zone.region.frame[2])
        highest = 1.5 * max(self._plan.first, 1.0) * self._plan.thickness * self.diameter
        below = altitude <= self.level + highest
        if not below.any():
            # The first spheres of a slender tip come to rest high above it, and are all that there is.
            below[:] = True
        tops = self.map.tops(front.position[below], front.radius[below])
        # Earlier beds that this one stands on belong to its surface. Those that tower beside it do not.
        under = self.ground <= self.level + self.thickness
        tops[under] = np.maximum(tops[under], self.ground[under])
        below = self.overhead <= self.level
        tops[below] = np.maximum(tops[below], self.overhead[below])
        return tops

    def _roofs(self, tops: Float64Array, found: BoolArray) -> BoolArray:
        """Tell in which columns the bed ends under a roof: these say nothing of the surface, (columns,)."""
        region, radius = self._zone.region, self._radius_reference
        above = self.map.points(np.where(found, tops, self.level) + radius)
        roofed = found & (region.clearance(above, radius) < 0.0)
        if (roofed == found).all() and found.any():
            # In a tube so narrow that its wall is near everywhere, a near wall is no roof.
            below_it = self.map.points(np.where(found, tops, self.level) - radius)[found]
            roofed &= not (region.clearance(below_it, radius) < 0.0).all()
        return np.asarray(roofed)

    def _level(self, tops: Float64Array, open_above: BoolArray) -> float:
        """Return the mean altitude of the surface [m], in columns as wide as the large spheres."""
        highest = np.full(int(self._wide_column.max()) + 1, -np.inf)
        np.maximum.at(highest, self._wide_column[open_above], tops[open_above])
        return float(highest[np.isfinite(highest)].mean())

    def shallow(self, front: Spheres, tops: Float64Array, start: Float64Array) -> BoolArray:
        """Tell which spheres of this zone, or loose ones, lie just below newcomers and move with them, (N,).

        Args:
            front: Spheres at rest.
            tops: Tops of the columns [m].
            start: Start positions of the newcomers [m], shape (n, 3).
        """
        column = self.map.index(front.position)
        depth = tops[column] - components(front.position, self._zone.region.frame[2])
        fresh = np.zeros(self.map.count)
        fresh[self.map.index(start)] = 1.0
        touched = self.map.nearby(fresh, 2.0 * self._radius_max, maximum_filter) > 0.0
        reach = np.where(front.zone_index == LOOSE, LOOSE_DEPTH, 1.0) * self._plan.reopened * self.diameter
        own = front.zone_index == self._zone.index
        return np.asarray((depth < reach) & touched[column] & (own | is_loose(front, self._zone.region)))

    def above_buried(self, position: Float64Array, radius: Float64Array) -> BoolArray:
        """Tell which spheres are above all buried ones near them, (N,): others could overlap them unseen."""
        bottom = components(position, self._zone.region.frame[2]) - radius
        buried = self.map.nearby(self.buried_tops, self.reach, maximum_filter)
        return np.asarray(bottom > buried[self.map.index(position)])

    def bury(self) -> None:
        """Put away the spheres too deep below every surface nearby for the next layers to reach."""
        front = self._zone.pile.front
        tops = self.map.tops(front.position, front.radius)
        tops[np.isneginf(tops)] = self.level
        tops[self.roofed] = np.inf
        lowest = self.map.nearby(tops, self.reach, minimum_filter)
        depth = (self._plan.reopened + self._plan.buffer) * self.diameter
        index = self.map.index(front.position)
        top = components(front.position, self._zone.region.frame[2]) + front.radius
        deep = top < np.minimum(lowest[index], self.level) - (depth + 2.0 * self._radius_max)
        np.maximum.at(self.buried_tops, index[deep], top[deep])
        self._zone.pile.bury(deep)
