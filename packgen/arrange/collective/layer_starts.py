"""Where the spheres of a layer start, and which sphere starts where."""

from __future__ import annotations

import numpy as np

from packgen.arrange.collective.open_zone import OpenZone
from packgen.arrange.collective.plan import START_FRACTION
from packgen.arrange.collective.starts import assign_starts
from packgen.arrange.collective.surface import Surface
from packgen.arrange.spheres import Spheres
from packgen.arrays import Float64Array
from packgen.distributions import UNIT_VOLUME
from packgen.portable import components, cube
from packgen.supply.supply import Draw

SPARE_STARTS = 5
"""Start positions among which a sphere of broad sizes chooses."""

POOR_SHARE, PORTION_MIN = 0.5, 0.25
"""A layer of broad sizes that gains less than this share of its volume was overfull: pressed against a lid,
its large spheres threw each other out. It is undone and tried with half as many, down to this portion."""

NARROW_SHARE = 0.4
"""If under this share of the candidate points keep a sphere fully inside the walls, points that keep half of
it inside are used too."""

STARTS_A_SPHERE, STARTS_MIN = 200.0, 2_000_000.0
"""Places tried for each sphere when few are left, and the least number of places."""

PLACES_MIN = 64
"""Least number of places among which the last few spheres of broad sizes choose."""

SEARCH_POINTS = 1024
"""Points tried for the start of a single sphere before a layer counts as without room."""


class LayerStarts:
    """Start positions of a zone's layers.

    Attributes:
        broad: Whether large spheres choose their places first.
    """

    def __init__(self, zone: OpenZone, surface: Surface) -> None:
        """Take the zone and its surface."""
        self._zone, self._surface = zone, surface
        self.broad = zone.supply.broad
        self._spare = SPARE_STARTS if self.broad else 1
        self._fraction = zone.supply.solid_fraction(START_FRACTION)
        self._portion = 1.0  # share of the spheres that a layer has room for; less after an overfull one

    def points(self, tops: Float64Array) -> Float64Array:
        """Return start positions between the bed and the new layer's top, (n, 3); the last few on the bed."""
        zone, level, thickness = self._zone, self._surface.level, self._surface.thickness
        region, supply = zone.region, zone.supply
        top = level + thickness
        low = min(max(float(tops.min()), level - thickness), top)
        least, most = region.rectangle()
        density = self._spare * self._fraction / supply.mean_volume
        mean = density * float(np.prod(most - least)) * (top - low)
        if supply.remaining is not None:
            # For a few spheres in a wide vessel, the lowest of this many places are low enough.
            mean = min(mean, max(STARTS_A_SPHERE * self._spare * supply.remaining, STARTS_MIN))
        count = int(zone.rng.poisson(mean))
        points = self._open(region.sample(zone.rng, count, low, top), tops)
        if len(points) == 0:
            points = self._open(region.sample(zone.rng, SEARCH_POINTS, low, top), tops)[:1]
        return points

    def _open(self, points: Float64Array, tops: Float64Array) -> Float64Array:
        """Return the points above the bed and inside the walls, (n, 3); the lowest where few are wanted."""
        surface, region, supply = self._surface, self._zone.region, self._zone.supply
        height = components(points, region.frame[2]) - tops[surface.map.index(points)]
        clearance = region.clearance(points, supply.radius_reference)
        remaining = supply.remaining
        if remaining is not None and self.broad:
            # The lowest of all places may be inside large spheres: the last spheres need several to choose
            # from.
            remaining = max(self._spare * remaining, PLACES_MIN)
        # Spheres start clear of the walls, unless these stand so near that little room is left.
        close = -0.5 * supply.radius_reference
        if (clearance >= 0.0).sum() > NARROW_SHARE * (clearance >= close).sum():
            close = 0.0
        near = height <= 2.0 * surface.thickness
        if region.sides is not None:
            # Another space begins above a roof. Its floor is far from the bed below.
            over = components(points, region.frame[2]) >= surface.level - surface.thickness
            near |= surface.roofed[surface.map.index(points)] & over
        open_space = (height >= 0.0) & near & (clearance >= close)
        points, height = points[open_space], height[open_space]
        if remaining is not None and remaining < len(points):
            points = points[np.sort(np.argsort(height, kind="stable")[:remaining])]
        return np.asarray(points)

    def assigned(self, points: Float64Array, front: Spheres) -> tuple[Float64Array, Draw]:
        """Take a sphere for each start position [m], (n, 3); of broad sizes the large ones choose first."""
        supply = self._zone.supply
        if not self.broad:
            draw = supply.take(len(points))
            return points[: len(draw.radius)], draw
        draw = self._taken(self._portion * len(points) / self._spare)
        seams = self._zone.region.walls.seams
        chosen, found = assign_starts(points, draw.radius, front.position, front.radius, seams)
        start, last = points[chosen[found]], supply.finished
        supply.put_back(Draw(draw.radius[~found], draw.set_index[~found]))
        draw = Draw(draw.radius[found], draw.set_index[found])
        return (self._lifted(start, draw.radius) if last else start), draw

    def _taken(self, places: float) -> Draw:
        """Take the spheres that ``places`` places of mean volume have room for.

        An endless supply gives no more volume than that. Its large spheres, put back first, would otherwise
        fill the room below a lid, layer by layer, and all be put back again.
        """
        supply = self._zone.supply
        draw = supply.take(max(int(places), 1))
        if supply.asked is not None:
            return draw
        volume = np.cumsum(UNIT_VOLUME * cube(draw.radius))
        count = max(int(np.searchsorted(volume, places * supply.mean_volume, side="right")), 1)
        supply.put_back(Draw(draw.radius[count:], draw.set_index[count:]))
        return Draw(draw.radius[:count], draw.set_index[:count])

    def _lifted(self, start: Float64Array, radius: Float64Array) -> Float64Array:
        """Return start positions on the bed, not in it, where there is room above: for the last spheres."""
        lifted = start + radius[:, None] * self._zone.region.frame[2]
        room = self._zone.region.clearance(lifted, self._zone.supply.radius_reference) > 0.0
        return np.where(room[:, None], lifted, start)

    def overfull(self, gained: float, *, closing: bool) -> bool:
        """Tell whether a layer is to be undone and tried with fewer spheres; set the next one's portion.

        Args:
            gained: Share of its volume that the layer gained.
            closing: Whether it held the last spheres.
        """
        if gained >= POOR_SHARE or not self.broad or closing or not self._surface.started:
            self._portion = min(2.0 * self._portion, 1.0)
            return False
        if self._portion <= PORTION_MIN:
            return False
        self._portion *= 0.5
        return True
