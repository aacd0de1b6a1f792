"""The default outer loop: thin layers on a re-opened surface, each arranged by the projection optimiser."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter, minimum_filter

from packgen.arrange.collective.earlier_beds import beds_of_zones, lowest_ground
from packgen.arrange.collective.starts import assign_starts
from packgen.arrange.pile import Pile
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.projection.settle import SettleStats, settle
from packgen.arrange.space.columns import ColumnMap
from packgen.arrange.space.region import Region
from packgen.arrange.spheres import Spheres, joined
from packgen.arrays import Float64Array
from packgen.distributions import UNIT_VOLUME
from packgen.portable import components, cube
from packgen.supply.supply import Draw, Supply

SPARE_STARTS = 5
"""Start positions a sphere of broad sizes chooses from."""

START_FRACTION = 0.6
"""Solid fraction at which a layer of equal spheres starts, already overlapping: that of the bed that it will
become. One of broad sizes starts with as much more as these pack more densely."""

STALLED_SHARE = 0.02
STALLED_MAX = 3
"""So many layers in a row that gain no more than this share of the volume they try: the zone is full."""

POOR_SHARE, PORTION_MIN = 0.5, 0.25
"""A layer of broad sizes that gains less than this share of its volume was overfull: pressed against a lid,
its large spheres threw each other out. It is undone and tried with half as many, down to this portion."""

NARROW_SHARE = 0.4
"""Where fewer of the places that are half inside the walls are wholly inside, spheres start half inside."""

STARTS_A_SPHERE, STARTS_MIN = 200.0, 2_000_000.0
"""Places that are looked at for each sphere when few are left, and at least."""

TRIES_MIN = 8
"""Spheres that a layer has to try for its failure to count in full: a narrow tube has room for one."""

PLACES_MIN = 64
"""Places that the last few spheres of broad sizes choose from, at least."""

SEARCH_POINTS = 1024
"""Points that are looked at for the start of a single sphere before a layer counts as without room."""


@dataclass(frozen=True, slots=True)
class LayerPlan:
    """How thick the layers are, in reference diameters (of the volume-weighted mean radius).

    Attributes:
        thickness: Thickness of a new layer.
        reopened: Depth below the surface to which spheres that came to rest move again with it.
        buffer: Depth below that to which fixed spheres are kept at hand.
        first: Thickness of the first layer over that of the others: not to move again with the second one,
            whose weight would squeeze more spheres onto the floor than have room there.
    """

    thickness: float = 2.0
    reopened: float = 1.0
    buffer: float = 1.0
    first: float = 2.0


class LayerReport(Protocol):
    """Called after each layer: batch number, spheres placed, altitude of the surface [m], thrown back."""

    def __call__(self, batch: int, placed: int, level: float, thrown_back: int) -> None:
        """Take notice."""


def fill_in_layers(
    region: Region,
    supply: Supply,
    pile: Pile,
    zone_index: int,
    recipe: Recipe,
    plan: LayerPlan,
    rng: np.random.Generator,
    on_layer: LayerReport,
    first_batch: int = 0,
    stats: SettleStats | None = None,
    device: str = "cpu",
) -> int:
    """Fill a region until the supply is finished or nothing more fits.

    Args:
        region: The zone's space.
        supply: The spheres to place; those that find no place go back to it.
        pile: The spheres placed so far; grows.
        zone_index: Number of the zone.
        recipe: Constants of the optimiser.
        plan: Thickness of the layers.
        rng: Draws the start positions.
        on_layer: Called after each layer.
        first_batch: Number of the first layer.
        stats: Counters to add to.
        device: Where the sweeps run; see ``projection.settle``.

    Returns:
        Number of the next batch.
    """
    stats = stats if stats is not None else SettleStats()
    loop = _Zone(region, supply, pile, zone_index, recipe, plan, rng, stats, device)
    batch, stalled, thrown_back = first_batch, 0.0, 0
    while not supply.finished and stalled < STALLED_MAX and loop.base < region.ceiling:
        gained, back, tried = loop.add_layer(batch)
        thrown_back += back
        stalled = 0.0 if gained > STALLED_SHARE or not loop.started else stalled + failure(tried)
        if stalled >= STALLED_MAX and not supply.finished and loop.climb():
            # Above a throat may be another chamber; one layer there will tell.
            stalled = STALLED_MAX - 1.0
        batch += 1
        on_layer(batch, len(pile), loop.level, thrown_back)
    return batch


def failure(tried: int) -> float:
    """Return how much a layer says that gained nothing: 1 where it found no room, or tried enough."""
    return min(1.0, tried / TRIES_MIN) if tried else 1.0


class _Zone:
    """The state of filling one zone."""

    def __init__(
        self,
        region: Region,
        supply: Supply,
        pile: Pile,
        zone_index: int,
        recipe: Recipe,
        plan: LayerPlan,
        rng: np.random.Generator,
        stats: SettleStats,
        device: str,
    ) -> None:
        self.region, self.supply, self.pile = region, supply, pile
        self.zone_index, self.recipe, self.plan = zone_index, recipe, plan
        self.rng, self.stats, self.device = rng, stats, device
        self.diameter = 2.0 * supply.radius_by_volume
        self.spare = SPARE_STARTS if supply.radius_max > 2.0 * supply.radius_min else 1
        self.start_fraction = supply.solid_fraction(START_FRACTION)
        self.climbed = -math.inf
        self.started = self.closing = False
        self.portion = 1.0  # of the spheres that a layer has room for: less after an overfull one
        self.map = ColumnMap.over(region, 2.0 * supply.radius_reference)
        # Where large spheres stand out of small ones, the surface that the next large ones meet is theirs.
        wide = ColumnMap.over(region, 2.0 * max(supply.radius_by_volume, supply.radius_reference))
        self.wide_column = wide.index(self.map.points(np.zeros(self.map.count)))
        # Spheres of earlier zones may be larger: what they cover goes that much farther.
        self.reach = 2.0 * max(supply.radius_max, float(pile.front.radius.max(initial=0.0)))
        beds, standing = beds_of_zones(pile.front, region, self.map, self.diameter)
        self.ground = self.map.tops(standing.position, standing.radius)
        self.overhead = self.map.tops(beds.position, beds.radius)
        self.level = self.base = lowest_ground(standing, region, supply.radius_reference)
        self.buried_tops = np.full(self.map.count, -np.inf)
        self.roofed = np.zeros(self.map.count, bool)

    @property
    def thickness(self) -> float:
        """Thickness of the next layer [m]."""
        return self.plan.thickness * self.diameter * (1.0 if self.started else self.plan.first)

    def add_layer(self, batch: int) -> tuple[float, int, int]:
        """Add one layer; return (share of its volume gained, spheres thrown back, spheres to be placed).

        An overfull layer, which is undone and comes again with fewer spheres, counts as if it had found room:
        it says nothing of whether the zone is full.
        """
        front = self.pile.front
        tops = self._surface(front)
        start, draw = self._assigned(self._starts(tops), front)
        tried = len(draw.radius)
        # Stragglers go on top of what is there: to move it again would throw as many back as it places.
        reopened = self._reopened(front, tops, start) & (not self.closing)
        self.closing = self.closing or self.supply.finished
        moving = joined([self._new(start, draw, batch), front[reopened]])
        fixed = front[~reopened]
        moving, thrown = self._settled(moving, fixed)
        volume = float(np.sum(cube(moving.radius)) - np.sum(cube(front.radius[reopened])))
        gained = volume / float(np.sum(cube(draw.radius))) if tried else min(volume, 0.0)
        if self._overfull(gained):
            self.supply.put_back(draw)
            return 1.0, tried, tried
        if gained < 0.0:
            # Between the last nooks a layer may cost more than it brings: then it has not been.
            self.supply.put_back(draw)
            return 0.0, tried, tried
        if len(thrown):
            self.supply.put_back(Draw(thrown.radius, thrown.set_index))
        self.pile.front = joined([fixed, moving])
        self.started = self.started or gained > 0.0
        if not self.started:
            # The tip of a hopper, too narrow for a sphere: look for the first place where one fits.
            self.base += 0.25 * self.diameter * failure(tried)
        self._bury()
        return gained, len(thrown), tried

    def _overfull(self, gained: float) -> bool:
        """Tell whether a layer is to be undone and tried with fewer spheres; set the next one's portion."""
        if gained >= POOR_SHARE or self.spare == 1 or self.closing or not self.started:
            self.portion = min(2.0 * self.portion, 1.0)
            return False
        if self.portion <= PORTION_MIN:
            return False
        self.portion *= 0.5
        return True

    def climb(self) -> bool:
        """Raise the level to the next room between non-convex walls or earlier beds; False: there is none."""
        if self.region.sides is None and not np.isfinite(self.overhead).any():
            return False
        while self.level < self.region.ceiling - self.diameter:
            self.level += 0.5 * self.diameter
            self.climbed = self.level
            if len(self._starts(self._surface(self.pile.front))):
                return True
        return False

    def _assigned(self, points: Float64Array, front: Spheres) -> tuple[Float64Array, Draw]:
        """Take a sphere for each start position; of broad sizes large ones choose first [m], (n, 3)."""
        if self.spare == 1:
            draw = self.supply.take(len(points))
            return points[: len(draw.radius)], draw
        draw = self._taken(self.portion * len(points) / self.spare)
        seams = self.region.walls.seams
        chosen, found = assign_starts(points, draw.radius, front.position, front.radius, seams)
        start, last = points[chosen[found]], self.supply.finished
        self.supply.put_back(Draw(draw.radius[~found], draw.set_index[~found]))
        draw = Draw(draw.radius[found], draw.set_index[found])
        return (self._lifted(start, draw.radius) if last else start), draw

    def _taken(self, places: float) -> Draw:
        """Take the spheres that so many places of mean volume have room for.

        Of an endless supply no more volume than that: its large ones, put back first, would fill layer by
        layer what is left below a lid, and all be put back again.
        """
        draw = self.supply.take(max(int(places), 1))
        if self.supply.asked is not None:
            return draw
        volume = np.cumsum(UNIT_VOLUME * cube(draw.radius))
        count = max(int(np.searchsorted(volume, places * self.supply.mean_volume, side="right")), 1)
        self.supply.put_back(Draw(draw.radius[count:], draw.set_index[count:]))
        return Draw(draw.radius[:count], draw.set_index[:count])

    def _lifted(self, start: Float64Array, radius: Float64Array) -> Float64Array:
        """Return start positions on the bed, not in it, where there is room above: for the last spheres."""
        lifted = start + radius[:, None] * self.region.frame[2]
        room = self.region.clearance(lifted, self.supply.radius_reference) > 0.0
        return np.where(room[:, None], lifted, start)

    def _reopened(self, front: Spheres, tops: Float64Array, start: Float64Array) -> NDArray[np.bool_]:
        """Tell which spheres at rest move again: those of this zone just below the newcomers, (N,) bool."""
        column = self.map.index(front.position)
        depth = tops[column] - components(front.position, self.region.frame[2])
        fresh = np.zeros(self.map.count)
        fresh[self.map.index(start)] = 1.0
        touched = self.map.nearby(fresh, 2.0 * self.supply.radius_max, maximum_filter) > 0.0
        shallow = depth < self.plan.reopened * self.diameter
        return np.asarray(shallow & touched[column] & (front.zone_index == self.zone_index))

    def _settled(self, moving: Spheres, fixed: Spheres) -> tuple[Spheres, Spheres]:
        ball = np.empty((len(moving) + len(fixed), 4))
        ball[: len(moving), :3], ball[len(moving) :, :3] = moving.position, fixed.position
        ball[: len(moving), 3], ball[len(moving) :, 3] = moving.radius, fixed.radius
        position, kept = settle(
            ball,
            len(moving),
            self.region.walls,
            self.region.down,
            self.recipe,
            self.stats,
            device=self.device,
        )
        bottom = components(position, self.region.frame[2]) - moving.radius
        # What slipped down to the buried spheres could overlap one of them unseen.
        buried = self.map.nearby(self.buried_tops, self.reach, maximum_filter)
        kept &= bottom > buried[self.map.index(position)]
        kept &= self.region.holds(position)
        settled = Spheres(position, moving.radius, moving.set_index, moving.zone_index, moving.batch_index)
        return settled[kept], settled[~kept]

    def _surface(self, front: Spheres) -> Float64Array:
        """Return the tops of the bed's columns, spheres far above the new layer left out [m]."""
        front = front[front.zone_index == self.zone_index]
        altitude = components(front.position, self.region.frame[2])
        highest = 1.5 * max(self.plan.first, 1.0) * self.plan.thickness * self.diameter
        below = altitude <= self.level + highest
        tops = self.map.tops(front.position[below], front.radius[below])
        # The bed of earlier zones that this one stands on; what towers beside it is none of its surface.
        under = self.ground <= self.level + self.thickness
        tops[under] = np.maximum(tops[under], self.ground[under])
        below = self.overhead <= self.level
        tops[below] = np.maximum(tops[below], self.overhead[below])
        found = np.isfinite(tops)
        # A bed that ends below a zone leaves the zone to stand on its own floor.
        tops[found] = np.maximum(tops[found], self.region.floor)
        # Under a roof the bed ends: such columns say nothing of the surface, nor keep their neighbours open.
        radius = self.supply.radius_reference
        above = self.map.points(np.where(found, tops, self.level) + radius)
        self.roofed = found & (self.region.clearance(above, radius) < 0.0)
        if (self.roofed == found).all() and found.any():
            # A tube so narrow that its wall is near everywhere, below as above: that is no roof.
            below_it = self.map.points(np.where(found, tops, self.level) - radius)[found]
            self.roofed &= not (self.region.clearance(below_it, radius) < 0.0).all()
        open_above = found & ~self.roofed
        # What was left behind below a throat is not the surface any more.
        open_above &= tops > self.climbed - self.thickness
        if open_above.any():
            # Nor is a hollow under a roof that a column's middle misses: it would hold the level down.
            open_above &= tops > np.median(tops[open_above]) - self.thickness
        level = self._level(tops, open_above) if open_above.any() else self.level
        self.level = max(level, self.climbed)
        if not found.any() or not self.started:
            # What is found before the first sphere is the foot of earlier beds, not a surface to fill up to.
            self.level = max(self.base, self.climbed)
        tops[~found] = self.level
        return np.maximum(tops, self.ground)

    def _level(self, tops: Float64Array, open_above: NDArray[np.bool_]) -> float:
        """Return the mean altitude of the surface [m], in columns as wide as the large spheres."""
        highest = np.full(int(self.wide_column.max()) + 1, -np.inf)
        np.maximum.at(highest, self.wide_column[open_above], tops[open_above])
        return float(highest[np.isfinite(highest)].mean())

    def _starts(self, tops: Float64Array) -> Float64Array:
        """Return start positions between the bed and the new layer's top, (n, 3); the last few on the bed."""
        region, thickness = self.region, self.thickness
        top = self.level + thickness
        low = min(max(float(tops.min()), self.level - thickness), top)
        least, most = region.rectangle()
        density = self.spare * self.start_fraction / self.supply.mean_volume
        mean = density * float(np.prod(most - least)) * (top - low)
        if self.supply.remaining is not None:
            # Of a few spheres in a wide vessel: the lowest of so many places are low enough.
            mean = min(mean, max(STARTS_A_SPHERE * self.spare * self.supply.remaining, STARTS_MIN))
        count = int(self.rng.poisson(mean))
        points = self._open(region.sample(self.rng, count, low, top), tops)
        if len(points) == 0:
            points = self._open(region.sample(self.rng, SEARCH_POINTS, low, top), tops)[:1]
        return points

    def _open(self, points: Float64Array, tops: Float64Array) -> Float64Array:
        """Return the points above the bed and inside the walls, (n, 3); the lowest where few are wanted."""
        region, thickness = self.region, self.thickness
        own = tops[self.map.index(points)]
        height = components(points, region.frame[2]) - own
        clearance = region.clearance(points, self.supply.radius_reference)
        remaining = self.supply.remaining
        if remaining is not None and self.spare > 1:
            # The lowest of all places may be inside large spheres: the last ones need some to choose from.
            remaining = max(self.spare * remaining, PLACES_MIN)
        # Spheres start off the walls, but for where these stand so near that little room is left.
        close = -0.5 * self.supply.radius_reference
        if (clearance >= 0.0).sum() > NARROW_SHARE * (clearance >= close).sum():
            close = 0.0
        near = height <= 2.0 * thickness
        if region.sides is not None:
            # Over a roof begins another space, whose floor is nowhere near the bed below.
            over = components(points, region.frame[2]) >= self.level - thickness
            near |= self.roofed[self.map.index(points)] & over
        open_space = (height >= 0.0) & near & (clearance >= close)
        points, height = points[open_space], height[open_space]
        if remaining is not None and remaining < len(points):
            points = points[np.sort(np.argsort(height, kind="stable")[:remaining])]
        return np.asarray(points)

    def _new(self, start: Float64Array, draw: Draw, batch: int) -> Spheres:
        count = len(draw.radius)
        zone, batches = np.full(count, self.zone_index, np.int32), np.full(count, batch, np.int32)
        return Spheres(start, draw.radius, draw.set_index, zone, batches)

    def _bury(self) -> None:
        """Put away what lies too deep below every surface nearby for the next layers to reach."""
        front = self.pile.front
        tops = self.map.tops(front.position, front.radius)
        tops[np.isneginf(tops)] = self.level
        tops[self.roofed] = np.inf
        lowest = self.map.nearby(tops, self.reach, minimum_filter)
        margin = (self.plan.reopened + self.plan.buffer) * self.diameter + 2.0 * self.supply.radius_max
        index = self.map.index(front.position)
        top = components(front.position, self.region.frame[2]) + front.radius
        deep = top < np.minimum(lowest[index], self.level) - margin
        np.maximum.at(self.buried_tops, index[deep], top[deep])
        self.pile.bury(deep)
