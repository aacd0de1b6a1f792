"""Where the front of a zone begins: at its walls, at spheres that are there, or in its middle."""

from __future__ import annotations

import math

import numpy as np

from packgen.arrange.advancing_front.growth import Growth
from packgen.arrange.advancing_front.place_kernels import ALTITUDE, DISTANCE, Aim
from packgen.arrange.advancing_front.start_kernels import free_points, loosen, lowered, set_down, sow
from packgen.arrange.space.region import Region
from packgen.arrays import Float64Array, Int64Array
from packgen.portable import components

SHELL = 1.0
"""Thickness of the layer at the walls in which starts are drawn, in mean radii."""

SOWN = 0.15
"""Starts tried for each disc of a mean sphere that a floor has room for: about an eighth of it is covered."""

FLAT = 0.9
"""Least cosine of a floor's slope for spheres to lie on it alone."""

POINTS_MAX = 4_000_000

BY_RADIUS = -2.0
"""What a sphere's radius adds to the height or distance of its place, in radii: the lower, the sooner the
large ones are placed. Beds are densest for about -2: 1:5 by 0.045 denser than for 0."""

SAMPLES = 10_000
"""Random points that find the room that is left."""

ROUNDS = 16
"""Times that points are drawn ever nearer to the best ones before nothing is said to fit."""

BEST = 100
"""Points that others are drawn near to."""


def aim_of(region: Region, rule: str) -> Aim:
    """Return which places are best by a rule, ``lowest`` or ``nearest``."""
    if rule == "lowest":
        return Aim(ALTITUDE, np.array(region.frame[2]), BY_RADIUS)
    least, _ = region.rectangle()
    corner = np.array([[*least, region.floor]])
    return Aim(DISTANCE, components(corner, region.frame.T)[0], BY_RADIUS)


class Starts:
    """Starts of a front, and what room there is left for new ones."""

    def __init__(self, region: Region, growth: Growth, rng: np.random.Generator) -> None:
        """Look at a zone.

        Args:
            region: The zone.
            growth: Its spheres.
            rng: Source of randomness.
        """
        self._region, self._growth, self._rng = region, growth, rng

    def sow(self, mean_radius: float, draws_max: int) -> None:
        """Place spheres apart from each other on the floor, where the lowest places are best."""
        aim = self._growth.rule.aim
        if aim.kind == DISTANCE:
            return
        low, high = self._region.bounds
        share = SOWN / (math.pi * SHELL * mean_radius * mean_radius * mean_radius)
        count = min(math.ceil(float(np.prod(high - low)) * share) + 200, POINTS_MAX)
        points = low + self._rng.random((count, 3)) * (high - low)
        room = self._region.clearance(points, 0.0)
        points = points[(room > 0.0) & (room < (1.0 + SHELL) * 1.5 * mean_radius)]
        if len(points):
            altitude = components(points, aim.vector)
            lowest = float(altitude.min()) + 3.0 * self._growth.bed.radius_max[0]
            sow(self._growth.bed, self._growth.front, points, FLAT, aim, lowest, draws_max)

    def somewhere(self, draw: int) -> bool:
        """Place a draw where there is room for it, if anywhere, and let the front go on from there."""
        growth, aim = self._growth, self._growth.rule.aim
        radius = float(growth.front.draw[draw])
        points = self._room_for(radius)
        if len(points) == 0:
            return False
        if aim.kind == ALTITUDE:
            best = points[np.argmin(components(points, aim.vector))].copy()
            lowered(growth.bed, best, radius, aim.vector)
        else:
            away = points - aim.vector
            best = points[np.argmin((away * away).sum(axis=1))].copy()
        number = set_down(growth.bed, growth.front, best, draw)
        growth.provide(np.array([number], np.int64))
        return True

    def _room_for(self, radius: float) -> Float64Array:
        """Return random points at which a sphere overlaps nothing, shape (P, 3).

        A zone hardly wider than the sphere holds few of them. While it is empty, more points are drawn about
        those that lack least, half as far away each time.
        """
        growth, (low, high) = self._growth, self._region.bounds
        points, spread = low + self._rng.random((SAMPLES, 3)) * (high - low), high - low
        for number in range(ROUNDS):
            points = points[free_points(growth.bed, points, radius)]
            room = self._region.clearance(points, radius)
            given_up = number == ROUNDS - 1 or len(points) == 0
            if given_up or growth.count > growth.first or (room >= 0.0).any():
                break
            best = points[np.argsort(-room, kind="stable")[:BEST]]
            around = np.repeat(best, SAMPLES // BEST, axis=0)
            spread = 0.5 * spread
            points = around + (self._rng.random(around.shape) - 0.5) * spread
        return np.asarray(points[room >= 0.0])

    def loosely(self, spheres: Int64Array, draw: int) -> bool:
        """Let one of some spheres keep a place with fewer than three contacts; tell whether it does."""
        growth = self._growth
        return any(loosen(growth.bed, growth.front, growth.rule, int(s), draw) > 0 for s in spheres)


def balls_near(region: Region, position: Float64Array, radius: Float64Array, reach: float) -> Float64Array:
    """Return centres and radii of the spheres that can touch those of a zone, shape (E, 4).

    Args:
        region: The zone.
        position: Centres of spheres that are there [m], shape (N, 3).
        radius: Their radii [m], shape (N,).
        reach: Largest diameter of the zone's own [m].
    """
    low, high = region.bounds
    beyond = radius[:, None] + reach
    near = ((position >= low - beyond) & (position <= high + beyond)).all(axis=1)
    if region.walls.seams.wraps:
        near[:] = True  # a zone's neighbours may be on the other side of the box
    return np.column_stack([position[near], radius[near]])
