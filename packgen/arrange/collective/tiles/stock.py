"""The spheres that a tile has to place: those dealt to it, and those that found no place before."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int32Array
from packgen.supply.supply import Draw


@dataclass(eq=False, slots=True)
class Stock:
    """The spheres still to come in a tile.

    Attributes:
        radius: Radii of all spheres dealt to it [m], shape (N,); may be a file that is read where it is used.
        set_index: Their particle sets, shape (N,).
        cursor: How many of these have been handed out.
        carried: Those that came back; they go first.
    """

    radius: Float64Array
    set_index: Int32Array
    cursor: int
    carried: Draw

    def take(self, count: int) -> Draw:
        """Return the next spheres, ``count`` or all that are left."""
        first, self.carried = self.carried.split(count)
        end = min(self.cursor + count - len(first.radius), len(self.radius))
        radius, set_index = self.radius[self.cursor : end], self.set_index[self.cursor : end]
        self.cursor = end
        return Draw(np.append(first.radius, radius), np.append(first.set_index, set_index))

    def put_back(self, radius: Float64Array, set_index: Int32Array) -> None:
        """Take back spheres that found no place."""
        own = self.carried
        self.carried = Draw(np.append(radius, own.radius), np.append(set_index, own.set_index))


def no_draw() -> Draw:
    """Return no spheres."""
    return Draw(np.empty(0), np.empty(0, np.int32))
