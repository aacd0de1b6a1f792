"""The contact sweep: every overlapping pair is pushed apart, every sphere back inside its walls, all at once.

One sweep is a Jacobi step of position-based dynamics (Mueller et al., J. Vis. Commun. Image R. 18 (2007)
109): each sphere moves by the sum of its overlaps along their normals, shared in inverse proportion to the
masses, from a position extrapolated by momentum.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.list_kernels import Pairs
from packgen.arrange.neighbors.seam_pairs import SeamPairs
from packgen.arrange.projection.friction_kernels import Rubbing, rub_pairs
from packgen.arrange.projection.pair_rules import GRAIN_PUSH, GRAIN_STEP
from packgen.arrange.projection.push_kernels import (
    blame_pairs,
    push_pairs,
    push_seam_pairs,
    touching_pairs,
)
from packgen.arrange.projection.recipe import Step
from packgen.arrange.space.feature_kernels import Features, out_of_reach, wall_gap
from packgen.arrange.space.map_kernels import WallList
from packgen.compiled import inlined, inner_loop


class LayerState(NamedTuple):
    """The spheres of a layer, which the threads that arrange it share; the first ones move.

    Arrays of two sides hold what is sorted, or moved, from one side to the other. In each the first entries
    count, as many as are left of N spheres, M of which moved at first.

    Attributes:
        ball: Centres and arranged radii [m], shape (2, N, 4), float64.
        previous: Centres of the moving ones one sweep ago [m], shape (2, M, 3), float64.
        identity: Place of each moving sphere in the order given, by which it meets its own grain of a rough
            wall, shape (2, M), int64.
        ahead: Where a sweep takes the spheres before it parts them, and their radii [m], shape (2, N, 4),
            float64.
        weight: Weight of each sphere in a push, shape (N,), float64; see ``push_weights``.
        blame: Overlap that each moving sphere is blamed for, as a fraction of the smaller radius, (M,).
        travel: How far a sweep takes each sphere before it parts them [m], shape (2, N, 3), float64; of no
            sphere where they rub not.
        spin: How far each turned in the last sweep [rad], likewise.
        body: Body of each sphere that moved at first, in the order given, int64; empty: each is a body.
        reference: Mean radius of the spheres that moved at first [m].
    """

    ball: NDArray[np.float64]
    previous: NDArray[np.float64]
    identity: NDArray[np.int64]
    ahead: NDArray[np.float64]
    weight: NDArray[np.float64]
    blame: NDArray[np.float64]
    travel: NDArray[np.float64]
    spin: NDArray[np.float64]
    body: NDArray[np.int64]
    reference: float


class Now(NamedTuple):
    """Which entries of a layer's arrays count.

    Attributes:
        side: Side of ``ball``, ``previous`` and ``identity``.
        moving: Spheres that move; those taken out count until the next rebuild.
        total: Spheres, fixed ones included.
    """

    side: int
    moving: int
    total: int


class Anchor(NamedTuple):
    """For how long the lists of a layer hold.

    Attributes:
        center: Centres of the own spheres when the lists were made [m], shape (own, 3), float64.
        margin: They hold while no sphere has moved further than this [m], shape (own,), float64.
    """

    center: NDArray[np.float64]
    margin: NDArray[np.float64]


class Work(NamedTuple):
    """Work space of a sweep over N spheres and P pairs.

    Attributes:
        rows: Where the pairs of each owner begin; see ``rows_of``; int32.
        one: For the owners of the pairs that overlap, shape (P + 1,), int32.
        other: For their other spheres, likewise.
        shift: For the pushes on each sphere [m], shape (N, 3), float64.
        turned: For the turns of each sphere [rad], shape (N, 3), float64; of none where they rub not.
        room: For the neighbour list, int32.
    """

    rows: NDArray[np.int32]
    one: NDArray[np.int32]
    other: NDArray[np.int32]
    shift: NDArray[np.float64]
    turned: NDArray[np.float64]
    room: NDArray[np.int32]


class Lists(NamedTuple):
    """What is near the moving spheres of one thread until one of them has moved too far.

    Attributes:
        own: These spheres, rising, shape (own,), int32.
        pairs: The listed pairs with any of them, in the order of the whole layer's.
        seam: The pairs with any of them that are close across a seam.
        near: The walls that each own sphere can reach.
        anchor: For how long these lists hold.
        work: Work space of the sweeps over them.
    """

    own: NDArray[np.int32]
    pairs: Pairs
    seam: SeamPairs
    near: WallList
    anchor: Anchor
    work: Work


class Motion(NamedTuple):
    """How a sweep moves the spheres, and where the next one takes them.

    Attributes:
        turn: Side of ``ahead`` where the spheres are.
        turn_next: Side to which the sweep takes its own spheres for the next; the same where there is but one
            thread, and no other still looks at it.
        sink: Displacement that has led there [m], shape (3,).
        step: How the spheres move.
        sink_next: Displacement before the next sweep [m], shape (3,).
        momentum_next: Momentum of the next sweep.
    """

    turn: int
    turn_next: int
    sink: NDArray[np.float64]
    step: Step
    sink_next: NDArray[np.float64]
    momentum_next: float


@inlined
def wall_grain(identity: int) -> float:
    """Return the part of a wall's roughness that keeps a sphere off, 0 to 1: the golden ratio's multiples."""
    return identity * GRAIN_STEP % 1.0


@inner_loop
def look_ahead(
    state: LayerState,
    now: Now,
    own: NDArray[np.int32],
    turn: int,
    sink: NDArray[np.float64],
    momentum: float,
) -> None:
    """Take the own spheres to where a sweep parts them: sunk, and extrapolated by momentum.

    Args:
        state: The layer.
        now: What counts of it.
        own: The own spheres.
        turn: Side of ``ahead`` to write.
        sink: Displacement before the sweep [m], shape (3,).
        momentum: Share of the last displacement that is added again.
    """
    ball, previous, ahead = state.ball[now.side], state.previous[now.side], state.ahead[turn]
    for i in own:
        for axis in range(3):
            sunk = ball[i, axis] + sink[axis]
            ahead[i, axis] = sunk + momentum * (sunk - previous[i, axis])
            if state.travel.shape[1] > 0:
                state.travel[turn, i, axis] = ahead[i, axis] - ball[i, axis]


@inner_loop
def sweep(state: LayerState, now: Now, lists: Lists, features: Features, motion: Motion):  # type: ignore[no-untyped-def]
    """Push the own spheres apart and put them back inside the walls, once.

    Args:
        state: The layer; centres, and those one sweep ago, of the own spheres change.
        now: What counts of it.
        lists: What is near the own spheres.
        features: The walls.
        motion: How they move.

    Returns:
        (largest pair overlap as a fraction of the smaller radius, spheres that have outrun the list; a sphere
        that has by ``step.far`` margins adds ``moving`` to the count, which forces a rebuild).
    """
    own, pairs, seam, _, _, (rows, one, other, shift, _, _) = lists
    ahead = state.ahead[motion.turn]
    for i in own:
        shift[i, 0] = 0.0
        shift[i, 1] = 0.0
        shift[i, 2] = 0.0
    count = touching_pairs(ahead, pairs, rows, one, other)
    worst = push_pairs(ahead, state.weight, one[:count], other[:count], shift)
    worst = max(worst, push_seam_pairs(ahead, state.weight, seam, shift))
    rubs = motion.step.friction > 0.0
    if rubs:
        rub_all(state, lists, motion, count)
    strays = put_back(state, now, lists, features, motion)
    if rubs:
        carry_on(state, now, lists, motion)
    return worst, strays


@inner_loop
def rub_all(state: LayerState, lists: Lists, motion: Motion, count: int) -> None:
    """Add the friction of the pairs that overlap to their pushes; see ``rub_pairs``.

    Args:
        state: The layer.
        lists: What is near the own spheres.
        motion: How they move.
        count: How many of the listed pairs overlap.
    """
    own, _, seam, _, _, (_, one, other, shift, turned, _) = lists
    for i in own:
        turned[i, 0] = 0.0
        turned[i, 1] = 0.0
        turned[i, 2] = 0.0
    turn, step = motion.turn, motion.step
    travel, spin = state.travel[turn], state.spin[turn]
    rubbing = Rubbing(travel, spin, turned, step.momentum, step.friction, step.grip)
    rub_pairs(state.ahead[turn], state.weight, rubbing, one[:count], other[:count], seam, shift)


@inner_loop
def carry_on(state: LayerState, now: Now, lists: Lists, motion: Motion) -> None:
    """Note how far the own spheres turned, and how far the next sweep takes them."""
    ball, further, turned = state.ball[now.side], state.ahead[motion.turn_next], lists.work.turned
    travel, spin = state.travel[motion.turn_next], state.spin[motion.turn_next]
    before, momentum = state.spin[motion.turn], motion.step.momentum
    for i in lists.own:
        for axis in range(3):
            spin[i, axis] = momentum * before[i, axis] + turned[i, axis]
            travel[i, axis] = further[i, axis] - ball[i, axis]


@inner_loop
def put_back(state: LayerState, now: Now, lists: Lists, features: Features, motion: Motion) -> int:
    """Move the own spheres by their pushes, and put them back inside the walls; see ``sweep``.

    Returns:
        Spheres that have outrun the list.
    """
    turn, turn_next, sink, step, sink_next, momentum_next = motion
    ball, previous, identity = state.ball[now.side], state.previous[now.side], state.identity[now.side]
    ahead, further = state.ahead[turn], state.ahead[turn_next]
    own, _, _, (wall_begin, wall_item, wall_room), (center, margin), work = lists
    kind, row = features
    _, relaxation, stride, roughness, far, _, _ = step
    shift = work.shift
    sink_x, sink_y, sink_z = sink[0], sink[1], sink[2]
    next_x, next_y, next_z = sink_next[0], sink_next[1], sink_next[2]
    strays = 0
    for each in range(len(own)):
        i = np.uint64(own[each])
        radius = ahead[i, 3]
        sx = relaxation * shift[i, 0]
        sy = relaxation * shift[i, 1]
        sz = relaxation * shift[i, 2]
        square = sx * sx + sy * sy + sz * sz
        limit = stride * radius
        if square > limit * limit:
            shorten = limit / math.sqrt(square)
            sx *= shorten
            sy *= shorten
            sz *= shorten
        x, y, z = ahead[i, 0] + sx, ahead[i, 1] + sy, ahead[i, 2] + sz
        # Where several walls meet, putting back from one may push into the next: go round twice.
        rounds = 0 if math.isnan(x) else min(wall_begin[each + 1] - wall_begin[each], 2)
        travel, keep_off, gentle = 0.0, 0.0, GRAIN_PUSH * radius
        if rounds > 0:
            dx = x - center[each, 0]
            dy = y - center[each, 1]
            dz = z - center[each, 2]
            travel = math.sqrt(dx * dx + dy * dy + dz * dz) + 1e-9 * radius
            keep_off = roughness * radius * wall_grain(identity[i])
        for _ in range(rounds):
            pushed = False
            for k in range(wall_begin[each], wall_begin[each + 1]):
                # No gap shrinks by more than the sphere moves: most features are still out of touch.
                if wall_room[k] > travel + keep_off:
                    continue
                feature = wall_item[k]
                if out_of_reach(kind[feature], row[feature], x, y, z, radius + keep_off):
                    continue
                gap, nx, ny, nz = wall_gap(kind[feature], row[feature], x, y, z, radius)
                if gap < keep_off:
                    rough = min(keep_off - max(gap, 0.0), gentle)
                    gentle -= rough
                    push = max(-gap, 0.0) + rough
                    x += push * nx
                    y += push * ny
                    z += push * nz
                    travel += push
                    pushed = True
                    if gentle <= 0.0:
                        keep_off = 0.0  # what is left is to be put back inside, by fewer walls
            if not pushed:
                break
        before_x, before_y, before_z = ball[i, 0] + sink_x, ball[i, 1] + sink_y, ball[i, 2] + sink_z
        previous[i, 0], previous[i, 1], previous[i, 2] = before_x, before_y, before_z
        ball[i, 0], ball[i, 1], ball[i, 2] = x, y, z
        dx = x - center[each, 0]
        dy = y - center[each, 1]
        dz = z - center[each, 2]
        square, allowed = dx * dx + dy * dy + dz * dz, margin[each] * margin[each]
        if square > allowed:
            strays += 1
            if square > far * far * allowed:
                strays += now.moving
        x, y, z = x + next_x, y + next_y, z + next_z
        further[i, 0] = x + momentum_next * (x - before_x)
        further[i, 1] = y + momentum_next * (y - before_y)
        further[i, 2] = z + momentum_next * (z - before_z)
    return strays


@inner_loop
def blame_own(
    state: LayerState,
    now: Now,
    lists: Lists,
    features: Features,
    down: NDArray[np.float64],
    scale: float,
) -> float:
    """Blame each overlap on one moving sphere: the smaller of a pair, else the higher; the one in the wall.

    Args:
        state: The layer; what its own spheres are blamed for is written to ``blame``.
        now: What counts of it.
        lists: What is near the own spheres.
        features: The walls.
        down: Unit vector along which things fall, shape (3,).
        scale: True radius over arranged radius.

    Returns:
        The largest overlap as a fraction of the smaller true radius.
    """
    ball, moving = state.ball[now.side][: now.total], now.moving
    wall_begin, wall_item, _ = lists.near
    kind, row = features
    height, overlap = np.zeros(moving), np.zeros(moving)
    for axis in range(3):
        for i in range(moving if down[axis] != 0.0 else 0):
            height[i] -= ball[i, axis] * down[axis]
    worst = blame_pairs(ball, scale, lists.pairs, lists.seam, height, overlap)
    for each in range(len(lists.own)):
        i = lists.own[each]
        radius = scale * ball[i, 3]
        for k in range(wall_begin[each], wall_begin[each + 1]):
            feature = wall_item[k]
            if math.isnan(ball[i, 0]):
                break
            if out_of_reach(kind[feature], row[feature], ball[i, 0], ball[i, 1], ball[i, 2], radius):
                continue
            gap = wall_gap(kind[feature], row[feature], ball[i, 0], ball[i, 1], ball[i, 2], radius)[0]
            if gap < 0.0:
                overlap[i] = max(overlap[i], -gap / radius)
                worst = max(worst, -gap / radius)
        state.blame[i] = overlap[i]
    return worst
