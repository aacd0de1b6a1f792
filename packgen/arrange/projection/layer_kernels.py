"""A whole layer in one loop: lists, sweeps, overlaps, and who is thrown back, with no Python in between.

Each thread of a team runs it on its share; see ``shares``. All take the same decisions.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.projection.pair_rules import with_their_bodies
from packgen.arrange.projection.rebuild_kernels import rebuilt
from packgen.arrange.projection.recipe import Schedule, Step
from packgen.arrange.projection.shares import LOOKED, PACE, Team, agreed
from packgen.arrange.projection.sweep_kernels import (
    LayerState,
    Lists,
    Motion,
    Now,
    blame_own,
    look_ahead,
    sweep,
)
from packgen.arrange.projection.throw_back import spheres_to_go
from packgen.arrange.space.seams import wrapped_coordinate
from packgen.arrange.space.walls import WallTable
from packgen.compiled import inlined, inner_loop, loop
from packgen.team import meet, ticks


@inner_loop
def throw_back(state: LayerState, now: Now, walls: WallTable, limit: float, share_most: float, team: Team):  # type: ignore[no-untyped-def]
    """Take spheres out that overlap by more than a limit, and with each its whole body.

    Args:
        state: The layer; the centres of those that are taken out become NaN.
        now: What counts of it.
        walls: The walls.
        limit: Overlap above which a sphere has to go.
        share_most: Largest share of the moving spheres that goes.
        team: The threads, of which the first does all of it.

    Returns:
        (how many were taken out, whether any moving sphere is left).
    """
    if team.rank == 0:
        chosen = to_go(state, now, walls, limit, math.ceil(share_most * now.moving))
        ball, out, left = state.ball[now.side], 0, 0
        for i in range(now.moving):
            if chosen[i]:
                # NaN compares false: never in contact, never counted as having outrun the list.
                for axis in range(3):
                    ball[i, axis] = math.nan
                out += 1
            left += not math.isnan(ball[i, 0])
        team.known[2], team.known[3] = out, left
    meet(team.board, team.size)
    return team.known[2], team.known[3] > 0


@inner_loop
def to_go(state: LayerState, now: Now, walls: WallTable, limit: float, most: int) -> NDArray[np.bool_]:
    """Return which moving spheres have to go, shape (moving,); see ``throw_back``."""
    ball, (low, period) = np.empty((now.moving, 4)), walls.seams
    for i in range(now.moving):
        for axis in range(3):
            ball[i, axis] = wrapped_coordinate(state.ball[now.side, i, axis], low[axis], period[axis])
        ball[i, 3] = state.ball[now.side, i, 3]
    chosen = spheres_to_go(ball, state.blame[: now.moving], limit, most)
    return with_their_bodies(chosen, state.body, state.identity[now.side][: now.moving])


@inlined
def plain(now: Now, lists: Lists):  # type: ignore[no-untyped-def]
    """Return what counts, and lists, as tuples without names, which alone a loop may give back to Python."""
    own, (owner, neighbor), (first, second, offset), (begin, item, room), (center, margin), work = lists
    rows, one, other, shift, turned, spare = work
    side, moving, total = now
    return (
        (side, moving, total),
        (
            own,
            (owner, neighbor),
            (first, second, offset),
            (begin, item, room),
            (center, margin),
            (rows, one, other, shift, turned, spare),
        ),
    )


@loop
def run_sweeps(  # type: ignore[no-untyped-def]
    state: LayerState,
    now: Now,
    lists: Lists,
    walls: WallTable,
    down: NDArray[np.float64],
    schedule: Schedule,
    strays: int,
    team: Team,
):
    """Run the sweeps of a schedule with all that comes between them, as ``run_by_steps`` does one by one.

    Args:
        state: The layer; its arrays change.
        now: What counts of it.
        lists: What is near the own spheres; their arrays change.
        walls: The walls.
        down: Unit vector along which things fall, shape (3,).
        schedule: What each sweep takes, S of them.
        strays: Spheres that have outrun the lists so far; all of them where there are no lists yet.
        team: The threads.

    Returns:
        (what counts, and the lists, see ``plain``; what was done, see ``Tally``).
    """
    # The sweep would be compiled once more for a mere 0.
    rebuilds, thrown, number, turn = 0, 0, 0, int(np.int64(0))
    sink, sink_next = np.empty(3), np.empty(3)
    fresh, looking, done = True, False, False
    while not done and (looking or number < len(schedule.fall)):
        at = number - looking
        void = strays > 0 and not schedule.sinking[at]
        if not looking:
            void = strays > schedule.strays[at] * now.moving
        if void:
            now, lists = rebuilt(state, now, lists, walls, schedule.skin[at], team)
            rebuilds += 1
            fresh = True
        if looking:
            looking = False
            strays = 0 if void else strays
            largest = blame_own(state, now, lists, walls.features, down, schedule.scale)
            largest, _ = agreed(team, LOOKED, largest, strays)
            done, limit = largest <= schedule.least and not schedule.sinking[at], schedule.limit[at]
            if not done and limit < math.inf:
                limit = max(limit, schedule.least)
                out, left = throw_back(state, now, walls, limit, schedule.throw_share, team)
                thrown += out
                fresh = fresh or out > 0
                # An empty layer has no neighbour list.
                done = not left
            continue
        following = min(number + 1, len(schedule.fall) - 1)
        for axis in range(3):
            sink[axis] = down[axis] * (state.reference * schedule.fall[number])
            sink_next[axis] = down[axis] * (state.reference * schedule.fall[following])
        step = step_of(schedule, number)
        if fresh:
            look_ahead(state, now, lists.own, turn, sink, step.momentum)
            meet(team.board, team.size)
            fresh = False
        turn_next = turn if team.size == 1 else 1 - turn
        motion = Motion(turn, turn_next, sink, step, sink_next, schedule.momentum[following])
        start = ticks()
        worst, strays = sweep(state, now, lists, walls.features, motion)
        team.told[PACE, team.rank, 1] += ticks() - start
        worst, strays = agreed(team, turn, worst, strays)
        turn = turn_next
        number += 1
        calm = not schedule.sinking[at] and not worst > schedule.calm
        looking = calm or schedule.limit[at] < math.inf
    keep_turning(state, lists.own, turn)
    return plain(now, lists), (number, rebuilds, thrown, strays, done)


@inner_loop
def keep_turning(state: LayerState, own: NDArray[np.int32], turn: int) -> None:
    """Write how the own spheres turned last where the next run begins: on the first side."""
    if turn == 0 or state.spin.shape[1] == 0:
        return
    for i in own:
        for axis in range(3):
            state.spin[0, i, axis] = state.spin[turn, i, axis]


@inlined
def step_of(schedule: Schedule, number: int) -> Step:
    """Return how a sweep of a schedule moves the spheres."""
    return Step(
        schedule.momentum[number],
        schedule.relaxation,
        schedule.stride,
        schedule.roughness[number],
        schedule.far[number],
        schedule.friction,
        schedule.grip,
    )


@loop
def rebuilt_alone(  # type: ignore[no-untyped-def]
    state: LayerState, now: Now, lists: Lists, walls: WallTable, skin: float, team: Team
):
    """Do what ``rebuilt`` does; see ``plain``."""
    now, lists = rebuilt(state, now, lists, walls, skin, team)
    return plain(now, lists)


@loop
def sweep_alone(  # type: ignore[no-untyped-def]
    state: LayerState,
    now: Now,
    lists: Lists,
    walls: WallTable,
    sink: NDArray[np.float64],
    step: Step,
    team: Team,
):
    """Do one ``sweep`` and what it needs; return the largest overlap and the strays of all threads."""
    look_ahead(state, now, lists.own, 0, sink, step.momentum)
    meet(team.board, team.size)
    worst, strays = sweep(state, now, lists, walls.features, Motion(0, 1, sink, step, sink, 0.0))
    keep_turning(state, lists.own, 1)
    return agreed(team, 0, worst, strays)


@loop
def blame_alone(
    state: LayerState,
    now: Now,
    lists: Lists,
    walls: WallTable,
    down: NDArray[np.float64],
    scale: float,
    team: Team,
) -> float:
    """Do what ``blame_own`` does; return the largest overlap of all threads."""
    largest = blame_own(state, now, lists, walls.features, down, scale)
    found: float = agreed(team, LOOKED, largest, 0)[0]
    return found
