"""One sweep over a layer of bodies: they fall and go on, overlaps part one by one, walls push back."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.projection.push_kernels import touching_pairs
from packgen.arrange.rigid.contact_kernels import (
    STILL,
    Work,
    along,
    drift,
    give,
    part,
    push_body,
    rub,
)
from packgen.arrange.rigid.pose_kernels import turn_by, turned_tensors
from packgen.arrange.rigid.state import Pace, RigidLists, RigidState
from packgen.arrange.space.feature_kernels import Features, out_of_reach, wall_gap
from packgen.compiled import inner_loop


@inner_loop
def go_ahead(state: RigidState, down: NDArray[np.float64], pace: Pace) -> None:
    """Let the bodies fall a step, and go on as they went in the last sweep."""
    centre, moved, turned = state.centre, state.moved, state.turned
    for b in range(len(centre)):
        for axis in range(3):
            moved[b, axis] = pace.momentum * moved[b, axis] + pace.fall * down[axis]
            centre[b, axis] += moved[b, axis]
            turned[b, axis] *= pace.momentum
        turn_by(state.turn, b, (turned[b, 0], turned[b, 1], turned[b, 2]))


@inner_loop
def strays_of(state: RigidState, lists: RigidLists, far: float) -> int:
    """Return how many spheres have outrun the lists; one that has by ``far`` margins counts as all."""
    anchor, margin, ball = lists.anchor, lists.margin, state.ball
    strays = 0
    for i in range(len(margin)):
        dx, dy, dz = ball[i, 0] - anchor[i, 0], ball[i, 1] - anchor[i, 1], ball[i, 2] - anchor[i, 2]
        square, allowed = dx * dx + dy * dy + dz * dz, margin[i] * margin[i]
        if square > allowed:
            strays += 1
            if square > far * far * allowed:
                strays += len(margin)
    return strays


@inner_loop
def sweep(state: RigidState, lists: RigidLists, features: Features, pace: Pace, work: Work) -> float:
    """Part what overlaps, once; return the largest overlap met, over the radius of the smaller sphere."""
    turned_tensors(state.turn, state.slackness, work.slack)
    work.shift[:] = 0.0
    work.swing[:] = 0.0
    most = len(lists.pairs.owner) + 1
    one, other = np.empty(most, np.int32), np.empty(most, np.int32)
    count = touching_pairs(state.ball, lists.pairs, lists.rows, one, other)
    worst = part_all(state, lists, one[:count], other[:count], pace, work)
    worst = max(worst, push_off_walls(state, lists, features, pace.friction, work))
    end_sweep(state, pace, work)
    return worst


@inner_loop
def part_all(
    state: RigidState,
    lists: RigidLists,
    one: NDArray[np.int32],
    other: NDArray[np.int32],
    pace: Pace,
    work: Work,
) -> float:
    """Part the pairs that overlap, and those across seams; return the largest overlap found on the way."""
    worst, (first, second, offset) = 0.0, lists.seam
    within = len(one)
    for k in range(within + len(first)):
        i, j, beyond = 0, 0, STILL
        if k < within:
            i, j = one[k], other[k]
        else:
            at = k - within
            i, j, beyond = first[at], second[at], (offset[at, 0], offset[at, 1], offset[at, 2])
        if state.owner[i] < 0:
            i, j, beyond = j, i, along(STILL, -1.0, beyond)
        worst = max(worst, part(i, j, beyond, pace.friction, state, work))
    return worst


@inner_loop
def push_off_walls(
    state: RigidState, lists: RigidLists, features: Features, friction: float, work: Work
) -> float:
    """Push bodies back whose spheres stick out of walls; return the deepest, over the sphere's radius."""
    ball, (kind, row), (begin, item, room) = state.ball, features, lists.near
    anchor, worst = lists.anchor, 0.0
    for i in range(len(state.arm)):
        a, radius = state.owner[i], ball[i, 3]
        arm = (state.arm[i, 0], state.arm[i, 1], state.arm[i, 2])
        for k in range(begin[i], begin[i + 1]):
            way = drift(a, arm, work.shift, work.swing)
            x, y, z = ball[i, 0] + way[0], ball[i, 1] + way[1], ball[i, 2] + way[2]
            dx, dy, dz = x - anchor[i, 0], y - anchor[i, 1], z - anchor[i, 2]
            # No gap shrinks by more than the sphere moves: most features are still out of touch.
            if room[k] > 0.0 and dx * dx + dy * dy + dz * dz < room[k] * room[k]:
                continue
            feature = item[k]
            if out_of_reach(kind[feature], row[feature], x, y, z, radius):
                continue
            gap, nx, ny, nz = wall_gap(kind[feature], row[feature], x, y, z, radius)
            if gap < 0.0:
                n = (nx, ny, nz)
                push = -gap / give(a, arm, n, state, work)
                push_body(a, arm, along(STILL, push, n), state, work)
                worst = max(worst, -gap / radius)
                if friction > 0.0:
                    rub((a, -1), (along(arm, -radius, n), STILL), n, friction * push, state, work)
    return worst


@inner_loop
def end_sweep(state: RigidState, pace: Pace, work: Work) -> None:
    """Move and turn the bodies by what pushed them, at most by a stride."""
    shift, swing = work.shift, work.swing
    for b in range(len(state.centre)):
        far = math.sqrt(shift[b, 0] ** 2 + shift[b, 1] ** 2 + shift[b, 2] ** 2)
        far += state.extent[b] * math.sqrt(swing[b, 0] ** 2 + swing[b, 1] ** 2 + swing[b, 2] ** 2)
        limit = pace.stride * state.size[b]
        share = limit / far if far > limit else 1.0
        for axis in range(3):
            shift[b, axis] *= share
            swing[b, axis] *= share
            state.centre[b, axis] += shift[b, axis]
            state.moved[b, axis] += shift[b, axis]
            state.turned[b, axis] += swing[b, axis]
        turn_by(state.turn, b, (swing[b, 0], swing[b, 1], swing[b, 2]))
