"""The outer loop of a bed without a floor: where a box wraps around along gravity, the zone fills at once.

Nothing can sink in an endless bed. As many spheres as a poured bed has start at random places, overlapping,
and are parted. Those that find no place are tried again in the largest voids, and all of the zone moves.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packgen.arrange.collective.layer_starts import SPARE_STARTS
from packgen.arrange.collective.layers import STALLED_MAX
from packgen.arrange.collective.open_zone import LayerReport, OpenZone, no_report
from packgen.arrange.collective.starts import assign_starts
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.space.lowest_place import lowest_place
from packgen.arrange.spheres import Spheres, joined
from packgen.arrays import Float64Array
from packgen.bodies import whole_bodies
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube, octaves
from packgen.supply.supply import Draw

FULL = 0.61
"""Solid fraction at which a zone of equal spheres is full: that of the core of beds that ``layers`` makes."""

WALL_SHELL = 0.25
"""Space lost at a wall, in reference radii, by the lower density there: measured between walls 14 diameters
apart, where it leaves the core as dense as without walls."""

STEP = 0.02
"""Share of the zone's spheres that a round adds once the zone is full, where more are asked for."""

SAMPLES = 200_000
"""Random points that measure the room of a zone; a whole box is measured exactly."""

VOID_SAMPLES = 20
"""Random points for each sphere of the zone, among which the largest voids are sought."""


def fill_at_once(
    zone: OpenZone, recipe: Recipe, on_round: LayerReport = no_report, first_batch: int = 0
) -> int:
    """Fill a zone without a floor until the supply is finished or nothing more fits.

    Args:
        zone: The zone; its pile grows.
        recipe: Constants of the optimiser; its steps down are left out.
        on_round: Called after each round.
        first_batch: Number of the first round.

    Returns:
        Number of the next batch.
    """
    cell = _Cell(zone, recipe)
    region = zone.region
    batch, stalled = first_batch, 0
    while cell.missing and stalled < STALLED_MAX:
        gained = cell.add(batch)
        stalled = 0 if gained > 0 else stalled + 1
        batch += 1
        # A zone as wide as its sphere has no room by points.
        share = cell.solid / (max(cell.full * cell.room, cell.solid) or 1.0)
        level = region.floor + share * (region.ceiling - region.floor)
        on_round(batch, len(zone.pile), level, zone.stats.thrown_back)
    return batch


