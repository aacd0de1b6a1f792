"""The default outer loop: thin layers on a re-opened surface, each arranged by the projection optimiser."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter

from packgen.arrange.projection import Recipe, SettleStats, settle
from packgen.arrange.region import Region, column_index, height_map
from packgen.arrange.spheres import Pile, Spheres, joined
from packgen.arrays import Float64Array
from packgen.radii import Draw, Supply

START_FRACTION = 0.6
"""Solid fraction at which a layer starts, already overlapping: that of the bed it will become."""

STALLED_MAX = 3
"""So many layers in a row that gain next to nothing: the zone is full."""


@dataclass(frozen=True, slots=True)
class LayerPlan:
    """How thick the layers are, in reference diameters (of the volume-weighted mean radius).

    Attributes:
        thickness: Thickness of a new layer.
        reopened: Depth below the surface to which spheres that came to rest move again with it.
        buffer: Depth below that to which fixed spheres are kept at hand.
    """

    thickness: float = 1.0
    reopened: float = 2.0
    buffer: float = 2.5


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

    Returns:
        Number of the next batch.
    """
    stats = stats if stats is not None else SettleStats()
    loop = _Zone(region, supply, pile, zone_index, recipe, plan, rng, stats)
    batch, stalled, thrown_back = first_batch, 0, 0
    while not supply.finished and stalled < STALLED_MAX:
        placed, back, tried = loop.add_layer(batch)
        thrown_back += back
        if tried == 0 and loop.level >= region.ceiling:
            break
        full = loop.level >= region.ceiling - loop.diameter
        stalled = stalled + 1 if full and placed <= 0.02 * tried else 0
        batch += 1
        on_layer(batch, len(pile), loop.level, thrown_back)
    return batch


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
    ) -> None:
        self.region, self.supply, self.pile = region, supply, pile
        self.zone_index, self.recipe, self.plan = zone_index, recipe, plan
        self.rng, self.stats = rng, stats
        self.diameter = 2.0 * supply.radius_reference
        self.level = region.floor

    def add_layer(self, batch: int) -> tuple[int, int, int]:
        """Add one layer; return (spheres gained, spheres thrown back, spheres that were to be placed)."""
        front = self.pile.front
        tops, columns, least = self._surface(front)
        start = self._starts(tops, columns, least)
        draw = self.supply.take(len(start))
        start = start[: len(draw.radius)]
        altitude = front.position @ self.region.frame[2]
        depth = tops[column_index(self.region, self.diameter, columns, least, front.position)] - altitude
        reopened = (depth < self.plan.reopened * self.diameter) & (front.zone_index == self.zone_index)
        moving = joined([self._new(start, draw, batch), front[reopened]])
        fixed = front[~reopened]
        if len(moving) == 0:
            self.level += 0.5 * self.diameter
            return 0, 0, 0
        moving, thrown = self._settled(moving, fixed)
        if len(thrown):
            self.supply.put_back(Draw(thrown.radius, thrown.set_index))
        self.pile.front = joined([fixed, moving])
        self._bury()
        gained = len(moving) - int(reopened.sum())
        if len(draw.radius) == 0 or gained <= 0:
            self.level += 0.5 * self.diameter
        return gained, len(thrown), len(draw.radius)

    def _settled(self, moving: Spheres, fixed: Spheres) -> tuple[Spheres, Spheres]:
        ball = np.empty((len(moving) + len(fixed), 4))
        ball[: len(moving), :3], ball[len(moving) :, :3] = moving.position, fixed.position
        ball[: len(moving), 3], ball[len(moving) :, 3] = moving.radius, fixed.radius
        position, kept = settle(
            ball, len(moving), self.region.walls, self.region.down, self.recipe, self.stats
        )
        settled = Spheres(position, moving.radius, moving.set_index, moving.zone_index, moving.batch_index)
        return settled[kept], settled[~kept]

    def _surface(self, front: Spheres) -> tuple[Float64Array, NDArray[np.int64], Float64Array]:
        """Return the height map of the bed, spheres above the new layer left out; raise the level to it."""
        altitude = front.position @ self.region.frame[2]
        below = altitude <= self.level + self.plan.thickness * self.diameter
        tops, columns, least = height_map(
            self.region, self.diameter, front.position[below], front.radius[below], -np.inf
        )
        found = np.isfinite(tops)
        if found.any():
            self.level = max(self.level, float(np.mean(tops[found])))
        tops[~found] = self.level
        return tops, columns, least

    def _starts(self, tops: Float64Array, columns: NDArray[np.int64], least: Float64Array) -> Float64Array:
        """Return start positions: uniform between the bed and the new layer's top, lowest first, (n, 3)."""
        region, thickness = self.region, self.plan.thickness * self.diameter
        top = self.level + thickness
        low = max(float(tops.min()), self.level - 3.0 * thickness)
        shadow = np.subtract(*region.rectangle()[::-1])
        density = START_FRACTION / self.supply.mean_volume
        points = region.sample(
            self.rng,
            int(self.rng.poisson(density * float(np.prod(shadow)) * (top - low))),
            low,
            top,
            radius=0.5 * self.supply.radius_reference,
        )
        altitude = points @ region.frame[2]
        above = altitude >= tops[column_index(region, self.diameter, columns, least, points)]
        points, altitude = points[above], altitude[above]
        remaining = self.supply.remaining
        if remaining is not None and remaining < len(points):
            points = points[np.argsort(altitude, kind="stable")[:remaining]]
        return points

    def _new(self, start: Float64Array, draw: Draw, batch: int) -> Spheres:
        count = len(draw.radius)
        return Spheres(
            start,
            draw.radius,
            draw.set_index,
            np.full(count, self.zone_index, np.int32),
            np.full(count, batch, np.int32),
        )

    def _bury(self) -> None:
        """Put away what lies too deep below every surface nearby for the next layers to reach."""
        front = self.pile.front
        tops, columns, least = height_map(
            self.region, self.diameter, front.position, front.radius, self.region.floor
        )
        reach = 2 * math.ceil(2.0 * self.supply.radius_max / self.diameter) + 1
        lowest = minimum_filter(tops.reshape(columns), size=reach, mode="nearest").ravel()
        index = column_index(self.region, self.diameter, columns, least, front.position)
        margin = (self.plan.reopened + self.plan.buffer) * self.diameter + 2.0 * self.supply.radius_max
        self.pile.bury(front.position @ self.region.frame[2] + front.radius < lowest[index] - margin)


Filler = Callable[..., int]
