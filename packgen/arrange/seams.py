"""Where a periodic box wraps around: the nearest image of a sphere, and the pairs that meet across a seam.

Spheres meet their neighbours beyond a seam as images: copies shifted by whole periods. The list of such pairs
is made beside the neighbour list and is as short as the seams are small, so that the loops over all other
pairs know nothing of periods.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrange.kernels.pairs import cell_keys, fill_list, level_grids
from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.geometry import Container


@dataclass(frozen=True, eq=False, slots=True)
class Seams:
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
        return cls(np.array(low), np.where(container.periodic, high - low, 0.0))

    @property
    def wraps(self) -> bool:
        """Whether any axis is periodic."""
        return bool(self.period.any())

    def wrapped(self, position: Float64Array) -> Float64Array:
        """Return points (N, 3) moved by whole periods into the box, the upper sides left out."""
        inside = np.array(position)
        for axis in np.flatnonzero(self.period):
            along = inside[:, axis]
            # Points that are inside keep every digit.
            out = (along < self.low[axis]) | (along >= self.low[axis] + self.period[axis])
            moved = self.low[axis] + np.mod(along[out] - self.low[axis], self.period[axis])
            along[out] = np.where(moved < self.low[axis] + self.period[axis], moved, self.low[axis])
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


@dataclass(frozen=True, eq=False, slots=True)
class SeamPairs:
    """Pairs of spheres that are close across a seam, each once.

    Attributes:
        first: One sphere, shape (P,), int32.
        second: The other one, shape (P,), int32.
        offset: What takes the second one to its image near the first [m], shape (P, 3).
    """

    first: Int32Array
    second: Int32Array
    offset: Float64Array


def no_pairs() -> SeamPairs:
    """Return an empty list of pairs."""
    return SeamPairs(np.empty(0, np.int32), np.empty(0, np.int32), np.empty((0, 3)))


def images(ball: Float64Array, reach: Float64Array, seams: Seams) -> tuple[Int64Array, Float64Array]:
    """Return the images that spheres of the box can meet in one half of all directions.

    Of the two images that a pair has, one in either sphere's stead, one is enough.

    Args:
        ball: Centres in the box and radii [m], shape (N, 4).
        reach: Spheres closer than the sum of these count as close [m], shape (N,).
        seams: The periods.

    Returns:
        (sphere of each image, shape (M,); its shift [m], shape (M, 3)).
    """
    longest = (reach + reach.max(initial=0.0))[:, None]
    from_low = ball[:, :3] - seams.low
    below, above = from_low < longest, from_low > seams.period - longest
    spheres, shifts = [np.empty(0, np.int64)], [np.empty((0, 3))]
    for steps in product(*[(-1, 0, 1) if period else (0,) for period in seams.period]):
        if steps <= (0, 0, 0):
            continue
        near = np.ones(len(ball), bool)
        for axis, step in enumerate(steps):
            if step:
                near &= below[:, axis] if step > 0 else above[:, axis]
        chosen = np.flatnonzero(near)
        spheres.append(chosen)
        shifts.append(np.broadcast_to(np.array(steps) * seams.period, (len(chosen), 3)))
    return np.concatenate(spheres), np.concatenate(shifts)


def seam_pairs(ball: Float64Array, reach: Float64Array, moving: int, seams: Seams) -> SeamPairs:
    """List the pairs that are close across a seam.

    Args:
        ball: Centres in the box and radii [m], shape (N, 4).
        reach: A pair is listed when closer than the sum of these [m], shape (N,).
        moving: The first so many spheres move; pairs of two others are left out.
        seams: The periods, each more than twice as long as any pair's reach.

    Returns:
        The pairs.
    """
    image, shift = images(ball, reach, seams)
    if len(image) == 0:
        return no_pairs()
    longest = (reach + reach.max())[:, None]
    from_low = ball[:, :3] - seams.low
    near = (from_low < longest) | (from_low > seams.period - longest)
    partner = np.flatnonzero((near & (seams.period > 0.0)).any(axis=1))
    copies = np.column_stack([ball[image, :3] + shift, ball[image, 3]])
    both = np.concatenate([reach[image], reach[partner]])
    one, other = _close(np.concatenate([copies, ball[partner]]), both, len(copies))
    first, second = partner[other], image[one]
    wanted = (first < moving) | (second < moving)
    return SeamPairs(
        first[wanted].astype(np.int32), second[wanted].astype(np.int32), shift[one[wanted]].copy()
    )


def _close(ball: Float64Array, reach: Float64Array, split: int) -> tuple[Int64Array, Int64Array]:
    """Return the pairs of one of the first ``split`` spheres and one of the others, counted from there."""
    box, level, reaches, size, cells, first = level_grids(ball, reach)
    _, start, order = cell_keys(ball, 0, split, box, level, size, cells, first)
    _, start_others, order_others = cell_keys(ball, split, len(ball), box, level, size, cells, first)
    order = np.concatenate([order, split + order_others]).astype(np.int64)
    owners = split if len(size) == 1 else len(ball)
    begin, neighbor = np.empty(owners + 1, np.int64), np.empty(24 * len(ball) + 4096, np.int32)
    while (
        fill_list(
            ball[order], reach[order], split, owners, box, level[order], reaches, size, cells, first,
            start, start_others, begin, neighbor,
        )
        < 0
    ):  # fmt: skip
        neighbor = np.empty(2 * len(neighbor), np.int32)
    owner, other = np.repeat(np.arange(owners), np.diff(begin)), neighbor[: begin[-1]].astype(np.int64)
    across = (owner < split) != (other < split)
    low, high = np.minimum(owner, other)[across], np.maximum(owner, other)[across]
    return order[low], order[high] - split
