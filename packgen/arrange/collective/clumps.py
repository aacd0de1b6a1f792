"""The default outer loop where particles are clumps: layers of bodies fall on a re-opened surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packgen.arrange.collective.clump_starts import Slab, started
from packgen.arrange.collective.layers import STALLED_MAX, STALLED_SHARE, failure
from packgen.arrange.collective.open_zone import LayerReport, OpenZone, no_report
from packgen.arrange.collective.plan import LayerPlan
from packgen.arrange.collective.surface import Surface
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.rigid.layer import members_at
from packgen.arrange.rigid.settle import settle_bodies
from packgen.arrange.spheres import Spheres, in_rows, joined, rows_of_bodies
from packgen.arrays import BoolArray, Float64Array, Int32Array
from packgen.bodies import Bodies, Form, joined_rows
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube
from packgen.supply.supply import Draw

BED_FRACTION, START_FRACTION = 0.55, 0.2
"""Solid fraction of a layer when it has come to rest, and about that at which its bodies start, apart."""

RETRIES, ENOUGH = 12, 0.5
"""How often places are tried anew while less than this share of a layer's bodies has one."""


def fill_with_clumps(
    zone: OpenZone,
    forms: tuple[Form | None, ...],
    recipe: Recipe,
    plan: LayerPlan,
    on_layer: LayerReport = no_report,
) -> int:
    """Fill a zone with bodies until the supply is finished or nothing more fits.

    Args:
        zone: The zone; its pile grows.
        forms: Shape of each set's particles.
        recipe: Constants of the optimiser.
        plan: Thickness of the layers.
        on_layer: Called after each layer; hears of bodies.

    Returns:
        Number of layers.
    """
    loop = _Layers(zone, forms, recipe, plan)
    surface, earlier = loop.surface, len(zone.pile)
    batch, stalled, thrown_back = 0, 0.0, 0
    while not zone.supply.finished and stalled < STALLED_MAX and surface.base < zone.region.ceiling:
        gained, back, tried = loop.add(batch)
        thrown_back += back
        stalled = 0.0 if not surface.started or gained > STALLED_SHARE else stalled + failure(tried)
        if stalled >= STALLED_MAX and not zone.supply.finished and loop.climb():
            stalled = STALLED_MAX - 1.0
        batch += 1
        on_layer(batch, earlier + loop.placed, surface.level, thrown_back)
    return batch


