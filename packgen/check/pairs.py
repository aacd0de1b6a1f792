"""Every pair of close spheres, in pieces that fit in memory: scipy's k-d trees, no code of the core's.

Spheres are sorted into levels, one an octave of radius, so that a small sphere never searches as far as a
large one; each pair of levels is walked in slabs along the bed's longest side.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array, Int32Array, Int64Array

SLAB_SIZE = 250_000  # spheres searched at a time: about 25 MB of pairs


@dataclass(frozen=True, eq=False, slots=True)
class Pairs:
    """Some close pairs; each pair of the bed is in exactly one piece, each image across a seam once.

    Attributes:
        first: Index of one sphere, shape (P,), int64.
        second: Index of the other one, shape (P,), int64.
        gap: Distance of the two surfaces [m], negative where they overlap, shape (P,), float64.
    """

    first: Int64Array
    second: Int64Array
    gap: Float64Array


@dataclass(frozen=True, eq=False, slots=True)
class _Level:
    """Spheres of one octave of radius, sorted along ``axis``; ``owner`` is their index in the bed."""

    position: Float64Array
    radius: Float64Array
    owner: Int64Array
    ghost: np.ndarray
    along: Float64Array
    radius_max: float


def near_pairs(
    position: Float64Array,
    radius: Float64Array,
    *,
    gap_fraction: float = 0.0,
    period: tuple[float | None, float | None, float | None] = (None, None, None),
    body_index: Int32Array | None = None,
) -> Iterator[Pairs]:
    """Yield all pairs of spheres whose gap is at most a fraction of the smaller one's radius.

    Args:
        position: Sphere centres [m], shape (N, 3), float64.
        radius: Sphere radii [m], shape (N,), float64.
        gap_fraction: Largest gap, as a fraction of the smaller radius; 0 yields pairs that touch or overlap.
        period: Length after which the bed repeats along each axis [m]; None where it does not.
        body_index: Body of each sphere, shape (N,): two spheres of one body are no pair, a sphere and its own
            image are one. None: each sphere is a body.

    Yields:
        Pieces of the list of pairs, in an order that depends on nothing but the input.
    """
    if len(radius) == 0:
        return
    reach = 1.0 + 0.5 * gap_fraction  # gap <= fraction * min(r) implies distance <= reach * (r_i + r_j)
    levels = _levels(*_with_images(position, radius, period, 2.0 * reach * float(radius.max())))
    for place, large in enumerate(levels):
        for small in levels[: place + 1]:
            for first, second in _close(large, small, reach):
                found = _measured(large, small, first, second, gap_fraction)
                if body_index is not None:
                    found = _between_bodies(found, body_index)
                if len(found.gap):
                    yield found


def _with_images(
    position: Float64Array, radius: Float64Array, period: tuple[float | None, ...], cutoff: float
) -> tuple[Float64Array, Float64Array, Int64Array, np.ndarray]:
    """Return spheres and their images beyond the seams: position, radius, owner, and whether it is an image.

    A pair across a seam has two images. Only the one in the positive direction is made.
    """
    periods = np.array([length or 0.0 for length in period])
    wraps = periods > 0.0
    wrapped = position.copy()
    wrapped[:, wraps] = np.mod(position[:, wraps], periods[wraps])
    owner = np.arange(len(radius))
    pieces = [(wrapped, owner)]
    for shift in product(*[(-1, 0, 1) if wrap else (0,) for wrap in wraps]):
        if shift > (0, 0, 0):
            image = wrapped + np.array(shift) * periods
            inside = (image >= -cutoff) & (image <= periods + cutoff)
            near = (inside | ~wraps).all(axis=1)
            pieces.append((image[near], owner[near]))
    owners = np.concatenate([piece[1] for piece in pieces])
    ghost = np.arange(len(owners)) >= len(radius)
    return np.concatenate([piece[0] for piece in pieces]), radius[owners], owners, ghost


def _levels(
    position: Float64Array, radius: Float64Array, owner: Int64Array, ghost: np.ndarray
) -> list[_Level]:
    """Return the spheres by octave of radius, small ones first, each level sorted along the longest side."""
    axis = int(np.argmax(np.ptp(position, axis=0)))
    order = np.argsort(position[:, axis], kind="stable")
    octave = np.floor(np.log2(radius / radius.min()) + 1e-9).astype(np.int64)[order]
    levels = []
    for value in np.unique(octave):
        chosen = order[octave == value]
        levels.append(
            _Level(
                position=position[chosen],
                radius=radius[chosen],
                owner=owner[chosen],
                ghost=ghost[chosen],
                along=position[chosen, axis],
                radius_max=float(radius[chosen].max()),
            )
        )
    return levels


def _close(large: _Level, small: _Level, reach: float) -> Iterator[tuple[Int64Array, Int64Array]]:
    """Yield indices into two levels (or one and the same) of pairs within the levels' common cut-off."""
    # The margin keeps pairs that rounding would put just beyond the cut-off.
    cutoff = reach * (large.radius_max + small.radius_max) * (1.0 + 1e-9)
    share = len(large.radius) / max(len(large.radius), len(small.radius))
    step = max(1, int(SLAB_SIZE * share))
    for start in range(0, len(large.radius), step):
        stop = min(start + step, len(large.radius))
        if large is small:
            end = int(np.searchsorted(large.along, large.along[stop - 1] + cutoff, side="right"))
            tree = cKDTree(large.position[start:end], balanced_tree=False, compact_nodes=False)
            pairs = tree.query_pairs(cutoff, output_type="ndarray") + start
            pairs = pairs[pairs.min(axis=1) < stop] if end > stop else pairs
            yield pairs[:, 0], pairs[:, 1]
        else:
            low = int(np.searchsorted(small.along, large.along[start] - cutoff, side="left"))
            high = int(np.searchsorted(small.along, large.along[stop - 1] + cutoff, side="right"))
            if low < high:
                tree = cKDTree(large.position[start:stop], balanced_tree=False, compact_nodes=False)
                other = cKDTree(small.position[low:high], balanced_tree=False, compact_nodes=False)
                found = tree.sparse_distance_matrix(other, cutoff, output_type="ndarray")
                yield found["i"].astype(np.int64) + start, found["j"].astype(np.int64) + low


def _measured(
    large: _Level, small: _Level, first: Int64Array, second: Int64Array, gap_fraction: float
) -> Pairs:
    """Return those of the candidate pairs that are close enough, by their indices in the bed."""
    difference = large.position[first] - small.position[second]
    distance = np.sqrt(np.einsum("ij,ij->i", difference, difference))
    radius_first, radius_second = large.radius[first], small.radius[second]
    # The same to the last digit from either end: which is the first depends on what else is in the bed.
    gap = distance - (radius_first + radius_second)
    close = gap <= gap_fraction * np.minimum(radius_first, radius_second)
    close &= ~(large.ghost[first] & small.ghost[second])
    return Pairs(large.owner[first[close]], small.owner[second[close]], gap[close])


def _between_bodies(pairs: Pairs, body_index: Int32Array) -> Pairs:
    """Return the pairs whose spheres are of two bodies, or are one sphere and its image."""
    apart = (body_index[pairs.first] != body_index[pairs.second]) | (pairs.first == pairs.second)
    return Pairs(pairs.first[apart], pairs.second[apart], pairs.gap[apart])
