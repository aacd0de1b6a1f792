"""Runs the sweeps of a layer step by step: in plain torch, and as the compiled run has to come out."""

from __future__ import annotations

import math

import numpy as np

from packgen.arrange.projection.layer import Layer
from packgen.arrange.projection.pair_rules import with_their_bodies
from packgen.arrange.projection.recipe import Schedule, Step, Tally
from packgen.arrange.projection.throw_back import spheres_to_go
from packgen.arrays import Float64Array, Int64Array


def run_by_steps(
    layer: Layer, down: Float64Array, schedule: Schedule, strays: int, reference: float, body: Int64Array
) -> Tally:
    """Run the sweeps of a schedule with all that comes between them; see ``Layer.run``.

    Args:
        layer: The layer.
        down: Unit vector along which things fall, shape (3,).
        schedule: What each sweep takes.
        strays: Spheres that have outrun the lists so far; all of them where there are no lists yet.
        reference: Mean radius of the spheres that moved at first [m].
        body: Body of each sphere in the order given, numbered from 0; empty: each is a body.
    """
    rebuilds, thrown = 0, 0
    count = len(schedule.fall)
    for number in range(count):
        sinking, limit = bool(schedule.sinking[number]), float(schedule.limit[number])
        skin = float(schedule.skin[number])
        if strays > schedule.strays[number] * layer.moving:
            layer.rebuild(skin)
            rebuilds += 1
        step = Step(
            float(schedule.momentum[number]),
            schedule.relaxation,
            schedule.stride,
            float(schedule.roughness[number]),
            float(schedule.far[number]),
            schedule.friction,
            schedule.grip,
        )
        worst, strays = layer.sweep(down * (reference * schedule.fall[number]), step)
        judged = limit < math.inf
        if not judged and (sinking or worst > schedule.calm):
            continue
        if strays and not sinking:
            layer.rebuild(skin)
            rebuilds += 1
            strays = 0
        largest, blame = layer.overlaps(schedule.scale, down)
        if largest <= schedule.least and not sinking:
            return Tally(number + 1, rebuilds, thrown, strays, True)
        if judged:
            thrown += throw_back(layer, blame, max(limit, schedule.least), schedule.throw_share, body)
            if np.isnan(layer.positions()[:, 0]).all():
                # An empty layer has no neighbour list.
                return Tally(number + 1, rebuilds, thrown, strays, True)
    return Tally(count, rebuilds, thrown, strays, False)


def throw_back(layer: Layer, blame: Float64Array, limit: float, share: float, body: Int64Array) -> int:
    """Take spheres out of the layer that overlap by more than a limit, and with each its whole body.

    Args:
        layer: The layer.
        blame: Overlap that each moving sphere is blamed for, as a fraction of the smaller radius, (moving,).
        limit: Overlap above which a sphere has to go.
        share: Largest share of the moving spheres that goes.
        body: Body of each sphere in the order given, numbered from 0; empty: each is a body.

    Returns:
        How many were taken out.
    """
    ball = np.column_stack([layer.positions(), layer.radii()])
    chosen = spheres_to_go(ball, blame, limit, math.ceil(share * layer.moving))
    chosen = with_their_bodies(chosen, body, layer.identity)
    layer.take_out(chosen)
    return int(chosen.sum())
