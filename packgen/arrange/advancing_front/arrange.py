"""ADVANCING_FRONT: spheres put one by one where they touch three others or walls."""

from __future__ import annotations

import numpy as np

from packgen.arrange.advancing_front.fill import fill_voids
from packgen.arrange.advancing_front.growth import Growth
from packgen.arrange.advancing_front.start_kernels import contact_counts, repair
from packgen.arrange.advancing_front.starts import Starts, aim_of, balls_near
from packgen.arrange.space.region import Region, make_region
from packgen.arrange.spheres import Spheres
from packgen.arrange.task import Filled, Listener, Progress, Task, ZoneTask
from packgen.arrange.zones import fill_zones
from packgen.distributions import UNIT_VOLUME
from packgen.errors import PackingError
from packgen.portable import cube
from packgen.supply.supply import Draw, Supply

ROOM = 1.65
"""Largest radius for which a region is mapped, in those of the spheres: a sphere reaches three radii far."""

DRAWN_FRACTION = 0.62
"""Solid fraction for which draws are taken at first where a zone is filled."""

SPARE_DRAWS = 256
"""Draws that are left when more are taken."""

WAITING_MAX, WAITING_SHARE = 40, 0.004
"""Draws that may wait before no more are taken, and as a share of the spheres: the law is kept."""

TRIED_LOOSELY = 200
"""Spheres that are asked for places with fewer than three contacts, the last ones placed."""

RESTARTS_MAX = 1000

VOLUME_POINTS = 100_000


def arrange(task: Task) -> Spheres:
    """Fill the zones of a task; see ``fill_zones``."""
    return fill_zones(task, fill_zone)


def fill_zone(zone: ZoneTask, earlier: Spheres, rng: np.random.Generator, listener: Listener) -> Filled:
    """Fill one zone beside the spheres of earlier ones; see ``task.FillZone``.

    Raises:
        PackingError: The zone lies outside the container, or has no floor where the lowest places are best.
    """
    setting, supply = zone.setting, zone.supply.copy()
    if setting.settings.rule == "lowest" and (setting.down[list(setting.container.periodic)] != 0.0).any():
        raise PackingError(
            f"{zone.place}: found a box that wraps around along gravity, expected a floor for `rule: "
            "lowest`; take `rule: nearest`, or leave that axis out of `periodic`"
        )
    region = make_region(
        setting.container, zone.locations, setting.down, ROOM * supply.radius_max, zone.place,
        supply.radius_min,
    )  # fmt: skip
    filling = _Filling(zone, region, supply, earlier, rng, listener)
    filling.fill()
    return Filled(filling.spheres(), supply, 1)


