"""Which pairs of spheres a layer lists, and how two that overlap share the way that parts them."""

from __future__ import annotations

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int32Array, Int64Array
from packgen.bodies import in_two_bodies


def push_lightness(radius: Float64Array, moving: int, reference: float) -> Float64Array:
    """Return the weight w of each sphere in a push: sphere i of a pair takes w_i / (w_i + w_j) of it.

    The weight of a moving sphere is one over its mass. A fixed sphere does not move, but a smaller one has a
    weight, too: a large sphere on a bed of small fixed ones has many contacts at once. If it took each push
    in full, their sum would throw it off its place again and again, until it counts as a sphere without a
    place. The largest sphere takes the ratio of the radii from a fixed one, all of the push from one of its
    own size.

    Args:
        radius: Radii [m], shape (N,), float64.
        moving: The first ``moving`` spheres move.
        reference: Any radius [m], to keep the numbers near one.

    Returns:
        Weights relative to a sphere of the reference radius, shape (N,), float64; 0 for a fixed sphere as
        large as the largest.
    """
    ratio = reference / radius
    lightness = ratio * ratio * ratio
    if moving < len(radius):
        largest = float(radius.max())
        least = reference / largest
        lightness[moving:] = least * least * least * (largest / radius[moving:] - 1.0)
    return lightness


def list_reach(radius: Float64Array, moving: int, skin: float, reference: float) -> Float64Array:
    """Return the reach of each sphere: its radius plus the distance it may move while the list holds [m].

    The margin is half the skin of the geometric mean of both radii. All spheres of a layer move by similar
    distances. Margins proportional to the radius would be too small for small spheres and needlessly large
    for large ones. The geometric mean lies between.

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
