"""One sweep over a layer of bodies: they fall and go on, overlaps part one by one, walls push back."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.seam_pairs import SeamPairs
from packgen.arrange.projection.push_kernels import touching_pairs
from packgen.arrange.rigid.contact_kernels import along, drift, give, part, push_body, rub
from packgen.arrange.rigid.pose_kernels import turn_by, turned_tensors
from packgen.arrange.rigid.state import Pace, RigidLists, RigidState
from packgen.arrange.space.feature_kernels import Features, out_of_reach, wall_gap
from packgen.compiled import inner_loop


@inner_loop
def go_ahead(state: RigidState, down: NDArray[np.float64], pace: Pace) -> None:
    """Let the bodies fall a step, and go on as they went in the last sweep."""
    centre, turn, motion = state.centre, state.turn, state.motion
    x, y, z = pace.fall * down[0], pace.fall * down[1], pace.fall * down[2]
    for b in range(len(centre)):
        for axis in range(6):
            motion[b, axis] *= pace.momentum
        motion[b, 0] += x
        motion[b, 1] += y
        motion[b, 2] += z
        for axis in range(3):
            centre[b, axis] += motion[b, axis]
        turn_by(turn, b, (motion[b, 3], motion[b, 4], motion[b, 5]))


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
def sweep(
    state: RigidState, lists: RigidLists, features: Features, pace: Pace, push: NDArray[np.float64]
) -> float:
    """Part what overlaps, once.

    Args:
        state: The layer, its bodies gone ahead.
        lists: What is near.
        features: The walls.
        pace: What the sweep takes.
        push: Work space, shape (B + 1, 6).

    Returns:
        The largest overlap met, over the radius of the smaller sphere.
    """
    turned_tensors(state.turn, state.slackness, state.slack)
    push[:] = 0.0
    most = len(lists.pairs.owner) + 1
    one, other = np.empty(most, np.int32), np.empty(most, np.int32)
    count = touching_pairs(state.ball, lists.pairs, lists.rows, one, other)
    worst = part_all(state, lists.seam, one[:count], other[:count], pace.friction, push)
    worst = max(worst, push_off_walls(state, lists, features, pace.friction, push))
    end_sweep(state, pace, push)
    return worst


@inner_loop
def part_all(
    state: RigidState,
    seam: SeamPairs,
    one: NDArray[np.int32],
    other: NDArray[np.int32],
    friction: float,
    push: NDArray[np.float64],
) -> float:
    """Part the pairs that overlap, and those across seams; return the largest overlap found on the way."""
    ball, arm, owner, slack, motion = state.ball, state.arm, state.owner, state.slack, state.motion
    worst, (first, second, offset) = 0.0, seam
    for k in range(len(one)):
        i, j = np.uint64(one[k]), np.uint64(other[k])
        found = part(i, j, (0.0, 0.0, 0.0), friction, ball, arm, owner, slack, motion, push)
        worst = max(worst, found)
    for k in range(len(first)):
        i, j, beyond = np.uint64(first[k]), np.uint64(second[k]), (offset[k, 0], offset[k, 1], offset[k, 2])
        worst = max(worst, part(i, j, beyond, friction, ball, arm, owner, slack, motion, push))
    return worst


@inner_loop
def push_off_walls(
    state: RigidState,
    lists: RigidLists,
    features: Features,
    friction: float,
    push: NDArray[np.float64],
) -> float:
    """Push bodies back whose spheres stick out of walls; return the deepest, over the sphere's radius."""
    ball, arms, owner, slack, motion = state.ball, state.arm, state.owner, state.slack, state.motion
    (kind, row), (begin, item, room) = features, lists.near
    anchor, worst, wall = lists.anchor, 0.0, np.uint64(len(state.centre))
    for i in range(len(anchor)):
        a, radius = np.uint64(owner[i]), ball[i, 3]
        arm = (arms[i, 0], arms[i, 1], arms[i, 2])
        for k in range(begin[i], begin[i + 1]):
            way = drift(a, arm, push)
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
                p = -gap / give(a, arm, n, slack)
                push_body(a, arm, (p * nx, p * ny, p * nz), slack, push)
                worst = max(worst, -gap / radius)
                if friction > 0.0:
                    touch = (along(arm, -radius, n), (0.0, 0.0, 0.0))
                    rub((a, wall), touch, n, friction * p, slack, motion, push)
    return worst


@inner_loop
def end_sweep(state: RigidState, pace: Pace, push: NDArray[np.float64]) -> None:
    """Move and turn the bodies by what pushed them, at most by a stride."""
    centre, turn, motion, size, extent = state.centre, state.turn, state.motion, state.size, state.extent
    for b in range(len(centre)):
        x, y, z = push[b, 3], push[b, 4], push[b, 5]
        far = extent[b] * math.sqrt(x * x + y * y + z * z)
        x, y, z = push[b, 0], push[b, 1], push[b, 2]
        far += math.sqrt(x * x + y * y + z * z)
        limit = pace.stride * size[b]
        share = limit / far if far > limit else 1.0
        for axis in range(6):
            push[b, axis] *= share
            motion[b, axis] += push[b, axis]
        for axis in range(3):
            centre[b, axis] += push[b, axis]
        turn_by(turn, b, (push[b, 3], push[b, 4], push[b, 5]))
