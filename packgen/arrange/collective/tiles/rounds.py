"""How many layers all tiles can fill with the spheres that are left, and how many each tile gets for them.

A tile that ran out of spheres would leave a pit beside its neighbours. So a round has no more layers than
there are spheres for, and some to spare. What is left of it goes into the next one.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from packgen.arrange.collective.tiles.unit import TileTask
from packgen.arrays import Float64Array, Int64Array
from packgen.portable import components

ALTITUDES = 32
"""Altitudes at which the areas of the tiles are measured."""

DEALT = 1.06
"""Spheres dealt to a tile over those with which its layers would start on a finished bed: the beds are denser
than that, and a tile must not run out of spheres."""

LID = 2.0
"""Height below the ceiling that the tiles leave to the last layers, in layers: under a lid few spheres find a
place."""


class Round(NamedTuple):
    """Layers that all tiles fill.

    Attributes:
        first: The first of them.
        last: The last one.
        counts: Spheres for each tile, in the order of the tiles, shape (tiles,).
    """

    first: int
    last: int
    counts: Int64Array


class Rounds:
    """The rounds of a zone."""

    def __init__(self, task: TileTask) -> None:
        self._task = task
        region = task.region
        self._altitude = np.linspace(region.floor, region.ceiling, ALTITUDES + 1)
        self._volume = self._volumes()

    def next(self, first: int, remaining: int | None) -> Round | None:
        """Return the round that begins with some layer; None: too few spheres or too little room is left.

        Args:
            first: Number of its first layer.
            remaining: Spheres that are left; None: as many as fit.
        """
        task, last, found = self._task, first, None
        lid = task.region.ceiling - LID * task.thickness
        begun = self._needed(task.top(first - 1)) if first else 0.0
        while task.top(last) <= lid:
            counts = np.ceil(DEALT * (self._needed(task.top(last)) - begun))
            if remaining is not None and counts.sum() > remaining:
                break
            found, last = (last, counts), last + 1
        if found is None:
            return None
        return Round(first, found[0], found[1].astype(np.int64))

    def _needed(self, altitude: float) -> Float64Array:
        """Return about how many spheres each tile holds up to an altitude [m], shape (tiles,)."""
        sizes = self._task.sizes
        volume = np.array([np.interp(altitude, self._altitude, each) for each in self._volume])
        return volume * (sizes.fraction / sizes.mean_volume)

    def _volumes(self) -> Float64Array:
        """Return the volume of each tile up to each altitude [m3], shape (tiles, altitudes)."""
        region, layout = self._task.region, self._task.layout
        columns, step = layout.columns, float(self._altitude[1] - self._altitude[0])
        place = np.divmod(np.arange(columns.count), columns.shape[1])
        number = [
            np.searchsorted(edges[1:-1], each, "right")
            for edges, each in zip(layout.edges, place, strict=True)
        ]
        tile = number[0] * layout.shape[1] + number[1]
        middle = columns.points(np.zeros(columns.count))
        low, high = columns.corner, region.rectangle()[1]
        # The last columns may stick out of the region.
        across = np.column_stack(place)
        size = np.minimum(columns.width, high - (low + columns.width * across)).prod(axis=1)
        area = []
        for altitude in 0.5 * (self._altitude[1:] + self._altitude[:-1]):
            points = middle + components(np.array([[0.0, 0.0, altitude]]), region.frame.T)
            inside = region.clearance(points) >= 0.0
            area.append(np.bincount(tile, size * inside, len(layout.tiles)))
        return np.concatenate([np.zeros((len(layout.tiles), 1)), step * np.cumsum(area, axis=0).T], axis=1)
