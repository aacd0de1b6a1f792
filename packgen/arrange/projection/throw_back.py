"""Which spheres of a layer have to go: those that overlap too much, the worst of each group."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrange.projection.layer import Layer
from packgen.arrange.projection.recipe import Recipe
from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.bodies import touched_bodies
from packgen.portable import octaves


def throw_back(
    layer: Layer, blame: Float64Array, limit: float, recipe: Recipe, body_index: Int32Array | None = None
) -> int:
    """Take spheres out of the layer that overlap by more than a limit, and with each its whole body.

    Of several squeezed together only the worst goes: its place is often enough for the others.

    Args:
        layer: The layer.
        blame: Overlap that each moving sphere is blamed for, as a fraction of the smaller radius, (moving,).
        limit: Overlap above which a sphere has to go.
        recipe: Constants.
        body_index: Body of each sphere in the order in which the layer was given them; None: each sphere is a
            body.

    Returns:
        How many were taken out.
    """
    out = np.flatnonzero(blame > limit)
    if len(out) == 0:
        return 0
    first, second = squeezed_pairs(layer.positions()[out], layer.radii()[out])
    worst = np.ones(len(out), bool)
    worst[np.where(blame[out[first]] < blame[out[second]], first, second)] = False
    out = out[worst]
    # In an overfull layer most spheres overlap, yet removing a few is enough: remove at most `throw_share` at
    # a time.
    most = math.ceil(recipe.throw_share * layer.moving)
    chosen = np.zeros(len(blame), bool)
    chosen[out[np.argsort(-blame[out], kind="stable")[:most]]] = True
    if body_index is not None:
        chosen = touched_bodies(chosen, body_index[layer.identity])
    layer.take_out(chosen)
    return int(chosen.sum())


def squeezed_pairs(position: Float64Array, radius: Float64Array) -> tuple[Int64Array, Int64Array]:
    """Find the pairs of spheres nearer than twice the sum of their radii, octave by octave of radius.

    Args:
        position: Centres [m], shape (n, 3).
        radius: Radii [m], shape (n,), at least one.

    Returns:
        (the larger ones, shape (P,), the others, shape (P,)); of two in an octave, the one that comes first.
    """
    octave = octaves(radius.max() / radius, slack=0.0)
    pairs = [np.empty((0, 2), np.int64)]
    for number in np.unique(octave):
        members, smaller = np.flatnonzero(octave == number), np.flatnonzero(octave > number)
        tree = cKDTree(position[members])
        pairs.append(members[tree.query_pairs(4.0 * float(radius[members].max()), output_type="ndarray")])
        if len(smaller):
            farthest = 2.0 * float(radius[members].max() + radius[smaller].max())
            near = tree.sparse_distance_matrix(cKDTree(position[smaller]), farthest, output_type="ndarray")
            pairs.append(np.stack([members[near["i"]], smaller[near["j"]]], axis=1))
    first, second = np.concatenate(pairs).T
    distance = np.linalg.norm(position[first] - position[second], axis=1)
    near_enough = distance <= 2.0 * (radius[first] + radius[second])
    return first[near_enough], second[near_enough]
