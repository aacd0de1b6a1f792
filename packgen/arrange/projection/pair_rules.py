"""Which pairs a layer lists, how two spheres share the way that parts them, and what both forms share."""

from __future__ import annotations

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int32Array, Int64Array
from packgen.bodies import in_two_bodies

PARTING_X, PARTING_Y = 0.7548776662466927, 0.5698402909980532
"""Steps of an even sequence in the plane, by which coincident spheres part: powers of the plastic number, the
root of x^3 = x + 1."""

GRAIN_STEP = 0.6180339887498949
"""Step from one sphere to the next of the part of a wall's roughness that keeps it off, modulo 1: the golden
ratio's even sequence."""

GRAIN_PUSH = 0.1
"""Largest push by rough walls in a sweep, all features together, in radii: gentle, for a sphere between two
walls must not pass one."""


def push_weights(radius: Float64Array, moving: int, reference: float) -> Float64Array:
    """Return the weight w of each sphere in a push: of a pair, sphere i takes w_i / (w_i + w_j) of it.

    The weight of a moving sphere is one over its mass. A fixed sphere does not move, but a smaller one has a
    weight, too: a large sphere on a bed of small fixed ones has many contacts at once. If it took each push
    in full, their sum would throw it off its place again and again, until it counts as a sphere without a
    place. The largest spheres take the ratio of the radii from a fixed one, and all of the push from one of
    their own size.

    Args:
        radius: Radii [m], shape (N,), float64.
        moving: The first ``moving`` spheres move.
        reference: Any radius [m], to keep the numbers near one.

    Returns:
        Weights, shape (N,), float64; 0 for a fixed sphere as large as the largest.
    """
    ratio = reference / radius
    weight = ratio * ratio * ratio
    if moving < len(radius):
        largest = float(radius.max())
        least = reference / largest
        weight[moving:] = least * least * least * (largest / radius[moving:] - 1.0)
    return weight


def list_reach(radius: Float64Array, moving: int, skin: float, reference: float) -> Float64Array:
    """Return the reach of each sphere: its radius plus the distance it may move while the list holds [m].

    The margin is half the skin times sqrt(mean radius * radius). All spheres of a layer move by similar
    distances. Margins proportional to the radius would be too small for small spheres and needlessly large
    for large ones; the square root is between.

    Args:
        radius: Radii [m], shape (N,), float64.
        moving: The first ``moving`` spheres move; a fixed one reaches as far as its surface.
        skin: Twice the margin of a sphere of the reference radius, in units of it.
        reference: Mean radius of the moving spheres [m].

    Returns:
        Reaches [m], shape (N,), float64.
    """
    reach = radius.copy()
    reach[:moving] += 0.5 * skin * np.sqrt(reference * radius[:moving])
    return reach


def pairs_to_part(
    first: Int32Array | Int64Array,
    second: Int32Array | Int64Array,
    body_index: Int32Array,
    identity: Int64Array,
    count: int,
) -> BoolArray:
    """Return which pairs of a layer may not overlap: those of two bodies.

    Args:
        first: One sphere of each pair in the layer's own order, shape (P,).
        second: The other one, shape (P,).
        body_index: Body of each moving sphere in the order given.
        identity: Place of each moving sphere in the order given, shape (moving,).
        count: How many spheres the layer has; fixed ones come last, and are of no body that moves.

    Returns:
        Which pairs, shape (P,), bool.
    """
    body = np.full(count, np.iinfo(np.int64).min)
    body[: len(identity)] = body_index[identity]
    return in_two_bodies(first, second, body)
