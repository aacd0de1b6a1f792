"""A whole layer in one loop: lists, sweeps, overlaps, and who is thrown back, with no Python in between."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.list_kernels import Pairs
from packgen.arrange.neighbors.listing import list_pairs
from packgen.arrange.neighbors.seam_pairs import SeamPairs, seam_pairs
from packgen.arrange.projection.pair_rules import (
    list_reach,
    pairs_to_part,
    push_weights,
    with_their_bodies,
)
from packgen.arrange.projection.ranks import closed_ranks
from packgen.arrange.projection.recipe import Schedule, Step
from packgen.arrange.projection.sweep_kernels import (
    Anchor,
    LayerSpheres,
    Lists,
    Work,
    sphere_overlaps,
    sweep,
)
from packgen.arrange.projection.throw_back import spheres_to_go
from packgen.arrange.space.map_kernels import WallList
from packgen.arrange.space.seams import is_periodic, wrapped_coordinate
from packgen.arrange.space.walls import WallTable, walls_in_reach
from packgen.compiled import inlined, inner_loop, loop


@inner_loop
def rebuilt(  # type: ignore[no-untyped-def]
    spheres: LayerSpheres, lists: Lists, walls: WallTable, skin: float
):
    """Sort the spheres of a layer by cell and list their neighbours and walls anew.

    Args:
        spheres: The spheres; their arrays change.
        lists: The lists before, whose arrays are written over.
        walls: The walls.
        skin: See ``list_reach``.

    Returns:
        (the spheres that are left, the lists).
    """
    ball, previous, identity = closed_ranks(spheres.ball, spheres.previous, spheres.identity, walls.seams)
    moving = len(previous)
    reach = list_reach(ball, moving, skin, spheres.reference)
    order, (ball, reach, _), (owner, neighbor) = list_pairs(ball, reach, moving, lists.pairs.neighbor)
    pairs = Pairs(owner, neighbor)
    seam = lists.seam
    if is_periodic(walls.seams.period):
        first, second, offset = seam_pairs(ball, reach, moving, walls.seams)
        seam = SeamPairs(first, second, offset)
    former, place = np.empty((moving, 3)), np.empty(moving, np.int64)
    for i in range(moving):
        place[i] = identity[order[i]]
        for axis in range(3):
            former[i, axis] = previous[order[i], axis]
    weight = push_weights(ball, moving, spheres.reference)
    spheres = LayerSpheres(ball, former, weight, place, spheres.body, spheres.reference)
    if len(spheres.body):
        pairs, seam = of_two_bodies(pairs, seam, spheres)
    anchor = Anchor(np.empty((moving, 3)), np.empty(moving))
    for i in range(moving):
        anchor.margin[i] = reach[i] - ball[i, 3]
        for axis in range(3):
            anchor.center[i, axis] = ball[i, axis]
    begin, item, room = walls_in_reach(ball, anchor.margin, walls, lists.near)
    near = WallList(begin, item, room)
    work = Work(np.empty(len(pairs.owner) + 1, np.int32), np.empty((len(ball), 3)))
    return spheres, Lists(pairs, seam, near, anchor, work)


@inlined
def of_two_bodies(  # type: ignore[no-untyped-def]
    pairs: Pairs, seam: SeamPairs, spheres: LayerSpheres
):
    """Return the pairs without those of one body, whose spheres may overlap each other."""
    owner, neighbor = pairs
    apart = pairs_to_part(owner, neighbor, spheres.body, spheres.identity)
    count = 0
    for k in range(len(apart)):
        owner[count], neighbor[count] = owner[k], neighbor[k]
        count += apart[k]
    first, second, offset = seam
    apart = pairs_to_part(first, second, spheres.body, spheres.identity)
    across = 0
    for k in range(len(apart)):
        first[across], second[across] = first[k], second[k]
        for axis in range(3):
            offset[across, axis] = offset[k, axis]
        across += apart[k]
    return Pairs(owner[:count], neighbor), SeamPairs(first[:across], second[:across], offset[:across])


@inner_loop
def thrown_back(
    spheres: LayerSpheres, walls: WallTable, blame: NDArray[np.float64], limit: float, share: float
) -> int:
    """Take spheres out that overlap by more than a limit, and with each its whole body.

    Args:
        spheres: The spheres; the centres of those that are taken out become NaN.
        walls: The walls.
        blame: Overlap that each moving sphere is blamed for, as a fraction of the smaller radius, (moving,).
        limit: Overlap above which a sphere has to go.
        share: Largest share of the moving spheres that goes.

    Returns:
        How many were taken out.
    """
    moving = len(spheres.previous)
    low, period = walls.seams
    ball = np.empty((moving, 4))
    for i in range(moving):
        for axis in range(3):
            ball[i, axis] = wrapped_coordinate(spheres.ball[i, axis], low[axis], period[axis])
        ball[i, 3] = spheres.ball[i, 3]
    chosen = spheres_to_go(ball, blame, limit, math.ceil(share * moving))
    chosen = with_their_bodies(chosen, spheres.body, spheres.identity)
    count = 0
    for i in range(moving):
        if chosen[i]:
            # NaN compares false: never in contact, never counted as having outrun the list.
            for axis in range(3):
                spheres.ball[i, axis] = math.nan
            count += 1
    return count


@inner_loop
def any_left(spheres: LayerSpheres) -> bool:
    """Tell whether any moving sphere is not taken out."""
    for i in range(len(spheres.previous)):
        if not math.isnan(spheres.ball[i, 0]):
            return True
    return False


@inlined
def plain(spheres: LayerSpheres, lists: Lists):  # type: ignore[no-untyped-def]
    """Return spheres and lists as tuples without names, which alone a loop may give back to Python."""
    ball, previous, weight, identity, body, reference = spheres
    (owner, neighbor), (first, second, offset), (begin, item, room), (center, margin), work = lists
    touching, shift = work
    return (
        (ball, previous, weight, identity, body, reference),
        (
            (owner, neighbor),
            (first, second, offset),
            (begin, item, room),
            (center, margin),
            (touching, shift),
        ),
    )


@loop
def run_sweeps(  # type: ignore[no-untyped-def]
    spheres: LayerSpheres,
    lists: Lists,
    walls: WallTable,
    down: NDArray[np.float64],
    schedule: Schedule,
    strays: int,
):
    """Run the sweeps of a schedule with all that comes between them, as ``run_by_steps`` does one by one.

    Args:
        spheres: The spheres; their arrays change.
        lists: What is near them; their arrays change.
        walls: The walls.
        down: Unit vector along which things fall, shape (3,).
        schedule: What each sweep takes, S of them.
        strays: Spheres that have outrun the lists so far; all of them where there are no lists yet.

    Returns:
        ((the spheres that are left, their lists), what was done), see ``plain`` and ``Tally``.
    """
    rebuilds, thrown, number, sink = 0, 0, 0, np.empty(3)
    looking = done = False
    while not done and (looking or number < len(schedule.fall)):
        at = number - looking
        void = strays > 0 and not schedule.sinking[at]
        if not looking:
            void = strays > schedule.strays[at] * len(spheres.previous)
        if void:
            spheres, lists = rebuilt(spheres, lists, walls, schedule.skin[at])
            rebuilds += 1
        if looking:
            looking = False
            strays = 0 if void else strays
            largest, blame = sphere_overlaps(spheres, lists, walls.features, down, schedule.scale)
            done, limit = largest <= schedule.least and not schedule.sinking[at], schedule.limit[at]
            if not done and limit < math.inf:
                thrown += thrown_back(spheres, walls, blame, max(limit, schedule.least), schedule.throw_share)
                # An empty layer has no neighbour list.
                done = not any_left(spheres)
            continue
        fall = spheres.reference * schedule.fall[number]
        for axis in range(3):
            sink[axis] = down[axis] * fall
        step = Step(
            schedule.momentum[number],
            schedule.relaxation,
            schedule.stride,
            schedule.roughness[number],
            schedule.far[number],
        )
        worst, strays = sweep(spheres, lists, walls.features, sink, step)
        number += 1
        calm = not schedule.sinking[at] and not worst > schedule.calm
        looking = calm or schedule.limit[at] < math.inf
    return plain(spheres, lists), (number, rebuilds, thrown, strays, done)


@loop
def rebuilt_plain(  # type: ignore[no-untyped-def]
    spheres: LayerSpheres, lists: Lists, walls: WallTable, skin: float
):
    """Do what ``rebuilt`` does; see ``plain``."""
    spheres, lists = rebuilt(spheres, lists, walls, skin)
    return plain(spheres, lists)