class _Filling:
    """A zone while it is filled."""

    def __init__(
        self, zone: ZoneTask, region: Region, supply: Supply, earlier: Spheres, rng: np.random.Generator,
        listener: Listener,
    ) -> None:  # fmt: skip
        self._zone, self._region, self._supply, self._listener = zone, region, supply, listener
        self._endless = supply.remaining is None
        low, high = region.bounds
        if supply.remaining is None:
            solid = supply.solid_fraction(DRAWN_FRACTION) * float(np.prod(high - low))
            count = max(round(solid / supply.mean_volume), 2 * SPARE_DRAWS)
            self._draw = supply.take(count)
        else:
            self._draw = supply.take(supply.remaining)
        mean = float(self._draw.radius.mean())
        rule = zone.setting.settings.rule
        aim = aim_of(region, rule)
        near = balls_near(region, earlier.position, earlier.radius, 2.0 * supply.radius_max)
        self._growth = Growth(region, near, self._draw.radius, aim, rule == "lowest", rng)
        self._starts = Starts(region, self._growth, rng)
        self._mean = mean
        self._filled = np.empty((0, 4))

    def fill(self) -> None:
        """Place spheres until all are, or no place is left."""
        growth = self._growth
        self._tell(growth.first)
        self._starts.sow(self._mean, len(self._draw.radius))
        growth.provide(np.arange(growth.count))
        restarts = 0
        while restarts < RESTARTS_MAX:
            if self._advance():
                continue
            if not self._anything_left() or not self._go_on():
                break
            restarts += 1
        self._repair()
        self._fill_voids()

    def _advance(self) -> bool:
        """Place spheres; tell whether the front goes on with more draws."""
        growth = self._growth
        if not growth.advance(self._tell, SPARE_DRAWS if self._endless else 0):
            return False
        placed = growth.count - growth.first
        if len(growth.waiting) > max(WAITING_MAX, WAITING_SHARE * placed):
            self._endless = False
        else:
            more = self._supply.take(max(len(self._draw.radius) // 10, 2 * SPARE_DRAWS))
            self._draw = Draw(
                np.concatenate([self._draw.radius, more.radius]),
                np.concatenate([self._draw.set_index, more.set_index]),
            )
            growth.more_draws(more.radius)
        return True

    def _anything_left(self) -> bool:
        growth = self._growth
        return len(growth.waiting) > 0 or growth.draws_left > 0

    def _go_on(self) -> bool:
        """Give the front new places: at spheres that had no draws, loosely, or somewhere in the zone."""
        growth = self._growth
        hungry = np.flatnonzero(growth.front.hungry[: growth.count])
        if len(hungry) and len(growth.waiting):
            growth.provide(hungry)
            if growth.has_places:
                return True
        draw = growth.take()
        last = np.arange(growth.count - 1, max(growth.count - TRIED_LOOSELY, -1), -1)
        if self._starts.loosely(last, draw):
            return True
        if self._starts.somewhere(draw):
            return True
        growth.give_back(draw)
        return False

    def _repair(self) -> None:
        """Move the few spheres that touch fewer than three others or walls to where they touch three."""
        growth = self._growth
        counts = contact_counts(growth.bed, growth.first, growth.count)
        for i in growth.first + np.flatnonzero(counts < 3):
            repair(growth.bed, growth.rule, int(i))

    def _fill_voids(self) -> None:
        """Put spheres into the voids, where that is asked for."""
        fill, growth = self._zone.setting.settings.fill, self._growth
        if fill is None:
            return
        if self._supply.fill_set is None:
            raise PackingError(
                f"{self._zone.place}: found `fill` without a set for its spheres, expected one with "
                "`radius_distribution: free` among particle_sets"
            )
        most = fill.radius_max or self._supply.radius_max
        ball = growth.bed.ball[: growth.count]
        own = float((UNIT_VOLUME * cube(ball[growth.first :, 3])).sum())
        volume = np.inf if fill.until is None else fill.until * self._volume() - own
        self._filled = fill_voids(
            self._region,
            ball,
            (fill.radius_min, most),
            volume,
            lambda count: self._tell(growth.count + count),
        )
        self._supply.add_made(self._supply.fill_set, len(self._filled))

    def _volume(self) -> float:
        """Return the volume of the zone [m3], that of a location to about 1 %."""
        container, region = self._zone.setting.container, self._region
        if not self._zone.locations:
            return container.volume
        low, high = region.bounds
        points = low + np.random.default_rng(0).random((VOLUME_POINTS, 3)) * (high - low)
        return float(np.prod(high - low)) * float((region.clearance(points) >= 0.0).mean())

    def _tell(self, count: int) -> None:
        placed, total = count - self._growth.first, self._supply.asked
        share = min(placed / max(len(self._draw.radius), 1), 1.0)
        self._listener(Progress("front", placed, total, 1, share, len(self._growth.waiting)))

    def spheres(self) -> Spheres:
        """Return the spheres that were placed; the others go back to the supply."""
        growth, draw = self._growth, self._draw
        own = growth.front.draw_of[growth.first : growth.count]
        ball = growth.bed.ball[growth.first : growth.count]
        unused = np.ones(len(draw.radius), bool)
        unused[own] = False
        if unused.any():
            self._supply.put_back(Draw(draw.radius[unused], draw.set_index[unused]))
        filled = self._filled
        nothing = np.zeros(len(own) + len(filled), np.int32)
        fill_set = np.full(len(filled), self._supply.fill_set or 0, np.int32)
        return Spheres(
            np.concatenate([ball[:, :3], filled[:, :3]]), np.concatenate([draw.radius[own], filled[:, 3]]),
            np.concatenate([draw.set_index[own], fill_set]), nothing + np.int32(self._zone.index), nothing,
        )  # fmt: skip
