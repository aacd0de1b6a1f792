"""Spheres at rest and all that they can meet: gaps, the largest radii that fit, what bounds a move."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrange.jammed.meeting_kernels import near_pairs, near_walls, wall_distances
from packgen.arrange.space.walls import WallTable
from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.compiled import signals_heard
from packgen.programmes.steps import PairRows, WallRows

SAME = 1.0e-12
"""Difference of directions, and of distances in radii, at which two facets are one wall to a sphere."""


@dataclass(frozen=True, eq=False, slots=True)
class Meetings:
    """Pairs and walls near each other; all lengths of one row are of one place of the spheres.

    Attributes:
        first: One sphere of each pair, shape (P,).
        second: The other one, shape (P,).
        shift: What has to be added to the way from the second centre to the first [m], shape (P, 3).
        sphere: Sphere near each wall, shape (W,).
        feature: That wall, shape (W,).
        radius: Radii of all spheres as given [m], shape (N,).
        walls: The walls.
    """

    first: Int64Array
    second: Int64Array
    shift: Float64Array
    sphere: Int64Array
    feature: Int64Array
    radius: Float64Array
    walls: WallTable

    @classmethod
    def around(
        cls, center: Float64Array, radius: Float64Array, factor: float, walls: WallTable, within: float
    ) -> Meetings:
        """Return what spheres can meet.

        Args:
            center: Centres, in the periodic box or periods away [m], shape (N, 3).
            radius: Radii as given [m], shape (N,).
            factor: Common factor of them.
            walls: The walls.
            within: Distance of surfaces up to which they are near [m].
        """
        inside = walls.seams.wrapped(center)
        with signals_heard():
            first, second, separation = near_pairs(inside, factor * radius, walls, within)
            sphere, feature = near_walls(inside, factor * radius, walls, within)
        shift = separation - (center[first] - center[second])
        return cls(first, second, shift, sphere, feature, radius, walls)

    @property
    def apart(self) -> Float64Array:
        """Sums of radii as given [m], shape (P,)."""
        return np.asarray(self.radius[self.first] + self.radius[self.second])

    @property
    def kept(self) -> Float64Array:
        """Radii as given that keep spheres from their walls [m], shape (W,)."""
        return np.asarray(self.radius[self.sphere])

    def separations(self, center: Float64Array) -> Float64Array:
        """Return the ways from second to first centres [m], shape (P, 3)."""
        return np.asarray(center[self.first] - center[self.second] + self.shift)

    def distances(self, center: Float64Array) -> tuple[Float64Array, Float64Array]:
        """Return distances from walls [m], (W,), and the unit vectors away from them, (W, 3)."""
        distance, away = wall_distances(center, self.sphere, self.feature, self.walls)
        return distance, away

    def largest_factor(self, center: Float64Array) -> float:
        """Return the largest common factor of the radii at which nothing overlaps."""
        separation = self.separations(center)
        found = np.sqrt((separation * separation).sum(axis=1)) / self.apart
        distance, _ = self.distances(center)
        by_walls = distance / self.kept
        return float(min(found.min(initial=np.inf), by_walls.min(initial=np.inf)))

    def gaps(self, center: Float64Array, factor: float) -> tuple[Float64Array, Float64Array]:
        """Return gaps of pairs, (P,), and of walls, (W,), as fractions of the smaller radius."""
        separation = self.separations(center)
        apart = np.sqrt((separation * separation).sum(axis=1)) - factor * self.apart
        smaller = factor * np.minimum(self.radius[self.first], self.radius[self.second])
        distance, _ = self.distances(center)
        return apart / smaller, distance / (factor * self.kept) - 1.0

    def chosen(self, pairs: BoolArray, walls: BoolArray) -> Meetings:
        """Return some of them."""
        return Meetings(
            self.first[pairs], self.second[pairs], self.shift[pairs], self.sphere[walls], self.feature[walls],
            self.radius, self.walls,
        )  # fmt: skip

    def one_a_wall(self, center: Float64Array) -> Meetings:
        """Return them without facets that are one wall to a sphere with another: neighbours in one plane."""
        distance, away = self.distances(center)
        same = np.zeros(len(self.sphere), bool)
        for back in range(1, int(np.bincount(self.sphere).max(initial=0))):
            here, there = slice(back, None), slice(None, -back)
            alike = self.sphere[here] == self.sphere[there]
            alike &= np.abs(away[here] - away[there]).max(axis=1, initial=0.0) <= SAME
            alike &= np.abs(distance[here] - distance[there]) <= SAME * self.radius[self.sphere[here]]
            same[here] |= alike
        return self.chosen(np.ones(len(self.first), bool), ~same)

    def rows(self, center: Float64Array, factor: float) -> tuple[PairRows, WallRows]:
        """Return them as rows of a linear programme."""
        distance, away = self.distances(center)
        kept = factor * self.kept
        return (
            PairRows(self.first, self.second, self.separations(center), factor * self.apart),
            WallRows(self.sphere, distance - kept, away, kept),
        )
