"""Where the front of a zone begins: at its walls, at spheres that are there, or in its middle."""

from __future__ import annotations

import math

import numpy as np
from scipy.ndimage import distance_transform_edt

from packgen.arrange.advancing_front.growth import Growth
from packgen.arrange.advancing_front.place_kernels import ALTITUDE, DEPTH, DISTANCE, Aim
from packgen.arrange.advancing_front.start_kernels import free_points, loosen, lowered, set_down, sow
from packgen.arrange.space.region import Region
from packgen.arrays import Float64Array, Int64Array
from packgen.portable import components

SHELL = 1.0
"""Thickness of the layer at the walls in which starts are drawn, in mean radii."""

SOWN = 0.6
"""Starts tried for each disc of a mean sphere that a wall has room for: about a quarter of it is covered."""

FLAT = 0.9
"""Least cosine of a floor's slope for spheres to lie on it alone."""

POINTS_MAX = 4_000_000

DEPTH_CELLS = 4_000_000

SAMPLES = 40_000
"""Random points that find the room that is left."""


def aim_of(region: Region, rule: str, mean_radius: float, *, from_walls: bool) -> Aim:
    """Return which places are best.

    Args:
        region: The zone.
        rule: ``lowest`` or ``nearest``.
        mean_radius: Mean radius [m].
        from_walls: Whether ``nearest`` is nearest to the walls; else to the middle.
    """
    nothing = np.zeros((2, 2, 2))
    if rule == "lowest":
        return Aim(ALTITUDE, np.array(region.frame[2]), nothing, np.zeros(3), np.ones(3))
    if not from_walls:
        return Aim(DISTANCE, region.bounds.mean(axis=0), nothing, np.zeros(3), np.ones(3))
    low, high = region.bounds
    extent = high - low
    step = max(mean_radius, (float(np.prod(extent)) / DEPTH_CELLS) ** (1.0 / 3.0))
    cells = np.maximum(np.ceil(extent / step).astype(np.int64), 1)
    steps = extent / cells
    axes = [low[axis] + (np.arange(cells[axis]) + 0.5) * steps[axis] for axis in range(3)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    inside = (region.clearance(points) >= 0.0).reshape(tuple(cells))
    wraps = region.walls.seams.period > 0.0
    rim = np.pad(inside, [(0, 0) if each else (1, 1) for each in wraps])
    depth = np.asarray(distance_transform_edt(rim, sampling=steps), np.float64)
    depth = np.pad(depth, [(1, 1) if each else (0, 0) for each in wraps], mode="wrap")
    return Aim(DEPTH, np.zeros(3), depth, low - 0.5 * steps, steps)


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
        """Place spheres apart from each other on the floor, or on all walls, where these are best."""
        aim = self._growth.rule.aim
        if aim.kind == DISTANCE:
            return
        low, high = self._region.bounds
        share = SOWN / (math.pi * SHELL * mean_radius * mean_radius * mean_radius)
        count = min(math.ceil(float(np.prod(high - low)) * share) + 200, POINTS_MAX)
        points = low + self._rng.random((count, 3)) * (high - low)
        room = self._region.clearance(points, 0.0)
        points = points[(room > 0.0) & (room < (1.0 + SHELL) * 1.5 * mean_radius)]
        if aim.kind == ALTITUDE and len(points):
            altitude = components(points, aim.vector)
            lowest = float(altitude.min()) + 3.0 * self._growth.bed.radius_max[0]
            sow(self._growth.bed, self._growth.front, points, FLAT, aim, lowest, draws_max)
        elif len(points):
            sow(self._growth.bed, self._growth.front, points, -2.0, aim, np.inf, draws_max)

    def somewhere(self, draw: int) -> bool:
        """Place a draw where there is room for it, if anywhere, and let the front go on from there."""
        growth, aim = self._growth, self._growth.rule.aim
        radius = float(growth.front.draw[draw])
        low, high = self._region.bounds
        points = low + self._rng.random((SAMPLES, 3)) * (high - low)
        points = points[self._region.clearance(points, radius) >= 0.0]
        points = points[free_points(growth.bed, points, radius)]
        if len(points) == 0:
            return False
        if aim.kind == ALTITUDE:
            best = points[np.argmin(components(points, aim.vector))].copy()
            lowered(growth.bed, best, radius, aim.vector)
        else:
            away = points - (aim.vector if aim.kind == DISTANCE else self._region.bounds.mean(axis=0))
            best = points[np.argmin((away * away).sum(axis=1))].copy()
        number = set_down(growth.bed, growth.front, best, draw)
        growth.provide(np.array([number], np.int64))
        return True

    def loosely(self, spheres: Int64Array, draw: int) -> bool:
        """Let one of some spheres keep a place with fewer than three contacts; tell whether it does."""
        growth = self._growth
        return any(
            loosen(growth.bed, growth.front, growth.rule, int(s), draw) > 0 for s in spheres
        )


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
