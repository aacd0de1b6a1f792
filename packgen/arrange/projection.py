"""The default optimiser: a layer sinks under gravity while projection sweeps part its overlaps.

Nothing here knows of scenes, zones or files: spheres with radii, some of which move, walls, and a direction
down go in; positions without overlap come out, and the few spheres that found no place.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from packgen.arrange.recipe import Recipe, Step
from packgen.arrange.walls import WallTable
from packgen.arrays import Float64Array, Int64Array
from packgen.portable import cube, octaves, whole_power


@dataclass(slots=True)
class SettleStats:
    """What a layer took: sweeps, list rebuilds, spheres that moved, spheres thrown back."""

    sweeps: int = 0
    rebuilds: int = 0
    moving: int = 0
    thrown_back: int = 0


class Layer(Protocol):
    """A layer of spheres under arrangement: what the fused CPU loops and the plain torch form both offer.

    Attributes:
        moving: How many spheres move; those taken out count until the next rebuild.
        identity: Place of each moving sphere in the order given, shape (moving,).
    """

    moving: int
    identity: Int64Array

    def rebuild(self, skin: float) -> None:
        """List neighbours and walls anew, good until a sphere moves by its margin; see ``list_reach``."""

    def sweep(self, sink: Float64Array, step: Step) -> tuple[float, int]:
        """Sink, extrapolate, push apart, put back; return (largest overlap, spheres that outran the list)."""

    def overlaps(self, scale: float, down: Float64Array) -> tuple[float, Float64Array]:
        """Return the largest overlap of the true spheres, and the one each moving sphere is blamed for."""

    def take_out(self, out: NDArray[np.bool_]) -> None:
        """Take moving spheres out of all contacts."""

    def positions(self) -> Float64Array:
        """Return the centres of the moving spheres, in the layer's own order [m], shape (moving, 3).

        Those taken out since the last rebuild are not numbers.
        """

    def radii(self) -> Float64Array:
        """Return the arranged radii of the moving spheres, in the layer's own order [m], shape (moving,)."""


def make_layer(ball: Float64Array, moving: int, walls: WallTable, device: str) -> Layer:
    """Return the layer's loops: fused on a CPU, plain torch elsewhere. The one place that decides."""
    if device == "cpu":
        from packgen.arrange.fused import FusedLayer

        return FusedLayer(ball, moving, walls)
    from packgen.arrange.plain import PlainLayer

    return PlainLayer(ball, moving, walls, device)


def settle(
    ball: Float64Array,
    moving: int,
    walls: WallTable,
    down: Float64Array,
    recipe: Recipe,
    stats: SettleStats | None = None,
    sink: bool = True,
    device: str = "cpu",
) -> tuple[Float64Array, NDArray[np.bool_]]:
    """Arrange a layer.

    Args:
        ball: Centres and true radii [m], shape (N, 4), float64; the first ``moving`` move.
        moving: How many move.
        walls: What bounds the moving ones.
        down: Unit vector along which they fall, shape (3,).
        recipe: Constants.
        stats: Counters to add to.
        sink: False leaves the sinking out: overlaps are parted, nothing falls.
        device: ``cpu`` for the fused loops, any other torch device for plain torch (``torch``: on the CPU).

    Returns:
        (centres of the moving spheres [m], shape (moving, 3); which of them found a place, shape (moving,)).
        Those that did overlap nothing, neither each other nor a fixed sphere nor a wall.
    """
    arranged = ball.copy()
    arranged[:, 3] *= 1.0 + recipe.gap
    layer = make_layer(arranged, moving, walls, device)
    radius = arranged[:moving, 3]
    reference = float(np.mean(radius)) if moving else 0.0
    if sink and moving:
        recipe = recipe.of_sizes(float(np.sum(whole_power(radius, 4)) / np.sum(cube(radius))) / reference)
    _relax(layer, reference, down, recipe, stats or SettleStats(), sink)
    position = ball[:moving, :3].copy()
    found = layer.positions()
    still_in = ~np.isnan(found[:, 0])
    place = layer.identity[still_in]
    kept = np.zeros(moving, bool)
    kept[place] = True
    position[place] = found[still_in]
    return position, kept


def _relax(
    layer: Layer, reference: float, down: Float64Array, recipe: Recipe, stats: SettleStats, sink: bool
) -> None:
    stats.moving += layer.moving
    number = 0 if sink else recipe.part_first
    strays = layer.moving
    tolerance = recipe.tolerance or 0.0
    while layer.moving:
        sinking = sink and number < recipe.sink_sweeps
        if not sinking and recipe.tolerance is None:
            return
        skin = recipe.skin(number)
        if strays > recipe.strays_allowed(number) * layer.moving:
            layer.rebuild(skin)
            stats.rebuilds += 1
        fall = down * (reference * recipe.fall(number) if sink else 0.0)
        worst, strays = layer.sweep(fall, recipe.step(number, rough=sink))
        number += 1
        stats.sweeps += 1
        limit = None if recipe.tolerance is None else recipe.too_much(number)
        if limit is None and (sinking or worst > 2.5 * (recipe.gap + tolerance)):
            continue
        if strays and not sinking:
            layer.rebuild(skin)
            stats.rebuilds += 1
            strays = 0
        largest, blame = layer.overlaps(1.0 / (1.0 + recipe.gap), down)
        # Just below the tolerance: the independent check rounds differently.
        least = 0.99 * tolerance
        if largest <= least and not sinking:
            return
        if limit is not None:
            stats.thrown_back += throw_back(layer, blame, max(limit, least), recipe)
            if np.isnan(layer.positions()[:, 0]).all():
                return  # nothing fits here: of no sphere at all there is no list to make


def throw_back(layer: Layer, blame: Float64Array, limit: float, recipe: Recipe) -> int:
    """Take spheres out of the layer that overlap by more than a limit.

    Of several that are squeezed together only the worst: its place is often enough for the others.

    Args:
        layer: The layer.
        blame: Overlap that each moving sphere is blamed for, as a fraction of the smaller radius, (moving,).
        limit: Overlap above which a sphere has to go.
        recipe: Constants.

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
    # Of a layer that is overfull nearly all overlap, but not nearly all have to go.
    most = math.ceil(recipe.throw_share * layer.moving)
    chosen = np.zeros(len(blame), bool)
    chosen[out[np.argsort(-blame[out], kind="stable")[:most]]] = True
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
