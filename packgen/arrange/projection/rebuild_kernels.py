"""The lists of a layer made anew: spheres sorted by cell, and what is near the own spheres of each thread."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.list_kernels import Pairs, SortedSpheres
from packgen.arrange.neighbors.listing import cell_order, pair_owners, pairs_of
from packgen.arrange.neighbors.seam_pairs import SeamPairs, chosen_seam_pairs, seam_pairs
from packgen.arrange.projection.pair_rules import list_reach, pairs_to_part, push_weight
from packgen.arrange.projection.push_kernels import rows_of
from packgen.arrange.projection.ranks import closed_ranks
from packgen.arrange.projection.shares import (
    PACE,
    Team,
    exchanged,
    has_own,
    own_spheres,
    paced,
    stripes,
)
from packgen.arrange.projection.sweep_kernels import Anchor, LayerState, Lists, Now, Work
from packgen.arrange.space.map_kernels import WallList
from packgen.arrange.space.seams import is_periodic
from packgen.arrange.space.walls import WallTable, walls_in_reach
from packgen.compiled import inlined, inner_loop
from packgen.team import meet, share


@inner_loop
def ranks_closed(state: LayerState, now: Now, walls: WallTable, team: Team):  # type: ignore[no-untyped-def]
    """Forget the spheres that were taken out; return what counts then, of the same side."""
    if team.rank == 0:
        ball, previous, _ = closed_ranks(
            state.ball[now.side][: now.total],
            state.previous[now.side][: now.moving],
            state.identity[now.side][: now.moving],
            walls.seams,
        )
        team.known[0], team.known[1] = len(previous), len(ball)
        paced(team.ends, team.told[PACE, :, 0].copy(), team.told[PACE, :, 1].copy())
    meet(team.board, team.size)
    return Now(now.side, team.known[0], team.known[1])


@inner_loop
def rebuilt(  # type: ignore[no-untyped-def]
    state: LayerState, now: Now, lists: Lists, walls: WallTable, skin: float, team: Team
):
    """Sort the spheres of a layer by cell and list the neighbours and walls of the own ones anew.

    Each thread finds the whole order, which is quick, and moves its part of the arrays.

    Args:
        state: The layer.
        now: What counts of it.
        lists: The lists before, whose arrays are written over.
        walls: The walls.
        skin: See ``list_reach``.
        team: The threads.

    Returns:
        (what counts, the lists).
    """
    now = ranks_closed(state, now, walls, team)
    moving, ball = now.moving, state.ball[now.side][: now.total]
    reach = list_reach(ball, moving, skin, state.reference)
    order, level, grids, starts = cell_order(ball, reach, moving)
    begin, end = share(now.total, team.rank, team.size)
    sort_part(state, now, order, grids.box[6], begin, end)
    sorted_reach, sorted_level = np.empty(now.total), np.empty(now.total, np.int8)
    for i in range(now.total):
        sorted_reach[i], sorted_level[i] = reach[order[i]], level[order[i]]
    now = Now(1 - now.side, moving, now.total)
    meet(team.board, team.size)
    ball, identity = state.ball[now.side][: now.total], state.identity[now.side][:moving]
    stripe = stripes(ball, moving, grids.box, team.ends)
    own = own_spheres(stripe, team.rank, moving)
    owners = pair_owners(stripe, team.rank, moving, now.total, len(grids.size))
    spheres = SortedSpheres(ball, sorted_reach, sorted_level)
    owner, neighbor = pairs_of(spheres, moving, grids, starts, owners, lists.work.room)
    pairs, seam, room = Pairs(owner, neighbor), lists.seam, neighbor
    if is_periodic(walls.seams.period):
        first, second, offset = seam_pairs(ball, sorted_reach, moving, walls.seams)
        own_ones = has_own(first, second, stripe, moving, team.rank)
        first, second, offset = chosen_seam_pairs(SeamPairs(first, second, offset), own_ones)
        seam = SeamPairs(first, second, offset)
    if len(state.body):
        pairs, seam = of_two_bodies(pairs, seam, state.body, identity)
    owner, neighbor = exchanged(pairs, stripe, moving, team)
    pairs = Pairs(owner, neighbor)
    near, anchor = own_walls(ball, own, sorted_reach, walls, lists.near)
    team.told[PACE, team.rank, 0], team.told[PACE, team.rank, 1] = len(own), 0.0
    one, other = np.empty(len(owner) + 1, np.int32), np.empty(len(owner) + 1, np.int32)
    turned = np.zeros((state.travel.shape[1] and now.total, 3))
    work = Work(rows_of(owner), one, other, np.zeros((now.total, 3)), turned, room)
    return now, Lists(own, pairs, seam, near, anchor, work)


@inner_loop
def sort_part(
    state: LayerState, now: Now, order: NDArray[np.int64], largest: float, begin: int, end: int
) -> None:
    """Write a part of the spheres in the order of their cells to the other side of the arrays."""
    ball, previous, identity = state.ball[now.side], state.previous[now.side], state.identity[now.side]
    other = 1 - now.side
    for i in range(begin, end):
        place = order[i]
        for axis in range(4):
            state.ball[other, i, axis] = ball[place, axis]
            state.ahead[0, i, axis] = ball[place, axis]
            state.ahead[1, i, axis] = ball[place, axis]
        if state.travel.shape[1] > 0:
            # How they turned is forgotten: lists last for twenty sweeps.
            state.travel[:, i] = 0.0
            state.spin[:, i] = 0.0
        state.weight[i] = push_weight(ball[place, 3], i < now.moving, largest, state.reference)
        if i < now.moving:
            state.identity[other, i] = identity[place]
            for axis in range(3):
                state.previous[other, i, axis] = previous[place, axis]


@inner_loop
def own_walls(  # type: ignore[no-untyped-def]
    ball: NDArray[np.float64],
    own: NDArray[np.int32],
    reach: NDArray[np.float64],
    walls: WallTable,
    before: WallList,
):
    """Return the walls near the own spheres, and for how long these lists hold."""
    balls = np.empty((len(own), 4))
    anchor = Anchor(np.empty((len(own), 3)), np.empty(len(own)))
    for each in range(len(own)):
        i = own[each]
        balls[each, 3], anchor.margin[each] = ball[i, 3], reach[i] - ball[i, 3]
        for axis in range(3):
            balls[each, axis] = anchor.center[each, axis] = ball[i, axis]
    begin, item, room = walls_in_reach(balls, anchor.margin, walls, before)
    return WallList(begin, item, room), anchor


@inlined
def of_two_bodies(  # type: ignore[no-untyped-def]
    pairs: Pairs, seam: SeamPairs, body: NDArray[np.int64], identity: NDArray[np.int64]
):
    """Return the pairs without those of one body, whose spheres may overlap each other."""
    owner, neighbor = pairs
    apart = pairs_to_part(owner, neighbor, body, identity)
    count = 0
    for k in range(len(apart)):
        owner[count], neighbor[count] = owner[k], neighbor[k]
        count += apart[k]
    first, second, offset = seam
    first, second, offset = chosen_seam_pairs(seam, pairs_to_part(first, second, body, identity))
    return Pairs(owner[:count], neighbor), SeamPairs(first, second, offset)
