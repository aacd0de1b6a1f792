"""A part of a bed together with what is around it: what is counted of all parts is counted of the bed.

A sphere counts where it is the part's own. A pair counts in the part to which the sphere of the lower number
belongs, and in no other.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import BoolArray, Int64Array
from packgen.bed import Bed


@dataclass(frozen=True, eq=False, slots=True)
class Part:
    """Spheres of a part, and those around it.

    Attributes:
        bed: The part's own spheres first, then those around it.
        own: Number of its own spheres.
        number: Number of each sphere in the whole bed, shape (N,), int64; those of its own are consecutive.
    """

    bed: Bed
    own: int
    number: Int64Array

    @classmethod
    def whole(cls, bed: Bed) -> Part:
        """Return a bed as the only part of itself."""
        return cls(bed, bed.count, np.arange(bed.count))

    @property
    def is_whole(self) -> bool:
        """Whether nothing is around it."""
        return self.own == self.bed.count

    def counted(self, first: Int64Array, second: Int64Array) -> BoolArray:
        """Return which pairs of spheres of the part, (P,) each, count here; shape (P,)."""
        of_lower = np.where(self.number[first] < self.number[second], first, second)
        counted: BoolArray = of_lower < self.own
        return counted
