"""Which pairs of spheres a layer lists, and how two that overlap share the way that parts them."""

from __future__ import annotations

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int32Array, Int64Array
from packgen.bodies import in_two_bodies


def push_lightness(radius: Float64Array, moving: int, reference: float) -> Float64Array:
    """Return the lightness of each sphere: of a push each of a pair takes the share of its own in the sum.

    Of two that move that is one over the mass. What is fixed does not move, whatever its share; but a large
    sphere on a bed of small fixed ones has many contacts at once, and if it took each push in full, all of
    them together would throw it off its place again and again, until it counts as a sphere without a place.
    Of the largest spheres each takes the ratio of the radii; of equal ones the moving one takes all.

    Args:
        radius: Radii [m], shape (N,), float64.
        moving: The first so many spheres move.
        reference: Any radius [m], to keep the numbers near one.

    Returns:
        Lightness, shape (N,), float64; 0 of a fixed sphere as large as the largest.
    """
    ratio = reference / radius
    lightness = ratio * ratio * ratio
    if moving < len(radius):
        largest = float(radius.max())
        least = reference / largest
        lightness[moving:] = least * least * least * (largest / radius[moving:] - 1.0)
    return lightness


def list_reach(radius: Float64Array, moving: int, skin: float, reference: float) -> Float64Array:
    """Return the reach of each sphere: its radius and how far it may move while the list holds [m].

    The margin is half the skin of the geometric mean of both radii. In one layer all move by about as much,
    the small spheres by more of their own radii than the large ones: of margins in proportion to the radii
    the small spheres' would be outrun at once while the large ones' fill the list with pairs that never meet.

    Args:
        radius: Radii [m], shape (N,), float64.
        moving: The first so many spheres move; what is fixed reaches as far as its surface.
        skin: Twice the margin of a sphere of the reference radius, in units of it.
        reference: Mean radius of what moves [m].

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
