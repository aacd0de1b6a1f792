"""What is near the spheres of a layer of bodies: pairs of two bodies, across seams too, and walls."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.list_kernels import Pairs
from packgen.arrange.neighbors.listing import list_pairs
from packgen.arrange.neighbors.seam_pairs import SeamPairs, seam_pairs
from packgen.arrange.projection.push_kernels import rows_of
from packgen.arrange.rigid.pose_kernels import place_members
from packgen.arrange.rigid.state import RigidLists, RigidState
from packgen.arrange.space.map_kernels import WallList
from packgen.arrange.space.seams import Seams, is_periodic, wrapped_coordinate
from packgen.arrange.space.walls import WallTable, walls_in_reach
from packgen.compiled import inlined, inner_loop


@inner_loop
def wrap_bodies(state: RigidState, seams: Seams) -> None:
    """Move bodies by whole periods until their centres are in the box; their spheres go with them."""
    centre, (low, period) = state.centre, seams
    for b in range(len(centre)):
        for axis in range(3):
            centre[b, axis] = wrapped_coordinate(centre[b, axis], low[axis], period[axis])
    place_members(state)


@inner_loop
def wrapped_spheres(state: RigidState, seams: Seams):  # type: ignore[no-untyped-def]
    """Return all spheres moved into the box, (N + F, 4), and what takes them back [m], (N + F, 3)."""
    own, (low, period) = state.ball, seams
    ball, back = own.copy(), np.zeros((len(own), 3))
    for i in range(len(ball)):
        for axis in range(3):
            ball[i, axis] = wrapped_coordinate(own[i, axis], low[axis], period[axis])
            back[i, axis] = own[i, axis] - ball[i, axis]
    return ball, back


@inner_loop
def margins(state: RigidState, skin: float) -> NDArray[np.float64]:
    """Return how far each sphere may move while the lists hold [m], shape (N,); see ``list_reach``."""
    margin, first, size = np.empty(len(state.local)), state.first, state.size
    for b in range(len(size)):
        own = 0.5 * skin * math.sqrt(state.reference * size[b])
        for i in range(first[b], first[b + 1]):
            margin[i] = own
    return margin


@inlined
def are_beside(back: NDArray[np.float64], i: int, j: int) -> bool:
    """Tell whether two spheres are as many periods away from their places in the box."""
    return bool(back[i, 0] == back[j, 0] and back[i, 1] == back[j, 1] and back[i, 2] == back[j, 2])


@inner_loop
def across_seams(  # type: ignore[no-untyped-def]
    state: RigidState, back: NDArray[np.float64], pairs: Pairs, seam: SeamPairs
):
    """Return the arrays of the ``SeamPairs`` of two bodies, by the spheres' own places, maybe beyond the box.

    Args:
        state: The layer.
        back: What takes spheres of the box to their own places [m], shape (N + F, 3).
        pairs: The pairs that are close in the box.
        seam: The pairs that are close across its seams.
    """
    owner, most = state.owner, len(pairs.owner) + len(seam.first)
    first, second, offset = np.empty(most, np.int32), np.empty(most, np.int32), np.empty((most, 3))
    count = 0
    for k in range(most):
        within = k < len(pairs.owner)
        i = pairs.owner[k] if within else seam.first[k - len(pairs.owner)]
        j = pairs.neighbor[k] if within else seam.second[k - len(pairs.owner)]
        if owner[i] == owner[j] or (within and are_beside(back, i, j)):
            continue
        first[count], second[count] = i, j
        for axis in range(3):
            across = 0.0 if within else seam.offset[k - len(pairs.owner), axis]
            offset[count, axis] = across + back[i, axis] - back[j, axis]
        count += 1
    return first[:count].copy(), second[:count].copy(), offset[:count].copy()


@inner_loop
def rebuilt(state: RigidState, lists: RigidLists, walls: WallTable, skin: float):  # type: ignore[no-untyped-def]
    """Return the lists made anew; where space wraps around bodies are moved into the box first."""
    moving, seams = len(state.local), walls.seams
    periodic = is_periodic(seams.period)
    ball, back = state.ball, np.zeros((0, 3))
    if periodic:
        wrap_bodies(state, seams)
        ball, back = wrapped_spheres(state, seams)
    margin = margins(state, skin)
    reach = ball[:, 3].copy()
    reach[:moving] += margin
    order, _, (owner, neighbor) = list_pairs(ball, reach, moving, lists.room)
    room = neighbor
    seam = SeamPairs(owner[:0], owner[:0], np.empty((0, 3)))
    for k in range(len(owner)):
        owner[k], neighbor[k] = order[owner[k]], order[neighbor[k]]
    if periodic:
        first, second, offset = seam_pairs(ball, reach, moving, seams)
        near = Pairs(owner, neighbor)
        first, second, offset = across_seams(state, back, near, SeamPairs(first, second, offset))
        seam = SeamPairs(first, second, offset)
    count, body = 0, state.owner
    for k in range(len(owner)):
        i, j = owner[k], neighbor[k]
        owner[count], neighbor[count] = i, j
        apart = body[i] != body[j]
        count += apart and not (periodic and not are_beside(back, i, j))
    pairs = Pairs(owner[:count].copy(), neighbor[:count].copy())
    anchor = state.ball[:moving].copy()
    begin, item, gaps = walls_in_reach(anchor, margin, walls, lists.near)
    near_walls = WallList(begin, item, gaps)
    return RigidLists(pairs, rows_of(pairs.owner), seam, near_walls, anchor, margin, room)
