"""The contact sweep: every overlapping pair is pushed apart, every sphere back inside its walls, all at once.

One sweep is a Jacobi step of position-based dynamics (Mueller et al., J. Vis. Commun. Image R. 18 (2007)
109): each sphere moves by the sum of its overlaps along their normals, shared in inverse proportion to the
masses, from a position extrapolated by momentum.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from packgen.arrange.projection.push_kernels import (
    blamed_sphere,
    push_pairs,
    push_seam_pairs,
    seam_overlaps,
    touching_pairs,
)
from packgen.arrange.space.feature_kernels import out_of_reach, wall_gap

GRAIN_PUSH = 0.1
"""Largest push by rough walls in a sweep, all features together, in radii: gentle, for a sphere between two
walls must not pass one."""


@njit(cache=True, error_model="numpy", inline="always")
def wall_grain(identity: int) -> float:
    """Return the part of a wall's roughness that keeps a sphere off, 0 to 1: the golden ratio's multiples."""
    return identity * 0.6180339887498949 % 1.0


@njit(cache=True, error_model="numpy")
def sweep(  # type: ignore[no-untyped-def]
    ball: NDArray[np.float64],
    previous: NDArray[np.float64],
    lightness: NDArray[np.float64],
    moving: int,
    owner: NDArray[np.int32],
    neighbor: NDArray[np.int32],
    touching: NDArray[np.int32],
    shift: NDArray[np.float64],
    anchor: NDArray[np.float64],
    margin: NDArray[np.float64],
    seam_first: NDArray[np.int32],
    seam_second: NDArray[np.int32],
    seam_offset: NDArray[np.float64],
    wall_begin: NDArray[np.int64],
    wall_item: NDArray[np.int32],
    wall_room: NDArray[np.float64],
    kind: NDArray[np.int8],
    row: NDArray[np.float64],
    identity: NDArray[np.int64],
    sink: NDArray[np.float64],
    momentum: float,
    relaxation: float,
    stride: float,
    roughness: float,
    far: float,
):
    """Sink, extrapolate, push apart, and put back inside the walls, once.

    Args:
        ball: Centres and radii [m], shape (N, 4); the first ``moving`` rows change.
        previous: Centres one sweep ago [m], shape (moving, 3); changes.
        lightness: Share of a push that each sphere takes; see ``push_pairs``.
        moving: The first so many spheres move.
        owner: One sphere of each listed pair, shape (P,).
        neighbor: The other one, shape (P,) or longer.
        touching: Work space, shape (P + 1,) or longer.
        shift: Work space, shape (N, 3).
        anchor: Centres when the neighbour list was built [m], shape (moving, 3).
        margin: The neighbour list holds while no sphere has moved further than this [m], shape (moving,).
        seam_first: One sphere of each pair across a seam.
        seam_second: The other one.
        seam_offset: What takes the other one to its image [m], shape (P, 3).
        wall_begin: First wall entry of each moving sphere.
        wall_item: Features within reach.
        wall_room: Gap to each of them when the list was built [m].
        kind: Kind of each feature.
        row: The features.
        identity: A number of each moving sphere by which it meets its own grain of a rough wall.
        sink: Displacement before the sweep [m], shape (3,).
        momentum: Share of the last displacement that is added again.
        relaxation: Factor on the sum of the pushes.
        stride: Largest displacement by pushes, as a fraction of the radius.
        roughness: Depth of the walls' roughness, as a fraction of the radius: each sphere is kept off the
            walls by a part of it.
        far: A sphere that has moved by so many margins may be inside another one unseen: it counts as all.

    Returns:
        (largest pair overlap as a fraction of the smaller radius, spheres that have outrun the list; more
        than there are where one has by far).
    """
    sink_x, sink_y, sink_z = sink[0], sink[1], sink[2]
    for i in range(moving):
        x, y, z = ball[i, 0] + sink_x, ball[i, 1] + sink_y, ball[i, 2] + sink_z
        ball[i, 0] = x + momentum * (x - previous[i, 0])
        ball[i, 1] = y + momentum * (y - previous[i, 1])
        ball[i, 2] = z + momentum * (z - previous[i, 2])
        previous[i, 0], previous[i, 1], previous[i, 2] = x, y, z
    count = touching_pairs(ball, owner, neighbor, touching)
    worst = push_pairs(ball, lightness, owner, neighbor, touching[:count], shift)
    worst = max(worst, push_seam_pairs(ball, lightness, seam_first, seam_second, seam_offset, shift))
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
            dx = x - anchor[i, 0]
            dy = y - anchor[i, 1]
            dz = z - anchor[i, 2]
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
        dx = x - anchor[i, 0]
        dy = y - anchor[i, 1]
        dz = z - anchor[i, 2]
        square, allowed = dx * dx + dy * dy + dz * dz, margin[i] * margin[i]
        if square > allowed:
            strays += 1
            if square > far * far * allowed:
                strays += moving
    return worst, strays


@njit(cache=True, error_model="numpy")
def sphere_overlaps(
    ball: NDArray[np.float64],
    scale: float,
    moving: int,
    owner: NDArray[np.int32],
    neighbor: NDArray[np.int32],
    seam_first: NDArray[np.int32],
    seam_second: NDArray[np.int32],
    seam_offset: NDArray[np.float64],
    wall_begin: NDArray[np.int64],
    wall_item: NDArray[np.int32],
    kind: NDArray[np.int8],
    row: NDArray[np.float64],
    height: NDArray[np.float64],
    overlap: NDArray[np.float64],
) -> float:
    """Blame each overlap on one moving sphere: the smaller of a pair, else the higher; the one in the wall.

    Args:
        ball: Centres and arranged radii [m], shape (N, 4).
        scale: True radius over arranged radius.
        moving: The first so many spheres move.
        owner: One sphere of each listed pair, shape (P,).
        neighbor: The other one, shape (P,) or longer.
        seam_first: One sphere of each pair across a seam.
        seam_second: The other one.
        seam_offset: What takes the other one to its image [m], shape (P, 3).
        wall_begin: First wall entry of each moving sphere.
        wall_item: Features within reach.
        kind: Kind of each feature.
        row: The features.
        height: Height of each moving sphere [m], shape (moving,).
        overlap: Out: the largest overlap each moving sphere is blamed for, as a fraction of the smaller
            true radius, shape (moving,).

    Returns:
        Largest of them.
    """
    overlap[:moving] = 0.0
    worst = 0.0
    for k in range(len(owner)):
        i, j = owner[k], neighbor[k]
        radius, other = scale * ball[i, 3], scale * ball[j, 3]
        dx = ball[i, 0] - ball[j, 0]
        dy = ball[i, 1] - ball[j, 1]
        dz = ball[i, 2] - ball[j, 2]
        reach = radius + other
        square = dx * dx + dy * dy + dz * dz
        if square < reach * reach:
            depth = (reach - math.sqrt(square)) / min(radius, other)
            worst = max(worst, depth)
            blamed = blamed_sphere(i, j, moving, radius, other, height)
            overlap[blamed] = max(overlap[blamed], depth)
    seams = seam_overlaps(ball, scale, moving, seam_first, seam_second, seam_offset, height, overlap)
    worst = max(worst, seams)
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
    return worst