class _Cell:
    """The state of filling one zone.

    Attributes:
        full: Solid fraction at which the zone is full.
        room: Space for the centres of the zone's spheres [m3].
        solid: Volume of the spheres with their centres there [m3].
    """

    def __init__(self, zone: OpenZone, recipe: Recipe) -> None:
        self.zone, self.region, self.supply = zone, zone.region, zone.supply
        # The same sweeps without the sinking: time for random starts to part before any is given up.
        self.recipe = replace(recipe, sink_first=0.0, sink_last=0.0)
        self.full = zone.supply.solid_fraction(FULL)
        self.room = self._room()
        front, region = zone.pile.front, zone.region
        within = region.clearance(front.position) >= 0.0 if len(front) else np.zeros(0, bool)
        within &= (
            (front.position >= region.bounds[0]) & (front.position <= region.bounds[1])
        ).all(axis=1)  # fmt: skip
        self.solid = _volume(front.radius[within])

    @property
    def missing(self) -> int:
        """Number of spheres still to be placed; in a zone without an amount, until it is full."""
        if self.supply.remaining is not None:
            return self.supply.remaining
        # A zone hardly larger than a sphere has little room by points, and may hold one all the same.
        least = 0 if (self.zone.pile.front.zone_index == self.zone.index).any() else 1
        return max(round((self.full * self.room - self.solid) / self.supply.mean_volume), least)

    def add(self, batch: int) -> int:
        """Add spheres until the zone is full, or a few more to a full one; return how many are gained."""
        zone, front = self.zone, self.zone.pile.front
        own = front.zone_index == zone.index
        draw = self._take(round(STEP * int(own.sum())))
        start, draw = self._starts(draw, front, crowded=bool(own.any()))
        moving = joined([zone.newcomers(start, draw, batch), front[own]])
        position, kept = zone.settled(moving, front[~own], self.recipe)
        kept = whole_bodies(kept, moving.body_index)
        gained = int(kept.sum()) - int(own.sum())
        if gained <= 0:
            # No net gain: the round is discarded.
            self.supply.put_back(draw)
            return 0
        parted = replace(moving, position=position)
        zone.put_back(moving[~kept])
        zone.pile.front = joined([front[~own], parted[kept]])
        self.solid += _volume(moving.radius[kept]) - _volume(front.radius[own])
        return gained

    def _take(self, least: int) -> Draw:
        """Take the spheres that fill the zone; where more are asked for, at least ``least``."""
        open_end = self.supply.remaining is None
        least = 1 if open_end else max(least, 1)
        wanted = self.full * self.room - self.solid
        draw = self.supply.take(max(round(wanted / self.supply.mean_volume), least))
        while open_end and _volume(draw.radius) < wanted - 0.5 * self.supply.mean_volume:
            more = self.supply.take(max(len(draw.radius) // 20, 1))
            draw = Draw(
                np.concatenate([draw.radius, more.radius]), np.concatenate([draw.set_index, more.set_index])
            )
        total = np.cumsum(UNIT_VOLUME * cube(draw.radius))
        fitting = max(int(np.searchsorted(total, wanted + 0.5 * self.supply.mean_volume)), least)
        self.supply.put_back(Draw(draw.radius[fitting:], draw.set_index[fitting:]))
        return Draw(draw.radius[:fitting], draw.set_index[:fitting])

    def _starts(self, draw: Draw, front: Spheres, *, crowded: bool) -> tuple[Float64Array, Draw]:
        """Return where spheres start [m], (n, 3), and those that have a start; the others go back."""
        count, broad = len(draw.radius), self.supply.broad
        wanted = VOID_SAMPLES * (len(front) + count) if crowded else count * (SPARE_STARTS if broad else 1)
        points = self._points(wanted)
        if len(points) == 0 and not crowded:
            place = lowest_place(self.region, float(draw.radius.min()))
            points = points if place.center is None else place.center[None]
        if crowded:
            points = self._voids(points, front, count)
        if not broad:
            start, found = points[:count], np.arange(count) < len(points)
        else:
            seams = self.region.walls.seams
            chosen, found = assign_starts(points, draw.radius, front.position, front.radius, seams)
            start = points[chosen[found]]
        self.supply.put_back(Draw(draw.radius[~found], draw.set_index[~found]))
        return start, Draw(draw.radius[found], draw.set_index[found])

    def _points(self, count: int) -> Float64Array:
        """Return random points of the region, (n, 3); fewer where little of its bounds is inside."""
        low, high = self.region.bounds
        parts, found = [np.empty((0, 3))], 0
        for _ in range(20):
            points = low + self.zone.rng.random((count, 3)) * (high - low)
            inside = self.region.clearance(points, 0.5 * self.supply.radius_reference) >= 0.0
            parts.append(points[inside])
            found += int(inside.sum())
            if found >= count:
                break
        return np.concatenate(parts)[:count]

    def _voids(self, points: Float64Array, front: Spheres, count: int) -> Float64Array:
        """Return the points farthest from all spheres, at least a mean diameter from each other, (n, 3)."""
        seams = self.region.walls.seams
        distance = np.full(len(points), np.inf)
        octave = octaves(front.radius / front.radius.min())
        for value in np.unique(octave):
            chosen = octave == value
            nearest, index = seams.tree(front.position[chosen]).query(seams.placed(points))
            distance = np.minimum(distance, nearest - front.radius[chosen][index])
        points = points[np.argsort(-distance, kind="stable")][: 20 * count]
        tree, placed = seams.tree(points), seams.placed(points)
        free = np.ones(len(points), bool)
        picked: list[int] = []
        for place in range(len(points)):
            if free[place] and len(picked) < count:
                picked.append(place)
                free[tree.query_ball_point(placed[place], 2.0 * self.supply.radius_reference)] = False
        return points[picked]

    def _room(self) -> float:
        """Return the space of centres that is as dense as the core [m3]."""
        low, high = self.region.bounds
        points = low + np.random.default_rng(0).random((SAMPLES, 3)) * (high - low)
        inside = self.region.clearance(points, WALL_SHELL * self.supply.radius_reference) >= 0.0
        return float(np.prod(high - low)) * float(inside.mean())


def _volume(radius: Float64Array) -> float:
    return float(UNIT_VOLUME * cube(radius).sum())
