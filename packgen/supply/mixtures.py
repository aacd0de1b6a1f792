"""Mixtures of sizes: an order in which they are mixed at every moment, and how densely they pack."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.portable import exp, log, octaves, power

SIZE_CLASSES = 24
"""Number of classes of radii for the solid fraction; 8 give the same to 0.002."""


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
    octave = octaves(radius.max() / radius)
    kind = set_index.astype(np.int64) * (int(octave.max()) + 1) + octave
    _, kind, count = np.unique(kind, return_inverse=True, return_counts=True)
    if len(count) == 1:
        return order
    by_kind = order[np.argsort(kind[order], kind="stable")]
    rank = np.arange(len(radius)) - np.repeat(np.cumsum(count) - count, count)
    place = (rank + rng.random(len(radius))) / np.repeat(count, count)
    mixed: Int64Array = by_kind[np.argsort(place, kind="stable")]
    return mixed


def size_classes(radius: Float64Array, volume: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return a few sizes that stand for many.

    Args:
        radius: Radii [m], shape (N,), at least one.
        volume: Volume of the spheres of each, in any unit, shape (N,).

    Returns:
        (radius of each class, the geometric mean by volume [m]; its share of the volume), shape (k,) each.
    """
    smaller = log(radius.max() / radius)
    span = max(float(smaller.max()), 1e-12)
    number = np.minimum((smaller / span * SIZE_CLASSES).astype(np.int64), SIZE_CLASSES - 1)
    total = np.bincount(number, volume, SIZE_CLASSES)
    used = total > 0.0
    mean = np.bincount(number, volume * smaller, SIZE_CLASSES)[used] / total[used]
    return radius.max() * exp(-mean), total[used] / total.sum()


def mixture_fraction(radius: Float64Array, share: Float64Array, alone: float) -> float:
    """Return the solid fraction of a random packing of several sizes.

    The linear packing model: each size in turn may be the one that carries the packing; larger spheres stand
    in it as solid lumps, smaller ones fill its voids, both the less so the nearer they are to its own size
    (Yu, Zou and Standish, Ind. Eng. Chem. Res. 35 (1996) 3730, with their interaction functions).

    Args:
        radius: Radius of each size [m], shape (k,).
        share: Its share of the volume, shape (k,).
        alone: Solid fraction of equal spheres.

    Returns:
        The solid fraction.
    """
    # Row by row: the size that carries the packing, ratios of smaller to larger radius.
    ratio = np.minimum.outer(radius, radius) / np.maximum.outer(radius, radius)
    filling = power(1.0 - ratio, 3.3) + 2.8 * ratio * power(1.0 - ratio, 2.7)
    occupying = (1.0 - ratio) ** 2 + 0.4 * ratio * power(1.0 - ratio, 3.7)
    specific = 1.0 / alone
    saved = np.where(radius[None] < radius[:, None], specific * filling, (specific - 1.0) * occupying)
    return float(1.0 / (specific - (saved * share).sum(axis=1)).max())
