"""The columns that a unit works in: the altitudes of its surface, and which of them are near its seams."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter

from packgen.arrange.collective.tiles.layout import Span, TileLayout, Unit
from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.portable import components


class Window:
    """The columns of a unit's tile and halo, as a part of all columns.

    Attributes:
        shape: Number of columns along u and v.
        own: Which columns are those of the tile, shape (columns,).
    """

    def __init__(self, layout: TileLayout, unit: Unit) -> None:
        self._columns, self._spans = layout.columns, layout.window(unit)
        self._low = np.array([span.begin for span in self._spans])
        u, v = ((span.end - span.begin) for span in self._spans)
        self.shape = (u, v)
        self.own = self.near(layout.tile(unit), 0)

    @property
    def count(self) -> int:
        """Number of columns."""
        return self.shape[0] * self.shape[1]

    def index(self, position: Float64Array) -> Int64Array:
        """Return the column of each point, the nearest one for points beside the window, flat, (N,)."""
        place = np.column_stack(np.divmod(self._columns.index(position), self._columns.shape[1]))
        place = np.clip(place - self._low, 0, np.array(self.shape) - 1)
        return np.asarray(place[:, 0] * self.shape[1] + place[:, 1])

    def tops(self, position: Float64Array, radius: Float64Array) -> Float64Array:
        """Return the altitude of the highest sphere of each column [m], -inf where there is none."""
        tops = np.full(self.count, -np.inf)
        np.maximum.at(tops, self.index(position), components(position, self._columns.frame[2]) + radius)
        return tops

    def highest(self, values: Float64Array, reach: float) -> Float64Array:
        """Return the highest value among the columns within reach [m] of each column, (columns,)."""
        return self._nearby(values, reach, maximum_filter)

    def lowest(self, values: Float64Array, reach: float) -> Float64Array:
        """Return the lowest value among the columns within reach [m] of each column, (columns,)."""
        return self._nearby(values, reach, minimum_filter)

    def _nearby(
        self, values: Float64Array, reach: float, chosen: Callable[..., Float64Array]
    ) -> Float64Array:
        sizes = [2 * math.ceil(reach / width) + 1 for width in self._columns.width]
        return chosen(values.reshape(self.shape), size=sizes, mode="nearest").ravel()

    def points(self, altitude: Float64Array) -> Float64Array:
        """Return the middle of each column at its own altitude [m], shape (columns, 3)."""
        u, v = np.divmod(np.arange(self.count), self.shape[1])
        across = self._columns.corner + self._columns.width * (np.column_stack([u, v]) + self._low + 0.5)
        return components(np.column_stack([across, altitude]), self._columns.frame.T)

    def near(self, spans: Sequence[Span], distance: int) -> BoolArray:
        """Tell which columns are less than so many columns away from others, shape (columns,).

        Args:
            spans: The others, along u and v.
            distance: Number of columns; 0: the others themselves.
        """
        inside = []
        for (begin, end), low, count in zip(spans, self._low.tolist(), self.shape, strict=True):
            place = np.arange(count) + low
            inside.append((place >= begin - distance) & (place < end + distance))
        return np.asarray(inside[0][:, None] & inside[1]).ravel()
