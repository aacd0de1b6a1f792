"""Which pairs a layer lists, how two spheres share the way that parts them, and what both forms share."""

from __future__ import annotations

import math

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int32Array, Int64Array
from packgen.compiled import inlined, loop

PARTING_X, PARTING_Y = 0.7548776662466927, 0.5698402909980532
"""Steps of an even sequence in the plane, by which coincident spheres part: powers of the plastic number, the
root of x^3 = x + 1."""

GRAIN_STEP = 0.6180339887498949
"""Step from one sphere to the next of the part of a wall's roughness that keeps it off, modulo 1: the golden
ratio's even sequence."""

GRAIN_PUSH = 0.1
"""Largest push by rough walls in a sweep, all features together, in radii: gentle, for a sphere between two
walls must not pass one."""


@inlined
def push_weight(radius: float, moves: bool, largest: float, reference: float) -> float:
    """Return the weight of one sphere; see ``push_weights``."""
    if moves:
        ratio = reference / radius
        return ratio * ratio * ratio
    least = reference / largest
    return least * least * least * (largest / radius - 1.0)


@loop
def push_weights(ball: Float64Array, moving: int, reference: float) -> Float64Array:
    """Return the weight w of each sphere in a push: of a pair, sphere i takes w_i / (w_i + w_j) of it.

    The weight of a moving sphere is one over its mass. A fixed sphere does not move, but a smaller one has a
    weight, too: a large sphere on a bed of small fixed ones has many contacts at once. If it took each push
    in full, their sum would throw it off its place again and again, until it counts as a sphere without a
    place. The largest spheres take the ratio of the radii from a fixed one, and all of the push from one of
    their own size.

    Args:
        ball: Centres and radii [m], shape (N, 4), float64.
        moving: The first ``moving`` spheres move.
        reference: Any radius [m], to keep the numbers near one.

    Returns:
        Weights, shape (N,), float64; 0 for a fixed sphere as large as the largest.
    """
    largest = 0.0
    for i in range(len(ball)):
        largest = max(largest, ball[i, 3])
    weight = np.empty(len(ball))
    for i in range(len(ball)):
        weight[i] = push_weight(ball[i, 3], i < moving, largest, reference)
    return weight


@loop
def list_reach(ball: Float64Array, moving: int, skin: float, reference: float) -> Float64Array:
    """Return the reach of each sphere: its radius plus the distance it may move while the list holds [m].

    The margin is half the skin times sqrt(mean radius * radius). All spheres of a layer move by similar
    distances. Margins proportional to the radius would be too small for small spheres and needlessly large
    for large ones; the square root is between.

    Args:
        ball: Centres and radii [m], shape (N, 4), float64.
        moving: The first ``moving`` spheres move; a fixed one reaches as far as its surface.
        skin: Twice the margin of a sphere of the reference radius, in units of it.
        reference: Mean radius of the moving spheres [m].

    Returns:
        Reaches [m], shape (N,), float64.
    """
    reach = np.empty(len(ball))
    for i in range(len(ball)):
        reach[i] = ball[i, 3]
        if i < moving:
            reach[i] += 0.5 * skin * math.sqrt(reference * reach[i])
    return reach


@loop
def pairs_to_part(
    first: Int32Array | Int64Array,
    second: Int32Array | Int64Array,
    body: Int64Array,
    identity: Int64Array,
) -> BoolArray:
    """Return which pairs of a layer may not overlap: those of two bodies.

    Args:
        first: One sphere of each pair in the layer's own order, shape (P,).
        second: The other one, shape (P,).
        body: Body of each moving sphere in the order given; see ``body_numbers``.
        identity: Place of each moving sphere in the order given, shape (moving,); others are fixed, and of no
            body that moves.

    Returns:
        Which pairs, shape (P,), bool.
    """
    moving = len(identity)
    apart = np.empty(len(first), np.bool_)
    for k in range(len(first)):
        i, j = first[k], second[k]
        apart[k] = i >= moving or j >= moving or body[identity[i]] != body[identity[j]]
    return apart


@loop
def with_their_bodies(chosen: BoolArray, body: Int64Array, identity: Int64Array) -> BoolArray:
    """Return the chosen moving spheres of a layer, and with each its whole body.

    Args:
        chosen: Which moving spheres, in the layer's own order, shape (moving,).
        body: Body of each moving sphere in the order given; empty where each is a body; see ``body_numbers``.
        identity: Place of each moving sphere in the order given, shape (moving,).

    Returns:
        Which moving spheres, shape (moving,), bool.
    """
    if len(body) == 0:
        return chosen
    touched = np.zeros(len(body), np.bool_)
    for i in range(len(chosen)):
        if chosen[i]:
            touched[body[identity[i]]] = True
    whole = np.empty(len(chosen), np.bool_)
    for i in range(len(chosen)):
        whole[i] = touched[body[identity[i]]]
    return whole


def body_numbers(body_index: Int32Array | None) -> Int64Array:
    """Return the body of each sphere, numbered from 0 on, int64; empty for None: each is a body."""
    if body_index is None:
        return np.empty(0, np.int64)
    return np.unique(body_index, return_inverse=True)[1].astype(np.int64)
