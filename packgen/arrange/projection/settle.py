"""The default optimiser: a layer sinks under gravity while projection sweeps part its overlaps.

Nothing here knows of scenes, zones or files: spheres with radii, some of which move, walls, and a direction
down go in; positions without overlap come out, and the few spheres that found no place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.projection.layer import Layer, make_layer
from packgen.arrange.projection.recipe import Recipe, Schedule
from packgen.arrange.projection.throw_back import throw_back
from packgen.arrange.space.walls import WallTable
from packgen.arrays import Float64Array, Int32Array
from packgen.bodies import whole_bodies
from packgen.portable import cube, whole_power


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

    Returns:
        (centres of the moving spheres [m], shape (moving, 3); which of them found a place, shape (moving,)).
        Those that did overlap neither each other nor a fixed sphere nor a wall; only spheres of their own
        body.
    """
    arranged = ball.copy()
    arranged[:, 3] *= 1.0 + recipe.gap
    layer = make_layer(arranged, moving, walls, device, body_index)
    radius = arranged[:moving, 3]
    reference = float(np.mean(radius)) if moving else 0.0
    if sink and moving and radius.min() < radius.max():
        recipe = recipe.of_sizes(float(np.sum(whole_power(radius, 4)) / np.sum(cube(radius))) / reference)
    _relax(layer, reference, down, recipe, stats or SettleStats(), sink, body_index)
    position = ball[:moving, :3].copy()
    found = layer.positions()
    still_in = ~np.isnan(found[:, 0])
    place = layer.identity[still_in]
    kept = np.zeros(moving, bool)
    kept[place] = True
    position[place] = found[still_in]
    return position, whole_bodies(kept, body_index)


def _relax(
    layer: Layer,
    reference: float,
    down: Float64Array,
    recipe: Recipe,
    stats: SettleStats,
    sink: bool,
    body_index: Int32Array | None,
) -> None:
    stats.moving += layer.moving
    number = 0 if sink else recipe.part_first
    strays = layer.moving
    tolerance = recipe.tolerance or 0.0
    schedule: Schedule | None = None
    while layer.moving:
        sinking = sink and number < recipe.sink_sweeps
        if not sinking and recipe.tolerance is None:
            return
        if strays > recipe.strays_allowed(number) * layer.moving:
            layer.rebuild(recipe.skin(number))
            stats.rebuilds += 1
        if schedule is None or number >= schedule.first + len(schedule.fall):
            schedule = recipe.schedule(number, sink=sink).of_radius(reference)
        schedule = schedule.since(number - schedule.first)
        done, worst, strays = layer.sweeps(down, schedule)
        number += done
        stats.sweeps += done
        # The state in which the last of these sweeps began.
        sinking, skin = bool(schedule.sinking[done - 1]), recipe.skin(number - 1)
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
            stats.thrown_back += throw_back(layer, blame, max(limit, least), recipe, body_index)
            if np.isnan(layer.positions()[:, 0]).all():
                return  # all were thrown back; an empty layer has no neighbour list
