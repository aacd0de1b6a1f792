"""How crowded a zone is: the solid fraction of its middle, and what its walls leave empty.

Scaled particle theory (Reiss, Frisch, Helfand and Lebowitz, J. Chem. Phys. 32 (1960) 119) has the tension of
a fluid of hard spheres at a hard wall, and its derivative the spheres that are missing there: of the fraction
n away from the walls, as many as in a layer of (1 - n) / (1 + 2 n) radii. In a thin gas that layer is a
radius thick, which is geometry alone; in a dense fluid spheres gather at the wall and make up for most of it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrange.neighbors.point_kernels import close_points, point_grid
from packgen.arrange.space.region import Region
from packgen.arrays import BoolArray, Float64Array
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube

SAMPLES = 8_192
"""Random points that measure the room of a zone."""

ROUNDS = 5
"""Times that the fraction and the layer that depends on it are found in turn."""


def missing_layer(fraction: float) -> float:
    """Return the layer at a wall that lacks spheres, in radii, for a solid fraction away from the walls."""
    return (1.0 - fraction) / (1.0 + 2.0 * fraction)


@dataclass(frozen=True, eq=False, slots=True)
class Room:
    """The space that a zone has for new spheres.

    Attributes:
        region: The zone.
        fixed_center: Centres of the spheres that are there [m], shape (F, 3).
        fixed_half: Half of the least distance between the centres of two of them [m], shape (F,).
    """

    region: Region
    fixed_center: Float64Array
    fixed_half: Float64Array

    def volume(self, clearance: float) -> float:
        """Return the volume of the points that are so far from all walls, and in no sphere [m3]."""
        low, high = self.region.bounds
        points = low + np.random.default_rng(0).random((SAMPLES, 3)) * (high - low)
        return float(np.prod(high - low)) * float(self.open(points, clearance).mean())

    def open(self, points: Float64Array, clearance: float) -> BoolArray:
        """Tell which points, (n, 3), are so far from all walls [m], and in no sphere that is there, (n,)."""
        free = self.region.clearance(points, clearance) >= 0.0
        free[free] = ~covered(self, points[free])
        return free

    def fraction(self, half: Float64Array, wall: Float64Array) -> float:
        """Return the solid fraction away from the walls that spheres as large as their distances will have.

        Args:
            half: See ``Crowd``, shape (M,), at least one.
            wall: See ``Crowd``, shape (M,).
        """
        solid, mean = float((UNIT_VOLUME * cube(half)).sum()), _mean(half)
        beyond, fraction = float(wall.max() - half.max()), 0.5
        for _ in range(ROUNDS):
            room = self.volume(beyond + mean * missing_layer(fraction))
            fraction = min(solid / room, 0.74) if room > 0.0 else 0.74
        return fraction

    def solid(self, fraction: float, half: Float64Array, wall: Float64Array) -> float:
        """Return the volume of spheres as large as their distances at a fraction away from the walls [m3]."""
        return fraction * self.volume(float(wall.max() - half.max()) + _mean(half) * missing_layer(fraction))


def _mean(half: Float64Array) -> float:
    """Return the mean, each sphere counted by its volume."""
    volume = cube(half)
    return float((half * volume).sum() / volume.sum())


def covered(room: Room, points: Float64Array) -> BoolArray:
    """Tell which points, (n, 3), are in one of the spheres that are there, (n,)."""
    return within(points, room.fixed_center, room.fixed_half, room.region)


def within(points: Float64Array, center: Float64Array, reach: Float64Array, region: Region) -> BoolArray:
    """Tell which points, (n, 3), are closer to one of some centres, (S, 3), than its reach, (S,) [m]."""
    inside = np.zeros(len(points), bool)
    if len(points) and len(center):
        seams = region.walls.seams
        grid = point_grid(seams.wrapped(points), seams.low, seams.period)
        close_points(seams.wrapped(center), np.ascontiguousarray(reach), grid, inside)
    return inside
