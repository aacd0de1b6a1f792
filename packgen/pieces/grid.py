"""The boxes of a grid, of which each is the space of a piece: by the vessel and the spheres' size alone."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from packgen.arrays import Float64Array, Int64Array

SPHERES = 50_000
"""Spheres of a piece, about: enough that what is around it is less than itself."""

FRACTION = 0.62
"""Solid fraction by which the size of a piece is reckoned."""

LEAST = 4.0
"""Least width of a piece, in radii of the largest sphere."""


@dataclass(frozen=True, eq=False, slots=True)
class Grid:
    """Boxes that fill a larger one.

    Attributes:
        edges: Where they end along x, y and z [m], rising, one more than boxes each.
    """

    edges: tuple[Float64Array, Float64Array, Float64Array]

    @classmethod
    def over(
        cls, bounds: Float64Array, mean_volume: float, radius_max: float, spheres: int = SPHERES
    ) -> Grid:
        """Return a grid over a vessel.

        Args:
            bounds: Lower and upper corner of the vessel [m], shape (2, 3).
            mean_volume: Mean volume of a sphere [m3].
            radius_max: Radius of the largest sphere [m].
            spheres: How many spheres a box of a filled vessel has, about.
        """
        width = max((spheres * mean_volume / FRACTION) ** (1.0 / 3.0), LEAST * radius_max)
        x, y, z = (
            np.linspace(low, high, max(1, int((high - low) / width)) + 1) for low, high in bounds.T.tolist()
        )
        return cls((x, y, z))

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of boxes along x, y and z."""
        x, y, z = (len(each) - 1 for each in self.edges)
        return x, y, z

    @property
    def boxes(self) -> list[tuple[int, int, int]]:
        """The boxes by their places along x, y and z, in their order."""
        x, y, z = self.shape
        return list(product(range(x), range(y), range(z)))

    def number(self, position: Float64Array) -> Int64Array:
        """Return the number of the box of each point [m], (N, 3); the nearest one of a point outside."""
        place = [
            np.searchsorted(edges[1:-1], position[:, axis], side="right")
            for axis, edges in enumerate(self.edges)
        ]
        _, y, z = self.shape
        return np.asarray((place[0] * y + place[1]) * z + place[2], np.int64)