class _Layers:
    """Adds layer after layer to a zone.

    Attributes:
        surface: Where the next one goes.
        placed: Bodies of this zone.
    """

    def __init__(
        self, zone: OpenZone, forms: tuple[Form | None, ...], recipe: Recipe, plan: LayerPlan
    ) -> None:
        self.zone, self.forms, self.recipe = zone, forms, recipe
        self.surface = Surface(zone, plan)
        self.placed = 0
        self._closing = False

    def add(self, batch: int) -> tuple[float, int, int]:
        """Add one layer; return (share of its volume gained, bodies thrown back, bodies to be placed)."""
        zone, surface = self.zone, self.surface
        front, tops = zone.pile.front, surface.tops()
        draw, fresh = self._newcomers(tops, front)
        tried = len(fresh)
        rows = rows_of_bodies(front)
        reopened = surface.shallow(rows, tops, fresh.position) & (not self._closing)
        self._closing = self._closing or zone.supply.finished
        fixed, again = self._parted(front, rows, reopened)
        moving = joined([self._spheres(fresh, draw.set_index, batch), again])
        settled, thrown = self._settled(moving, fixed)
        volume = _volume(settled) - _volume(again)
        asked = float(UNIT_VOLUME * cube(draw.radius).sum())
        gained = volume / asked if tried else min(volume, 0.0)
        if gained < 0.0 or not tried:
            zone.supply.put_back(draw)
            if not surface.started:
                surface.base += 0.25 * surface.diameter
            return gained, tried, tried
        if len(thrown.radius):
            zone.supply.put_back(thrown)
        zone.pile.front = in_rows(joined([fixed, settled]))
        self.placed += tried - len(thrown.radius)
        surface.started = surface.started or gained > 0.0
        if not surface.started:
            surface.base += 0.25 * surface.diameter * failure(tried)
        surface.bury()
        return gained, len(thrown.radius), tried

    def _newcomers(self, tops: Float64Array, front: Spheres) -> tuple[Draw, Bodies]:
        """Take bodies for a layer, and return those that have a place above the bed."""
        zone, surface = self.zone, self.surface
        region, supply = zone.region, zone.supply
        slab = self._slab(tops)
        wanted = BED_FRACTION * region.area(surface.level + 0.5 * surface.thickness) * surface.thickness
        room = START_FRACTION * region.area(0.5 * (slab.low + slab.high)) * (slab.high - surface.level)
        count = max(int(min(wanted, 2.0 * room) / supply.mean_volume), 1)
        draw = supply.take(count)
        there = np.column_stack([front.position, front.radius])
        bodies, found = started(draw, self.forms, region, slab, there, zone.rng)
        radius, sets, placed = [draw.radius[found]], [draw.set_index[found]], [bodies[found]]
        for _ in range(RETRIES):
            # Below a lid, or with large bodies, few of the first places are free.
            draw = Draw(draw.radius[~found], draw.set_index[~found])
            if sum(len(each) for each in radius) > ENOUGH * count:
                break
            there = np.concatenate([there, members_at(bodies[found])])
            bodies, found = started(draw, self.forms, region, slab, there, zone.rng)
            radius, sets = [*radius, draw.radius[found]], [*sets, draw.set_index[found]]
            placed.append(bodies[found])
        else:
            draw = Draw(draw.radius[~found], draw.set_index[~found])
        supply.put_back(draw)
        return Draw(np.concatenate(radius), np.concatenate(sets)), joined_rows(placed)

    def _slab(self, tops: Float64Array) -> Slab:
        """Return where the bodies of the next layer start."""
        surface, region = self.surface, self.zone.region
        height = surface.thickness * BED_FRACTION / START_FRACTION
        low = max(min(float(tops.min()), surface.level), surface.level - surface.thickness, region.floor)
        return Slab(low, min(surface.level + height, region.ceiling))

    def climb(self) -> bool:
        """Raise the level to the next room between non-convex walls or earlier beds; False: there is none."""
        return self.surface.climb(self._has_room)

    def _has_room(self) -> bool:
        """Return whether a body finds a place at the level; none is taken."""
        draw, fresh = self._newcomers(self.surface.tops(), self.zone.pile.front)
        self.zone.supply.put_back(draw)
        return len(fresh) > 0

    def _spheres(self, bodies: Bodies, set_index: Int32Array, batch: int) -> Spheres:
        """Return the spheres of bodies of this zone."""
        ball = members_at(bodies)
        owner = np.repeat(np.arange(len(bodies), dtype=np.int32), bodies.sphere_count)
        zone, batches = np.full(len(ball), self.zone.index, np.int32), np.full(len(ball), batch, np.int32)
        position = self.zone.region.walls.seams.wrapped(ball[:, :3])
        return Spheres(position, ball[:, 3].copy(), set_index[owner], zone, batches, owner, bodies)

    @staticmethod
    def _parted(front: Spheres, rows: Spheres, reopened: BoolArray) -> tuple[Spheres, Spheres]:
        """Return the spheres at rest of bodies that stay, and of those that move again."""
        if not reopened.any():
            return front, front[:0]
        assert rows.body_index is not None
        assert front.body_index is not None
        moves = np.isin(front.body_index, rows.body_index[reopened])
        return front[~moves], in_rows(front[moves])

    def _settled(self, moving: Spheres, fixed: Spheres) -> tuple[Spheres, Draw]:
        """Arrange bodies among fixed spheres; return those with a place, and the others."""
        zone, region = self.zone, self.zone.region
        assert moving.bodies is not None
        there = np.column_stack([fixed.position, fixed.radius])
        bodies, kept = settle_bodies(moving.bodies, there, region.walls, region.down, self.recipe, zone.stats)
        ball = members_at(bodies)
        position = region.walls.seams.wrapped(ball[:, :3])
        sound = region.holds(position) & self.surface.above_buried(position, moving.radius)
        assert moving.body_index is not None
        np.logical_and.at(kept, moving.body_index, sound)
        mine = kept[moving.body_index]
        settled = in_rows(replace(moving, position=position, bodies=bodies)[mine])
        rows = rows_of_bodies(moving)
        return settled, Draw(bodies.size[~kept], rows.set_index[~kept])


def _volume(spheres: Spheres) -> float:
    """Return the volume of the bodies of spheres [m3]."""
    return float(UNIT_VOLUME * cube(rows_of_bodies(spheres).radius).sum())
