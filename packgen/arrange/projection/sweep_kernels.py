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
from packgen.compiled import inlined, loop


class LayerSpheres(NamedTuple):
    """The spheres of a layer; the first ones move.

    Attributes:
        ball: Centres and arranged radii [m], shape (N, 4), float64.
        previous: Centres of the moving ones one sweep ago [m], shape (moving, 3), float64.
        weight: Weight of each sphere in a push, shape (N,), float64; see ``push_weights``.
        identity: Place of each moving sphere in the order given, by which it meets its own grain of a rough
            wall, shape (moving,), int64.
        body: Body of each sphere that moved at first, in the order given, int64; empty: each is a body.
        reference: Mean radius of the spheres that moved at first [m].
    """

    ball: NDArray[np.float64]
    previous: NDArray[np.float64]
    weight: NDArray[np.float64]
    identity: NDArray[np.int64]
    body: NDArray[np.int64]
    reference: float


class Anchor(NamedTuple):
    """For how long the lists of a layer hold.

    Attributes:
        center: Centres of the moving spheres when the lists were made [m], shape (moving, 3), float64.
        margin: They hold while no sphere has moved further than this [m], shape (moving,), float64.
    """

    center: NDArray[np.float64]
    margin: NDArray[np.float64]


class Work(NamedTuple):
    """Work space of a sweep over N spheres and P pairs.

    Attributes:
        touching: For the pairs that overlap, shape (P + 1,) or longer, int32.
        shift: For the pushes on each sphere [m], shape (N, 3), float64.
    """

    touching: NDArray[np.int32]
    shift: NDArray[np.float64]


class Lists(NamedTuple):
    """What is near each sphere of a layer until one of them has moved too far.

    Attributes:
        pairs: The listed pairs.
        seam: The pairs that are close across a seam.
        near: The walls that each moving sphere can reach.
        anchor: For how long these lists hold.
        work: Work space of the sweeps over them.
    """

    pairs: Pairs
    seam: SeamPairs
    near: WallList
    anchor: Anchor
    work: Work


@inlined
def wall_grain(identity: int) -> float:
    """Return the part of a wall's roughness that keeps a sphere off, 0 to 1: the golden ratio's multiples."""
    return identity * GRAIN_STEP % 1.0


@loop
def sweep(  # type: ignore[no-untyped-def]
    spheres: LayerSpheres,
    lists: Lists,
    features: Features,
    sink: NDArray[np.float64],
    step: Step,
):
    """Sink, extrapolate, push apart, and put back inside the walls, once.

    Args:
        spheres: The spheres; ``ball`` and ``previous`` of the moving ones change.
        lists: What is near them.
        features: The walls.
        sink: Displacement before the sweep [m], shape (3,).
        step: How the spheres move.

    Returns:
        (largest pair overlap as a fraction of the smaller radius, spheres that have outrun the list; a sphere
        that has by ``step.far`` margins adds ``moving`` to the count, which forces a rebuild).
    """
    ball, previous, weight, identity, _, _ = spheres
    pairs, seam, (wall_begin, wall_item, wall_room), (center, margin), (touching, shift) = lists
    kind, row = features
    momentum, relaxation, stride, roughness, far = step
    moving = len(previous)
    sink_x, sink_y, sink_z = sink[0], sink[1], sink[2]
    for i in range(moving):
        x, y, z = ball[i, 0] + sink_x, ball[i, 1] + sink_y, ball[i, 2] + sink_z
        ball[i, 0] = x + momentum * (x - previous[i, 0])
        ball[i, 1] = y + momentum * (y - previous[i, 1])
        ball[i, 2] = z + momentum * (z - previous[i, 2])
        previous[i, 0], previous[i, 1], previous[i, 2] = x, y, z
    count = touching_pairs(ball, pairs, touching)
    worst = push_pairs(ball, weight, pairs, touching[:count], shift)
    worst = max(worst, push_seam_pairs(ball, weight, seam, shift))
    strays = 0
    for i in range(moving):
        radius = ball[i, 3]
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
        x, y, z = ball[i, 0] + sx, ball[i, 1] + sy, ball[i, 2] + sz
        # Where several walls meet, putting back from one may push into the next: go round twice.
        rounds = 0 if math.isnan(x) else min(wall_begin[i + 1] - wall_begin[i], 2)
        travel, keep_off, gentle = 0.0, 0.0, GRAIN_PUSH * radius
        if rounds > 0:
            dx = x - center[i, 0]
            dy = y - center[i, 1]
            dz = z - center[i, 2]
            travel = math.sqrt(dx * dx + dy * dy + dz * dz) + 1e-9 * radius
            keep_off = roughness * radius * wall_grain(identity[i])
        for _ in range(rounds):
            pushed = False
            for k in range(wall_begin[i], wall_begin[i + 1]):
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
        ball[i, 0], ball[i, 1], ball[i, 2] = x, y, z
        dx = x - center[i, 0]
        dy = y - center[i, 1]
        dz = z - center[i, 2]
        square, allowed = dx * dx + dy * dy + dz * dz, margin[i] * margin[i]
        if square > allowed:
            strays += 1
            if square > far * far * allowed:
                strays += moving
    return worst, strays


@loop
def sphere_overlaps(
    spheres: LayerSpheres, lists: Lists, features: Features, down: NDArray[np.float64], scale: float
) -> tuple[float, NDArray[np.float64]]:
    """Blame each overlap on one moving sphere: the smaller of a pair, else the higher; the one in the wall.

    Args:
        spheres: The spheres.
        lists: What is near them.
        features: The walls.
        down: Unit vector along which things fall, shape (3,).
        scale: True radius over arranged radius.

    Returns:
        (largest overlap; the largest that each moving sphere is blamed for, shape (moving,)), as fractions of
        the smaller true radius.
    """
    ball = spheres.ball
    wall_begin, wall_item, _ = lists.near
    kind, row = features
    moving = len(spheres.previous)
    height, overlap = np.zeros(moving), np.zeros(moving)
    for axis in range(3):
        for i in range(moving if down[axis] != 0.0 else 0):
            height[i] -= ball[i, axis] * down[axis]
    worst = blame_pairs(ball, scale, lists.pairs, lists.seam, height, overlap)
    for i in range(moving):
        if math.isnan(ball[i, 0]):
            continue
        radius = scale * ball[i, 3]
        for k in range(wall_begin[i], wall_begin[i + 1]):
            feature = wall_item[k]
            if out_of_reach(kind[feature], row[feature], ball[i, 0], ball[i, 1], ball[i, 2], radius):
                continue
            gap = wall_gap(kind[feature], row[feature], ball[i, 0], ball[i, 1], ball[i, 2], radius)[0]
            if gap < 0.0:
                overlap[i] = max(overlap[i], -gap / radius)
                worst = max(worst, -gap / radius)
    return worst, overlap
