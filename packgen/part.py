"""A part of a bed together with what is around it: what is counted of all parts is counted of the bed.

A sphere counts where it is the part's own. A pair counts in the part to which the sphere of the lower number
belongs, and in no other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.bed import Bed
from packgen.geometry.cells import cell_images, into_cell

CELL_REACH = 5.5
"""Distance from a cell within which its images are made, in largest radii: see `OrderCounter.REACH`."""


@dataclass(frozen=True, eq=False, slots=True)
class Part:
    """Spheres of a part, and those around it.

    Attributes:
        bed: The part's own spheres first, then those around it.
        own: Number of its own spheres.
        number: Number of each sphere in the whole bed, shape (N,), int64; those of its own are consecutive.
            Images in a cell of any shape have numbers beyond these.
        owner: The sphere that each is, or is an image of, shape (N,), int64; None: ``number``.
    """

    bed: Bed
    own: int
    number: Int64Array
    owner: Int64Array | None = None

    @classmethod
    def whole(cls, bed: Bed) -> Part:
        """Return a bed as the only part of itself, in a cell of any shape with the images around it."""
        if bed.container.cell is not None:
            return cls._in_cell(bed, bed.container.cell)
        return cls(bed, bed.count, np.arange(bed.count))

    @classmethod
    def _in_cell(cls, bed: Bed, vectors: Float64Array) -> Part:
        """Return the spheres of a cell, and all images that may be neighbours of their neighbours."""
        sound = np.isfinite(bed.position).all(axis=1) & np.isfinite(bed.radius)
        reach = CELL_REACH * float(bed.radius[sound].max(initial=0.0))
        index = np.flatnonzero(sound)
        position = bed.position.copy()
        position[index] = into_cell(position[index], vectors)
        center, owner, steps = cell_images(position[index], vectors, reach)
        owner = np.concatenate([np.arange(bed.count), index[owner]])
        # Of two pairs that mirror each other the one counts whose image is beyond: it has the higher number.
        x, y, z = steps.T
        beyond = (x > 0) | ((x == 0) & ((y > 0) | ((y == 0) & (z > 0))))
        number = owner.copy()
        number[bed.count :] += np.where(beyond, bed.count, -bed.count)
        around = replace(
            bed,
            position=np.concatenate([position, center]),
            radius=bed.radius[owner],
            set_index=bed.set_index[owner],
            zone_index=bed.zone_index[owner],
            batch_index=bed.batch_index[owner],
            body_index=None,
            bodies=None,
        )
        return cls(around, bed.count, number, owner)

    @property
    def is_whole(self) -> bool:
        """Whether nothing is around it."""
        return self.own == self.bed.count

    def counted(self, first: Int64Array, second: Int64Array) -> BoolArray:
        """Return which pairs of spheres of the part, (P,) each, count here; shape (P,)."""
        of_lower = np.where(self.number[first] < self.number[second], first, second)
        counted: BoolArray = of_lower < self.own
        return counted

    @property
    def name(self) -> Int64Array:
        """Number of each sphere in the whole bed, an image's that of its sphere, shape (N,)."""
        return self.number if self.owner is None else self.owner
