"""The sweeps of a layer of bodies, with all that comes between them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.projection.recipe import Schedule
from packgen.arrange.rigid.list_kernels import rebuilt
from packgen.arrange.rigid.pose_kernels import place_members
from packgen.arrange.rigid.state import Pace, RigidLists, RigidState
from packgen.arrange.rigid.sweep_kernels import go_ahead, strays_of, sweep
from packgen.arrange.space.feature_kernels import Features, out_of_reach, wall_gap
from packgen.arrange.space.walls import WallTable
from packgen.compiled import inlined, inner_loop, loop


@inlined
def plain(lists: RigidLists):  # type: ignore[no-untyped-def]
    """Return lists as tuples without names, which alone a loop may give back to Python."""
    (owner, neighbor), rows, (first, second, offset), (begin, item, gaps), anchor, margin, room = lists
    return (owner, neighbor), rows, (first, second, offset), (begin, item, gaps), anchor, margin, room


@loop
def run_sweeps(  # type: ignore[no-untyped-def]
    state: RigidState,
    lists: RigidLists,
    walls: WallTable,
    down: NDArray[np.float64],
    schedule: Schedule,
    fresh: bool,
):
    """Run the sweeps of a schedule until one after which the layer is to be looked at.

    Args:
        state: The layer; its arrays change.
        lists: What is near its spheres.
        walls: The walls.
        down: Unit vector along which things fall, shape (3,).
        schedule: What each sweep takes, S of them.
        fresh: Whether there are no lists yet.

    Returns:
        (lists, see ``plain``; how many sweeps were run; how often the lists were made anew; whether the layer
        is to be looked at).
    """
    push = np.zeros((len(state.centre) + 1, 6))
    number, rebuilds, looking = 0, 0, False
    void = fresh
    while number < len(schedule.fall) and not looking:
        pace = Pace(
            state.reference * schedule.fall[number], schedule.momentum[number], schedule.stride,
            schedule.friction,
        )  # fmt: skip
        go_ahead(state, down, pace)
        place_members(state)
        if not void:
            strays = strays_of(state, lists, schedule.far[number])
            void = strays > schedule.strays[number] * len(state.local)
        if void:
            lists = rebuilt(state, lists, walls, schedule.skin[number])
            rebuilds += 1
            void = False
        worst = sweep(state, lists, walls.features, pace, push)
        calm = not schedule.sinking[number] and not worst > schedule.calm
        looking = calm or schedule.limit[number] < math.inf
        number += 1
    if looking:
        place_members(state)
        lists = rebuilt(state, lists, walls, schedule.skin[number - 1])
        rebuilds += 1
    return plain(lists), number, rebuilds, looking


@loop
def blame(  # type: ignore[no-untyped-def]
    state: RigidState, lists: RigidLists, features: Features, down: NDArray[np.float64], scale: float
):
    """Blame each overlap on one body: the smaller of two, else the higher; the one in the wall.

    Args:
        state: The layer, its spheres at their places and its lists new.
        lists: What is near its spheres.
        features: The walls.
        down: Unit vector along which things fall, shape (3,).
        scale: True radius over arranged radius.

    Returns:
        (largest overlap as a fraction of the smaller true radius; what each body is blamed for, (B,)).
    """
    blamed, worst = np.zeros(len(state.centre)), 0.0
    height = np.empty(len(state.centre))
    for b in range(len(height)):
        height[b] = -(
            state.centre[b, 0] * down[0] + state.centre[b, 1] * down[1] + state.centre[b, 2] * down[2]
        )
    owner, neighbor = lists.pairs
    for k in range(len(owner)):
        depth = depth_of(state.ball, owner[k], neighbor[k], (0.0, 0.0, 0.0), scale)
        if depth > 0.0:
            worst = max(worst, depth)
            b = to_blame(state, height, owner[k], neighbor[k])
            blamed[b] = max(blamed[b], depth)
    first, second, offset = lists.seam
    for k in range(len(first)):
        beyond = (offset[k, 0], offset[k, 1], offset[k, 2])
        depth = depth_of(state.ball, first[k], second[k], beyond, scale)
        if depth > 0.0:
            worst = max(worst, depth)
            b = to_blame(state, height, first[k], second[k])
            blamed[b] = max(blamed[b], depth)
    for i in range(len(state.local)):
        depth = depth_in_walls(state.ball, i, lists, features, scale)
        worst = max(worst, depth)
        blamed[state.owner[i]] = max(blamed[state.owner[i]], depth)
    return worst, blamed


@inlined
def depth_of(
    ball: NDArray[np.float64], i: int, j: int, offset: tuple[float, float, float], scale: float
) -> float:
    """Return the overlap of two spheres, the second shifted, over the smaller true radius; at least 0."""
    dx = ball[i, 0] - (ball[j, 0] + offset[0])
    dy = ball[i, 1] - (ball[j, 1] + offset[1])
    dz = ball[i, 2] - (ball[j, 2] + offset[2])
    one, other = scale * ball[i, 3], scale * ball[j, 3]
    reach = one + other
    square = dx * dx + dy * dy + dz * dz
    depth = 0.0
    if square < reach * reach:
        depth = (reach - math.sqrt(square)) / min(one, other)
    return depth


@inlined
def to_blame(state: RigidState, height: NDArray[np.float64], i: int, j: int) -> int:
    """Return which of the bodies of two spheres has to go: it moves, is the smaller, else the higher."""
    a, b = state.owner[i], state.owner[j]
    blamed = a
    fixed = len(height)
    if a == fixed:
        blamed = b
    elif b != fixed and not state.size[a] < 0.6 * state.size[b]:
        blamed = b if state.size[b] < 0.6 * state.size[a] or height[b] > height[a] else a
    return int(blamed)


@inner_loop
def depth_in_walls(
    ball: NDArray[np.float64], i: int, lists: RigidLists, features: Features, scale: float
) -> float:
    """Return how deep a sphere is in a wall, over its true radius; at least 0."""
    kind, row = features
    begin, item, _ = lists.near
    depth, radius = 0.0, scale * ball[i, 3]
    for k in range(begin[i], begin[i + 1]):
        feature = item[k]
        if not out_of_reach(kind[feature], row[feature], ball[i, 0], ball[i, 1], ball[i, 2], radius):
            gap = wall_gap(kind[feature], row[feature], ball[i, 0], ball[i, 1], ball[i, 2], radius)[0]
            depth = max(depth, -gap / radius)
    return depth
