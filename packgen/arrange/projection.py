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

from packgen.arrange.walls import WallTable
from packgen.arrays import Float64Array, Int64Array


@dataclass(frozen=True, slots=True)
class Recipe:
    """The constants of the arrangement, all relative to radii, found by measurement (tests/benchmarks).

    Attributes:
        gap: Spheres and walls are arranged larger by this fraction: once the overlaps are below it, the true
            spheres do not overlap at all.
        sink_sweeps: Sweeps with a step down before each.
        sink_first: First step, in radii; the steps shrink with the third power of the sweeps left.
        sink_last: What they shrink to, in radii: small enough that the weight of the layer leaves no overlap.
        momentum: Share of a sphere's last displacement that is added again.
        relaxation: Factor on the sum of a sphere's pushes.
        stride: Largest displacement of one sweep by pushes, in radii.
        skin_first: Reach of the neighbour list beyond touching, at the start.
        skin_last: The same at the end, when little moves.
        strays: While the layer sinks, the list is renewed when this share of the spheres has outrun it.
        strays_last: The same after the sinking; none may have when the true spheres are looked at.
        give_up: (sweeps after the sinking, overlap): spheres deeper in another than this are thrown back.
        sweeps_max: Sweeps after the sinking; whatever still overlaps then is thrown back.
        retry: Sweeps until what then still overlaps is thrown back, and so on.
        throw_share: Largest share of the layer's spheres that is thrown back at a time.
        tolerance: Largest overlap of the true spheres, as a fraction of the smaller radius; None: stop after
            the sinking, whatever overlaps.
    """

    gap: float = 2.0e-4
    sink_sweeps: int = 150
    sink_first: float = 0.015
    sink_last: float = 5.0e-5
    momentum: float = 0.9
    relaxation: float = 1.0
    stride: float = 0.2
    skin_first: float = 0.8
    skin_last: float = 0.3
    strays: float = 0.1
    strays_last: float = 0.01
    give_up: tuple[tuple[int, float], ...] = ((10, 0.1), (20, 0.03), (30, 0.01), (45, 0.003))
    sweeps_max: int = 70
    retry: int = 15
    throw_share: float = 0.05
    tolerance: float | None = 1.0e-6

    def fall(self, number: int) -> float:
        """Return the step down before a sweep, in radii."""
        return self.sink_last + self.sink_first * (1.0 - number / self.sink_sweeps) ** 3


@dataclass(slots=True)
class SettleStats:
    """What a layer took: sweeps, list rebuilds, spheres that moved, spheres thrown back."""

    sweeps: int = 0
    rebuilds: int = 0
    moving: int = 0
    thrown_back: int = 0


class Layer(Protocol):
    """A layer of spheres under arrangement: what the fused CPU loops and the plain torch form both offer."""

    moving: int
    identity: Int64Array

    def rebuild(self, skin: float) -> None:
        """List neighbours and walls anew, good until a sphere moves by its margin; see ``list_reach``."""

    def sweep(
        self, sink: Float64Array, momentum: float, relaxation: float, stride: float
    ) -> tuple[float, int]:
        """Sink, extrapolate, push apart, put back; return (largest overlap, spheres that outran the list)."""

    def overlaps(self, scale: float, down: Float64Array) -> tuple[float, Float64Array]:
        """Return the largest overlap of the true spheres, and the one each moving sphere is blamed for."""

    def drop(self, out: NDArray[np.bool_]) -> None:
        """Take moving spheres out of the layer."""

    def positions(self) -> Float64Array:
        """Return the centres of the moving spheres, in the layer's own order [m], shape (moving, 3)."""


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
    reference = float(np.mean(arranged[:moving, 3])) if moving else 0.0
    _relax(layer, reference, down, recipe, stats or SettleStats(), sink)
    position = ball[:moving, :3].copy()
    kept = np.zeros(moving, bool)
    kept[layer.identity] = True
    position[layer.identity] = layer.positions()
    return position, kept


def _relax(
    layer: Layer, reference: float, down: Float64Array, recipe: Recipe, stats: SettleStats, sink: bool
) -> None:
    stats.moving += layer.moving
    sweeps = recipe.sink_sweeps if sink else 0
    give_up = dict(recipe.give_up)
    still = np.zeros(3)
    strays, skin = layer.moving, recipe.skin_first
    number = 0
    while layer.moving:
        sinking = number < sweeps
        if not sinking and recipe.tolerance is None:
            return
        # While all is in motion, a contact seen a few sweeps late does no harm.
        if strays > (recipe.strays if sinking else recipe.strays_last) * layer.moving:
            share = min(1.0, number / max(sweeps, 1))
            skin = recipe.skin_first + (recipe.skin_last - recipe.skin_first) * share
            layer.rebuild(skin)
            stats.rebuilds += 1
        fall = down * (reference * recipe.fall(number)) if sinking else still
        worst, strays = layer.sweep(fall, recipe.momentum, recipe.relaxation, recipe.stride)
        number += 1
        stats.sweeps += 1
        if sinking:
            continue
        strays, done = _end_game(layer, number - sweeps, worst, strays, skin, give_up, down, recipe, stats)
        if done:
            return


def _end_game(
    layer: Layer,
    spent: int,
    worst: float,
    strays: int,
    skin: float,
    give_up: dict[int, float],
    down: Float64Array,
    recipe: Recipe,
    stats: SettleStats,
) -> tuple[int, bool]:
    """Look whether the true spheres overlap, and throw hopeless ones back.

    Returns:
        (spheres that have outrun the neighbour list, whether the layer is done).
    """
    assert recipe.tolerance is not None
    limit = give_up.get(spent)
    if spent >= recipe.sweeps_max and (spent - recipe.sweeps_max) % recipe.retry == 0:
        limit = 0.0
    if worst > 2.5 * (recipe.gap + recipe.tolerance) and limit is None:
        return strays, False
    if strays:
        layer.rebuild(skin)
        stats.rebuilds += 1
    largest, blame = layer.overlaps(1.0 / (1.0 + recipe.gap), down)
    # Just below the tolerance: the independent check rounds differently.
    allowed = 0.99 * recipe.tolerance
    if largest <= allowed:
        return 0, True
    out = blame > max(limit, allowed) if limit is not None else np.zeros(len(blame), bool)
    if not out.any():
        return 0, False
    most = math.ceil(recipe.throw_share * layer.moving)
    if out.sum() > most:
        # A layer that is overfull: nearly all overlap, but not nearly all have to go.
        out[np.argsort(-blame, kind="stable")[most:]] = False
    stats.thrown_back += int(out.sum())
    layer.drop(out)
    return layer.moving, layer.moving == 0
