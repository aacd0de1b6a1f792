"""Where a periodic box wraps around: the nearest image of a sphere, and the pairs that meet across a seam.

Spheres meet their neighbours beyond a seam as images: copies shifted by whole periods. The list of such pairs
is made beside the neighbour list and is as short as the seams are small, so that the loops over all other
pairs know nothing of periods.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array
from packgen.compiled import inlined, loop
from packgen.geometry import Container


@inlined
def wrapped_coordinate(along: float, low: float, period: float) -> float:
    """Return a coordinate [m] moved by whole periods to ``low`` or above, below ``low + period``.

    What is inside keeps every digit, what is NaN stays, and where there is no period (0) all does.
    """
    if period > 0.0 and (along < low or along >= low + period):
        along = low + (along - low) % period
        if along >= low + period:
            along = low
    return along


@loop
def wrap_points(position: NDArray[np.float64], low: NDArray[np.float64], period: NDArray[np.float64]) -> None:
    """Move points by whole periods into the box, the upper sides left out; see ``wrapped_coordinate``.

    Args:
        position: Points [m], shape (N, 3) or wider; change.
        low: Lower corner of the box [m], shape (3,).
        period: Length after which space repeats [m], 0 where it does not, shape (3,).
    """
    for i in range(len(position)):
        for axis in range(3):
            position[i, axis] = wrapped_coordinate(position[i, axis], low[axis], period[axis])


@inlined
def is_periodic(period: NDArray[np.float64]) -> bool:
    """Tell whether space repeats after a length [m] along any axis, shape (3,)."""
    return bool(period[0] > 0.0 or period[1] > 0.0 or period[2] > 0.0)


class Seams(NamedTuple):
    """The periods of a box.

    Attributes:
        low: Lower corner of the box [m], shape (3,).
        period: Length after which it repeats along x, y, z [m], 0 where it does not, shape (3,).
    """

    low: Float64Array
    period: Float64Array

    @classmethod
    def of(cls, container: Container) -> Seams:
        """Return the seams of a container."""
        low, high = container.bounds
        period = np.where(container.periodic, high - low, 0.0)
        # Rounding must not let a centre lie on the upper side, or beyond it.
        return cls(np.array(low), np.where(low + period > high, np.nextafter(period, 0.0), period))

    @property
    def wraps(self) -> bool:
        """Whether any axis is periodic."""
        return is_periodic(self.period)

    def wrapped(self, position: Float64Array) -> Float64Array:
        """Return points (N, 3) moved by whole periods into the box, the upper sides left out."""
        inside = np.array(position, np.float64, order="C")
        wrap_points(inside, self.low, self.period)
        return inside

    def tree(self, position: Float64Array) -> cKDTree:
        """Return a k-d tree that measures distances across the seams; ask it for `placed` points."""
        return cKDTree(self.placed(position), boxsize=self.period if self.wraps else None)

    def placed(self, position: Float64Array) -> Float64Array:
        """Return points (N, 3) as `tree` has them: from the lower corner, so that periods begin at 0."""
        if not self.wraps:
            return position
        placed: Float64Array = self.wrapped(position) - self.low
        # Just below the upper side the difference may round to the period itself, which the tree refuses.
        return np.where((self.period > 0.0) & (placed >= self.period), 0.0, placed)


NO_SEAMS = Seams(np.zeros(3), np.zeros(3))
"""Of everything that does not wrap around."""
