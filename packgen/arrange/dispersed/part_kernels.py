"""Overlaps parted without gravity: each sphere in turn moves by its share of all pushes upon it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.dispersed.near_kernels import Crowd, Near, listed
from packgen.arrange.dispersed.stir_kernels import mean_of
from packgen.arrange.projection.pair_rules import PARTING_X, PARTING_Y
from packgen.arrange.space.feature_kernels import Features, out_of_reach, wall_gap
from packgen.arrange.space.walls import WallTable
from packgen.compiled import inlined, inner_loop, loop

STRIDE = 0.3
"""Largest displacement of one sweep by other spheres, in radii."""

RELAXATION = 1.3
"""Factor on the sum of a sphere's pushes."""


@inlined
def push_of(  # type: ignore[no-untyped-def]
    i: int, j: int, dx: float, dy: float, dz: float, half: NDArray[np.float64], weight: NDArray[np.float64]
):
    """Return the push upon sphere ``i`` [m] that one takes at (dx, dy, dz) from ``j``, and their overlap."""
    apart = half[i] + half[j]
    square = dx * dx + dy * dy + dz * dz
    if square >= apart * apart:
        return 0.0, 0.0, 0.0, 0.0
    distance = math.sqrt(square)
    overlap = apart - distance
    share = weight[i] / (weight[i] + weight[j])
    if distance < 1e-9 * apart:
        # Coincident spheres part in an even sequence of directions.
        turn, rise = 2.0 * (i * PARTING_X % 1.0) - 1.0, 2.0 * (i * PARTING_Y % 1.0) - 1.0
        long = math.sqrt(turn * turn + rise * rise + 1.0)
        return share * overlap * turn / long, share * overlap * rise / long, share * overlap / long, overlap
    factor = share * overlap / distance
    return factor * dx, factor * dy, factor * dz, overlap


@inner_loop
def part_once(  # type: ignore[no-untyped-def]
    crowd: Crowd, near: Near, features: Features, weight: NDArray[np.float64]
):
    """Move each sphere once.

    Args:
        crowd: The spheres; centres change.
        near: What is near them.
        features: The walls.
        weight: Weight of each in a push, shape (N,); see ``push_weights``.

    Returns:
        (largest overlap met, as a fraction of the smaller half distance; whether new lists are needed).
    """
    center, half, wall = crowd
    begin, item, seam_begin, seam_item, seam_offset, (wall_begin, wall_item, _), anchor, margin = near
    kind, row = features
    worst, outrun = 0.0, False
    for i in range(len(wall)):
        x, y, z = center[i, 0], center[i, 1], center[i, 2]
        sx = sy = sz = 0.0
        for k in range(begin[i], begin[i + 1]):
            j = item[k]
            dx, dy, dz = x - center[j, 0], y - center[j, 1], z - center[j, 2]
            px, py, pz, overlap = push_of(i, j, dx, dy, dz, half, weight)
            if overlap > 0.0:
                sx, sy, sz = sx + px, sy + py, sz + pz
                worst = max(worst, overlap / min(half[i], half[j]))
        for k in range(seam_begin[i], seam_begin[i + 1]):
            j = seam_item[k]
            dx = x - (center[j, 0] + seam_offset[k, 0])
            dy = y - (center[j, 1] + seam_offset[k, 1])
            dz = z - (center[j, 2] + seam_offset[k, 2])
            px, py, pz, overlap = push_of(i, j, dx, dy, dz, half, weight)
            if overlap > 0.0:
                sx, sy, sz = sx + px, sy + py, sz + pz
                worst = max(worst, overlap / min(half[i], half[j]))
        sx, sy, sz = RELAXATION * sx, RELAXATION * sy, RELAXATION * sz
        square, limit = sx * sx + sy * sy + sz * sz, STRIDE * half[i]
        if square > limit * limit:
            shorten = limit / math.sqrt(square)
            sx, sy, sz = sx * shorten, sy * shorten, sz * shorten
        x, y, z = x + sx, y + sy, z + sz
        # Where several walls meet, putting back from one may push into the next: go round twice.
        for _ in range(min(wall_begin[i + 1] - wall_begin[i], 2)):
            pushed = False
            for k in range(wall_begin[i], wall_begin[i + 1]):
                feature = wall_item[k]
                if out_of_reach(kind[feature], row[feature], x, y, z, wall[i]):
                    continue
                gap, nx, ny, nz = wall_gap(kind[feature], row[feature], x, y, z, wall[i])
                if gap < 0.0:
                    x, y, z = x - gap * nx, y - gap * ny, z - gap * nz
                    worst = max(worst, -gap / wall[i])
                    pushed = True
            if not pushed:
                break
        center[i, 0], center[i, 1], center[i, 2] = x, y, z
        dx, dy, dz = x - anchor[i, 0], y - anchor[i, 1], z - anchor[i, 2]
        outrun |= dx * dx + dy * dy + dz * dz > margin[i] * margin[i]
    return worst, outrun


@loop
def part(
    center: NDArray[np.float64],
    half: NDArray[np.float64],
    wall: NDArray[np.float64],
    weight: NDArray[np.float64],
    walls: WallTable,
    sweeps: int,
    skin: float,
    calm: float,
) -> tuple[int, float]:
    """Part the overlaps of spheres.

    Args:
        center: Centres [m], shape (N, 3); the first M of them move, and change.
        half: See ``Crowd``, shape (N,).
        wall: See ``Crowd``, shape (M,).
        weight: Weight of each in a push, shape (N,).
        walls: The walls.
        sweeps: Sweeps at most.
        skin: See ``list_reach``.
        calm: Largest overlap at which they count as parted.

    Returns:
        (sweeps done, largest overlap that the last one met).
    """
    crowd = Crowd(center, half, wall)
    reference = mean_of(half, len(wall))
    near = listed(crowd, walls, skin, reference)
    worst, outrun = 0.0, False
    for number in range(sweeps):
        if outrun:
            near = listed(crowd, walls, skin, reference)
        worst, outrun = part_once(crowd, near, walls.features, weight)
        if worst <= calm:
            return number + 1, worst
    return sweeps, worst
