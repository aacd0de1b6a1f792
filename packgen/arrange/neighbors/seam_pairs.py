"""Pairs of spheres that are close across a seam."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from packgen.arrange.neighbors.listing import list_pairs
from packgen.arrange.space.seams import Seams
from packgen.arrays import Float64Array, Int32Array, Int64Array


class SeamPairs(NamedTuple):
    """Pairs of spheres that are close across a seam, each once.

    Attributes:
        first: One sphere, shape (P,), int32.
        second: The other one, shape (P,), int32.
        offset: What takes the second one to its image near the first [m], shape (P, 3), float64.
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
    order, _, (owner, neighbor) = list_pairs(ball, reach, split, np.empty(24 * len(ball) + 4096, np.int32))
    other = neighbor[: len(owner)]
    across = (owner < split) != (other < split)
    low, high = np.minimum(owner, other)[across], np.maximum(owner, other)[across]
    return order[low], order[high] - split
