"""The default optimiser: a layer sinks under gravity while projection sweeps part its overlaps.

Nothing here knows of scenes, zones or files: spheres with radii, some of which move, walls, and a direction
down go in; positions without overlap come out, and the few spheres that found no place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.projection.layer import Layer, make_layer
from packgen.arrange.projection.pair_rules import body_numbers
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.space.walls import WallTable
from packgen.arrays import Float64Array, Int32Array
from packgen.bodies import whole_bodies
from packgen.compiled import signals_heard
from packgen.portable import cube, whole_power

STEPS_MAX = 2_000_000
"""Spheres times sweeps of one run of the compiled loop, a tenth of a second: a signal waits for its end."""

SHARE_MIN = 500
"""Least moving spheres a thread."""

STRIPE_MIN = 3.0
"""Least width of a thread's stripe, in largest diameters: pairs across its sides are looked at twice."""


@dataclass(slots=True)
class SettleStats:
    """What a layer took: sweeps, list rebuilds, spheres that moved, spheres thrown back."""

    sweeps: int = 0
    rebuilds: int = 0
    moving: int = 0
    thrown_back: int = 0


def settle(
    ball: Float64Array,
    moving: int,
    walls: WallTable,
    down: Float64Array,
    recipe: Recipe,
    stats: SettleStats | None = None,
    sink: bool = True,
    device: str = "cpu",
    body_index: Int32Array | None = None,
    threads: int = 1,
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
        body_index: Body of each moving sphere, shape (moving,); a body finds a place as a whole or not at
            all. Its spheres may overlap each other, and move each for itself. None: each sphere is a body.
        threads: Threads at most; see ``threads_of``. The outcome does not depend on it.

    Returns:
        (centres of the moving spheres [m], shape (moving, 3); which of them found a place, shape (moving,)).
        Those that did overlap neither each other nor a fixed sphere nor a wall; only spheres of their own
        body.
    """
    with signals_heard():
        layer = _arranged(
            ball, moving, walls, down, recipe, stats or SettleStats(), sink, device, body_index, threads
        )
        found = layer.positions()
    position = ball[:moving, :3].copy()
    still_in = ~np.isnan(found[:, 0])
    place = layer.identity[still_in]
    kept = np.zeros(moving, bool)
    kept[place] = True
    position[place] = found[still_in]
    return position, whole_bodies(kept, body_index)


def _arranged(
    ball: Float64Array,
    moving: int,
    walls: WallTable,
    down: Float64Array,
    recipe: Recipe,
    stats: SettleStats,
    sink: bool,
    device: str,
    body_index: Int32Array | None,
    threads: int,
) -> Layer:
    """Return the layer in which the spheres have come to rest; see ``settle``."""
    arranged = ball.copy()
    arranged[:, 3] *= 1.0 + recipe.gap
    body, threads = body_numbers(body_index), threads_of(ball[:moving], threads)
    layer = make_layer(arranged, moving, walls, device, body, threads, rubs=recipe.friction > 0.0)
    radius = arranged[:moving, 3]
    reference = float(np.mean(radius)) if moving else 0.0
    if sink and moving and radius.min() < radius.max():
        recipe = recipe.of_sizes(float(np.sum(whole_power(radius, 4)) / np.sum(cube(radius))) / reference)
    # One kind of array: the compiled loop is made for it alone.
    _relax(layer, np.array(down, np.float64), recipe, stats, sink)
    return layer


def threads_of(ball: Float64Array, most: int) -> int:
    """Return how many threads a layer is worth: a small one is arranged before its threads have met.

    Args:
        ball: Centres and radii of the moving spheres [m], shape (moving, 4).
        most: Threads at most.
    """
    if len(ball) == 0:
        return 1
    longest = float(np.ptp(ball[:, :3], axis=0).max())
    narrowest = 2.0 * STRIPE_MIN * float(ball[:, 3].max())
    return max(1, min(most, len(ball) // SHARE_MIN, int(longest / narrowest)))


def _relax(layer: Layer, down: Float64Array, recipe: Recipe, stats: SettleStats, sink: bool) -> None:
    stats.moving += layer.moving
    number = 0 if sink else recipe.part_first
    strays, done = layer.moving, layer.moving == 0
    while not done:
        if recipe.tolerance is None and not (sink and number < recipe.sink_sweeps):
            return
        # Between two schedules Python has its turn, and a signal is heard.
        schedule = recipe.schedule(number, sink=sink, most=max(STEPS_MAX // layer.moving, 1))
        sweeps, rebuilds, thrown_back, strays, done = layer.run(down, schedule, strays)
        number += sweeps
        stats.sweeps += sweeps
        stats.rebuilds += rebuilds
        stats.thrown_back += thrown_back
