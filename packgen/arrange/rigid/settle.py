"""A layer of bodies sinks under gravity, and its overlaps are parted; of spheres see ``projection``."""

from __future__ import annotations

import math

import numpy as np

from packgen.arrange.neighbors.list_kernels import Pairs
from packgen.arrange.neighbors.seam_pairs import SeamPairs
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.projection.settle import SettleStats
from packgen.arrange.projection.throw_back import spheres_to_go
from packgen.arrange.rigid.layer import moved_bodies, state_of
from packgen.arrange.rigid.run_kernels import blame, run_sweeps
from packgen.arrange.rigid.state import RigidLists, RigidState, no_lists
from packgen.arrange.space.map_kernels import WallList
from packgen.arrange.space.walls import WallTable
from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.bodies import Bodies
from packgen.compiled import signals_heard

STEPS_MAX = 1_000_000
"""Spheres times sweeps of one run of the compiled loop, a tenth of a second: a signal waits for its end."""


def settle_bodies(
    bodies: Bodies,
    fixed: Float64Array,
    walls: WallTable,
    down: Float64Array,
    recipe: Recipe,
    stats: SettleStats | None = None,
) -> tuple[Bodies, BoolArray]:
    """Arrange a layer of bodies.

    Args:
        bodies: The bodies that move.
        fixed: Centres and true radii of the spheres that stay [m], shape (F, 4).
        walls: What bounds the moving ones.
        down: Unit vector along which they fall, shape (3,).
        recipe: Constants.
        stats: Counters to add to; of spheres.

    Returns:
        (the bodies at their new places; which of them found one, shape (B,)). Spheres of those that did
        overlap neither those of another body nor a fixed one nor a wall.
    """
    stats = stats or SettleStats()
    order = _by_place(bodies.position, down)
    if len(order) == 0:
        return bodies, np.zeros(0, bool)
    with signals_heard():
        ordered, left = _relaxed(bodies[order], fixed, walls, np.array(down, np.float64), recipe, stats)
    position, orientation = bodies.position.copy(), bodies.orientation.copy()
    kept = np.zeros(len(bodies), bool)
    place = order[left]
    position[place], orientation[place], kept[place] = ordered.position, ordered.orientation, True
    moved = Bodies(bodies.templates, bodies.template_index, bodies.scale, position, orientation)
    return moved, kept


def _by_place(position: Float64Array, down: Float64Array) -> Int64Array:
    """Return an order of bodies in which near ones are near, along the axis most across gravity, (B,)."""
    axes = np.argsort(np.abs(down), kind="stable")
    return np.lexsort([position[:, axis] for axis in axes[::-1]]).astype(np.int64)


def _relaxed(
    bodies: Bodies,
    fixed: Float64Array,
    walls: WallTable,
    down: Float64Array,
    recipe: Recipe,
    stats: SettleStats,
) -> tuple[Bodies, Int64Array]:
    """Return the bodies that found a place, and their rows among those given."""
    state = state_of(bodies, fixed, 1.0 + recipe.gap)
    stats.moving += state.moving
    left = np.arange(len(bodies))
    lists, fresh, number, done = no_lists(), True, 0, False
    while not done:
        schedule = recipe.schedule(number, sink=True, most=max(STEPS_MAX // state.moving, 1))
        found, sweeps, rebuilds, looking = run_sweeps(state, lists, walls, down, schedule, fresh)
        lists, fresh = _named(found), False
        number += sweeps
        stats.sweeps += sweeps
        stats.rebuilds += rebuilds
        if not looking:
            continue
        worst, blamed = blame(state, lists, walls.features, down, schedule.scale)
        at = sweeps - 1
        done = worst <= schedule.least and not schedule.sinking[at]
        limit = float(schedule.limit[at])
        if done or not limit < math.inf:
            continue
        out = _to_go(state, blamed, max(limit, schedule.least), schedule.throw_share)
        if out.any():
            stats.thrown_back += int(out.sum())
            state, bodies, left = _without(state, bodies, left, out)
            lists, fresh, done = no_lists(), True, len(left) == 0
    return moved_bodies(bodies, state), left


def _to_go(state: RigidState, blamed: Float64Array, limit: float, share: float) -> BoolArray:
    """Return which bodies have to go, shape (B,); see ``spheres_to_go``."""
    ball = np.column_stack([state.centre, state.size])
    return np.asarray(spheres_to_go(ball, blamed, limit, math.ceil(share * len(blamed))))


def _without(
    state: RigidState, bodies: Bodies, left: Int64Array, out: BoolArray
) -> tuple[RigidState, Bodies, Int64Array]:
    """Return a layer without some of its bodies, the others as they were, moving as they did."""
    count = np.diff(state.first)
    stays = np.repeat(~out, count)
    kept = np.concatenate([stays, np.ones(len(state.ball) - state.moving, bool)])
    rows = np.append(~out, True)
    first = np.concatenate([[0], np.cumsum(count[~out])])
    owner = np.full(int(kept.sum()), len(first) - 1, np.int64)
    owner[: first[-1]] = np.repeat(np.arange(len(first) - 1), np.diff(first))
    rest = RigidState(
        state.centre[~out], state.turn[~out], state.motion[rows], state.slackness[~out], state.slack[rows],
        state.size[~out], state.extent[~out], first, state.local[stays], owner, state.ball[kept],
        state.arm[kept], state.reference,
    )  # fmt: skip
    return rest, bodies[~out], left[~out]


def _named(found: tuple) -> RigidLists:  # type: ignore[type-arg]
    """Give what a loop has returned its names again; see ``run_kernels.plain``."""
    pairs, rows, seam, near, anchor, margin, room = found
    return RigidLists(Pairs(*pairs), rows, SeamPairs(*seam), WallList(*near), anchor, margin, room)
