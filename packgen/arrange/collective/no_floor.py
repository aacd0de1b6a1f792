"""The outer loop of a bed without a floor: where a box wraps around along gravity, the zone fills at once.

Nothing can sink in an endless bed: as many spheres as make a poured bed start at random places, overlapping,
and are parted. Those that find no place are tried again in the largest voids, and all of the zone moves.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packgen.arrange.collective.layers import SPARE_STARTS, STALLED_MAX, LayerReport
from packgen.arrange.collective.starts import assign_starts
from packgen.arrange.pile import Pile
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.projection.settle import SettleStats, settle
from packgen.arrange.space.region import Region
from packgen.arrange.spheres import Spheres, joined
from packgen.arrays import Float64Array
from packgen.portable import cube, octaves
from packgen.supply.supply import Draw, Supply

FULL = 0.61
"""Solid fraction at which a zone of equal spheres is full: that of the core of beds that ``layers`` makes."""

WALL_SHELL = 0.25
"""Space lost at a wall, in reference radii, by the lower density there: measured between walls 14 diameters
apart, where it leaves the core as dense as without walls."""

STEP = 0.02
"""Share of the zone's spheres that a round adds once it is full, for a zone that asks for more."""

SAMPLES = 200_000
"""Points by which the room of a zone is measured; exact where the zone is a whole box."""

VOID_SAMPLES = 20
"""Random points a sphere of the zone among which the largest voids are looked for."""


def fill_at_once(
    region: Region,
    supply: Supply,
    pile: Pile,
    zone_index: int,
    recipe: Recipe,
    rng: np.random.Generator,
    on_round: LayerReport,
    first_batch: int = 0,
    device: str = "cpu",
) -> int:
    """Fill a region without a floor until the supply is finished or nothing more fits.

    Args:
        region: The zone's space.
        supply: The spheres to place; those that find no place go back to it.
        pile: The spheres placed so far; grows.
        zone_index: Number of the zone.
        recipe: Constants of the optimiser; its steps down are left out.
        rng: Draws the start positions.
        on_round: Called after each round.
        first_batch: Number of the first round.
        device: Where the sweeps run; see ``projection.settle``.

    Returns:
        Number of the next batch.
    """
    cell = _Cell(region, supply, pile, zone_index, recipe, rng, device)
    batch, stalled = first_batch, 0
    while cell.missing and stalled < STALLED_MAX:
        gained = cell.add(batch)
        stalled = 0 if gained > 0 else stalled + 1
        batch += 1
        share = cell.solid / max(cell.full * cell.room, cell.solid)
        level = region.floor + share * (region.ceiling - region.floor)
        on_round(batch, len(pile), level, cell.stats.thrown_back)
    return batch


class _Cell:
    """The state of filling one zone.

    Attributes:
        full: Solid fraction at which the zone is full.
        room: Space that spheres of the zone have their centres in [m3].
        solid: Volume of the spheres with their centres there [m3].
    """

    def __init__(
        self,
        region: Region,
        supply: Supply,
        pile: Pile,
        zone_index: int,
        recipe: Recipe,
        rng: np.random.Generator,
        device: str,
    ) -> None:
        self.region, self.supply, self.pile, self.zone_index = region, supply, pile, zone_index
        self.rng, self.device, self.stats = rng, device, SettleStats()
        # The same sweeps without the sinking: time for random starts to part before any is given up.
        self.recipe = replace(recipe, sink_first=0.0, sink_last=0.0)
        self.full = supply.solid_fraction(FULL)
        self.room = self._room()
        front = pile.front
        within = region.clearance(front.position) >= 0.0 if len(front) else np.zeros(0, bool)
        within &= (
            (front.position >= region.bounds[0]) & (front.position <= region.bounds[1])
        ).all(axis=1)  # fmt: skip
        self.solid = _volume(front.radius[within])

    @property
    def missing(self) -> int:
        """How many spheres are still to be placed; of a zone without an amount, until it is full."""
        if self.supply.remaining is not None:
            return self.supply.remaining
        return max(round((self.full * self.room - self.solid) / self.supply.mean_volume), 0)

    def add(self, batch: int) -> int:
        """Add spheres up to a full zone, or a few more to one that is; return how many are gained."""
        front = self.pile.front
        own = front.zone_index == self.zone_index
        draw = self._take(round(STEP * int(own.sum())))
        start, draw = self._starts(draw, front, crowded=bool(own.any()))
        moving = joined([self._new(start, draw, batch), front[own]])
        position, kept = settle(
            np.column_stack(
                [
                    np.concatenate([moving.position, front.position[~own]]),
                    np.concatenate([moving.radius, front.radius[~own]]),
                ]
            ),
            len(moving),
            self.region.walls,
            self.region.down,
            self.recipe,
            self.stats,
            device=self.device,
        )
        kept &= self.region.holds(position)
        gained = int(kept.sum()) - int(own.sum())
        if gained <= 0:
            # The newcomers cost as many as they are: then they have not been.
            self.supply.put_back(draw)
            return 0
        parted = replace(moving, position=position)
        self.supply.put_back(Draw(moving.radius[~kept], moving.set_index[~kept]))
        self.pile.front = joined([front[~own], parted[kept]])
        self.solid += _volume(moving.radius[kept]) - _volume(front.radius[own])
        return gained

    def _take(self, least: int) -> Draw:
        """Take spheres up to a full zone; where more are asked for, at least so many."""
        open_end = self.supply.remaining is None
        least = 1 if open_end else max(least, 1)
        wanted = self.full * self.room - self.solid
        draw = self.supply.take(max(round(wanted / self.supply.mean_volume), least))
        while open_end and _volume(draw.radius) < wanted - 0.5 * self.supply.mean_volume:
            more = self.supply.take(max(len(draw.radius) // 20, 1))
            draw = Draw(
                np.concatenate([draw.radius, more.radius]), np.concatenate([draw.set_index, more.set_index])
            )
        total = np.cumsum(4.0 / 3.0 * np.pi * cube(draw.radius))
        fitting = max(int(np.searchsorted(total, wanted + 0.5 * self.supply.mean_volume)), least)
        self.supply.put_back(Draw(draw.radius[fitting:], draw.set_index[fitting:]))
        return Draw(draw.radius[:fitting], draw.set_index[:fitting])

    def _starts(self, draw: Draw, front: Spheres, *, crowded: bool) -> tuple[Float64Array, Draw]:
        """Return where spheres start [m], (n, 3), and those that have a start; the others go back."""
        count, broad = len(draw.radius), self.supply.radius_max > 2.0 * self.supply.radius_min
        wanted = VOID_SAMPLES * (len(front) + count) if crowded else count * (SPARE_STARTS if broad else 1)
        points = self._points(wanted)
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
            points = low + self.rng.random((count, 3)) * (high - low)
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

    def _new(self, start: Float64Array, draw: Draw, batch: int) -> Spheres:
        count = len(draw.radius)
        zone, batches = np.full(count, self.zone_index, np.int32), np.full(count, batch, np.int32)
        return Spheres(start, draw.radius, draw.set_index, zone, batches)

    def _room(self) -> float:
        """Return the space of centres that is as dense as the core [m3]."""
        low, high = self.region.bounds
        points = low + np.random.default_rng(0).random((SAMPLES, 3)) * (high - low)
        inside = self.region.clearance(points, WALL_SHELL * self.supply.radius_reference) >= 0.0
        return float(np.prod(high - low)) * float(inside.mean())


def _volume(radius: Float64Array) -> float:
    return float(4.0 / 3.0 * np.pi * cube(radius).sum())
