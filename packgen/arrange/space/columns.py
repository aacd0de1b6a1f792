"""Columns along gravity over a region: the tops of a bed, and where points lie."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.space.column_kernels import column_index
from packgen.arrays import Float64Array
from packgen.portable import components

if TYPE_CHECKING:
    from packgen.arrange.space.region import Region

COLUMNS_MAX = 4_000_000


@dataclass(frozen=True, eq=False, slots=True)
class ColumnMap:
    """A grid of columns along gravity over a region's shadow.

    Attributes:
        frame: The region's frame, shape (3, 3).
        width: Column width along u and v [m], shape (2,); it divides a period.
        shape: Number of columns along u and v.
        corner: Lower corner of the grid in u and v [m], shape (2,).
        wraps: Whether the region wraps around along u and v.
    """

    frame: Float64Array
    width: Float64Array
    shape: tuple[int, int]
    corner: Float64Array
    wraps: tuple[bool, bool]

    @classmethod
    def over(cls, region: Region, width: float) -> ColumnMap:
        """Return columns of about this width [m] over a region; wider ones where they would be too many."""
        least, most = region.rectangle()
        width = max(width, float(np.sqrt(np.prod(most - least) / COLUMNS_MAX)))
        columns = np.maximum(np.ceil((most - least) / width), 1.0)
        # Down is across every periodic axis: each is one of the frame's own.
        wraps = (np.abs(region.frame[:2]) * (region.walls.seams.period > 0.0)).sum(axis=1) > 0.5
        # A narrow column at the seam would have fewer spheres, and a lower top, than all others.
        widths = np.where(wraps, (most - least) / columns, width)
        u, v = wraps.tolist()
        return cls(region.frame, widths, (int(columns[0]), int(columns[1])), least, (u, v))

    @property
    def count(self) -> int:
        """Number of columns."""
        return self.shape[0] * self.shape[1]

    def index(self, position: Float64Array) -> NDArray[np.int64]:
        """Return the column that each point lies in, flat, shape (N,)."""
        shape = np.array(self.shape, np.int64)
        # One kind of array: the compiled loop is made for it alone.
        across, position = np.array(self.frame[:2]), np.ascontiguousarray(position, np.float64)
        found: NDArray[np.int64] = column_index(
            position, across, np.array(self.corner), np.array(self.width), shape
        )
        return found

    def covers(self, position: Float64Array) -> NDArray[np.bool_]:
        """Tell which points lie in some column, shape (N,)."""
        place = (components(position, self.frame[:2]) - self.corner) / self.width
        inside = (place >= 0.0) & (place < np.array(self.shape))
        return np.asarray((inside | np.array(self.wraps)).all(axis=1))

    def tops(self, position: Float64Array, radius: Float64Array) -> Float64Array:
        """Return the altitude of the highest sphere of each column [m], -inf where there is none."""
        tops = np.full(self.count, -np.inf)
        np.maximum.at(tops, self.index(position), components(position, self.frame[2]) + radius)
        return tops

    def nearby(self, tops: Float64Array, reach: float, chosen: Callable[..., Float64Array]) -> Float64Array:
        """Return the lowest or highest top [m] among the columns within reach [m] of each column.

        Args:
            tops: Altitude of each column, shape (columns,).
            reach: How far to look across gravity.
            chosen: ``scipy.ndimage.minimum_filter`` or ``maximum_filter``.
        """
        sizes = [2 * math.ceil(reach / width) + 1 for width in self.width]
        modes = ["wrap" if wraps else "nearest" for wraps in self.wraps]
        return chosen(tops.reshape(self.shape), size=sizes, mode=modes).ravel()

    def points(self, altitude: Float64Array) -> Float64Array:
        """Return the middle of each column at its own altitude [m], shape (columns, 3)."""
        u, v = np.divmod(np.arange(self.count), self.shape[1])
        across = self.corner + self.width * (np.column_stack([u, v]) + 0.5)
        return components(np.column_stack([across, altitude]), self.frame.T)
