"""Mixtures of sizes: an order in which they are mixed at every moment."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.portable import AT_ONCE, octaves


def mixed_order(radius: Float64Array, set_index: Int32Array, rng: np.random.Generator) -> Int64Array:
    """Return an order in which the sizes of each set are evenly spread.

    Spheres of a set whose radii are within a factor of two count as alike: in any part of the order there are
    as many of them as in any other, to one. A plain shuffle leaves the few large spheres of a broad law to
    chance: where a layer has room for twenty of them, it would get sixteen or twenty-five.

    Args:
        radius: Radii [m], shape (N,).
        set_index: Particle set of each sphere, shape (N,).
        rng: Source of randomness.

    Returns:
        A permutation, shape (N,), int64.
    """
    order: Int64Array = rng.permutation(len(radius))
    if len(radius) == 0:
        return order
    kind = _kinds(radius, set_index)
    count = np.bincount(kind)
    count = count[count > 0]
    if len(count) == 1:
        return order
    by_kind = order[np.argsort(kind[order], kind="stable")]
    rank = np.arange(len(radius)) - np.repeat(np.cumsum(count) - count, count)
    place = (rank + rng.random(len(radius))) / np.repeat(count, count)
    mixed: Int64Array = by_kind[np.argsort(place, kind="stable")]
    return mixed


def _kinds(radius: Float64Array, set_index: Int32Array) -> Int32Array:
    """Return a number for each sphere, the same for spheres that are alike, shape (N,), int32."""
    largest, smallest = radius.max(), radius.min()
    width = int(octaves(np.array([largest / smallest]))[0]) + 1
    kind = np.empty(len(radius), np.int32)
    for start in range(0, len(radius), AT_ONCE):
        some = slice(start, start + AT_ONCE)
        kind[some] = set_index[some] * width + octaves(largest / radius[some])
    return kind
