"""Monte Carlo of hard spheres: small random moves, each taken where it keeps all distances.

Metropolis and others, J. Chem. Phys. 21 (1953) 1087. Each move is as likely as the way back, so that in the
end every arrangement without overlaps is equally likely: that is the fluid of hard spheres.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.dispersed.near_kernels import Crowd, Near, listed
from packgen.arrange.random_kernels import next_number
from packgen.arrange.space.feature_kernels import Features, out_of_reach, wall_gap
from packgen.arrange.space.walls import WallTable
from packgen.compiled import inlined, inner_loop, loop

BITS = 21
"""Bits of one number of 64 that make the step along each of three axes."""

HALF_RANGE = float(1 << (BITS - 1))

DIAGONAL = math.sqrt(3.0)


@inlined
def along(number: np.uint64, axis: int) -> float:
    """Return a random number from -1 to 1, evenly spread around 0, of the bits that an axis has."""
    part = (number >> np.uint64(BITS * axis)) & np.uint64((1 << BITS) - 1)
    return (float(part) + 0.5) / HALF_RANGE - 1.0


@inlined
def is_free(
    i: int, x: float, y: float, z: float, travel: float, crowd: Crowd, near: Near, features: Features
) -> bool:
    """Tell whether sphere ``i`` keeps all its distances at a place, ``travel`` [m] from its anchor."""
    center, half, wall = crowd
    begin, item, seam_begin, seam_item, seam_offset, (wall_begin, wall_item, room), _, _ = near
    kind, row = features
    own = half[i]
    for k in range(begin[i], begin[i + 1]):
        # Unsigned: no code for negative indices in the innermost loop.
        j = np.uint64(item[np.uint64(k)])
        dx, dy, dz = x - center[j, 0], y - center[j, 1], z - center[j, 2]
        apart = own + half[j]
        if dx * dx + dy * dy + dz * dz < apart * apart:
            return False
    for k in range(seam_begin[i], seam_begin[i + 1]):
        j = seam_item[k]
        dx = x - (center[j, 0] + seam_offset[k, 0])
        dy = y - (center[j, 1] + seam_offset[k, 1])
        dz = z - (center[j, 2] + seam_offset[k, 2])
        apart = half[i] + half[j]
        if dx * dx + dy * dy + dz * dz < apart * apart:
            return False
    for k in range(wall_begin[i], wall_begin[i + 1]):
        # No distance shrinks by more than the sphere moves.
        if room[k] > travel:
            continue
        feature = wall_item[k]
        if out_of_reach(kind[feature], row[feature], x, y, z, wall[i]):
            continue
        if wall_gap(kind[feature], row[feature], x, y, z, wall[i])[0] < 0.0:
            return False
    return True


@inner_loop
def stir_once(
    crowd: Crowd,
    near: Near,
    features: Features,
    step: NDArray[np.float64],
    state: NDArray[np.uint64],
    taken: NDArray[np.int64],
) -> bool:
    """Try to move each sphere once.

    Args:
        crowd: The spheres; centres change.
        near: What is near them.
        features: The walls.
        step: Largest step of each along an axis [m], shape (M,).
        state: State of the random numbers, shape (1,), uint64; changes.
        taken: Number of moves that each has made, shape (M,), int64; changes.

    Returns:
        Whether the next round may need new lists.
    """
    center = crowd.center
    outrun = False
    for i in range(len(step)):
        number = next_number(state)
        x = center[i, 0] + step[i] * along(number, 0)
        y = center[i, 1] + step[i] * along(number, 1)
        z = center[i, 2] + step[i] * along(number, 2)
        dx, dy, dz = x - near.anchor[i, 0], y - near.anchor[i, 1], z - near.anchor[i, 2]
        travel = math.sqrt(dx * dx + dy * dy + dz * dz)
        if is_free(i, x, y, z, travel * (1.0 + 1e-9), crowd, near, features):
            center[i, 0], center[i, 1], center[i, 2] = x, y, z
            taken[i] += 1
            outrun |= travel + DIAGONAL * step[i] > near.margin[i]
    return outrun


@loop
def stir(
    center: NDArray[np.float64],
    half: NDArray[np.float64],
    wall: NDArray[np.float64],
    walls: WallTable,
    step: NDArray[np.float64],
    rounds: int,
    skin: float,
    state: NDArray[np.uint64],
) -> NDArray[np.int64]:
    """Try to move each sphere several times; what keeps its distances at the start keeps them at the end.

    Args:
        center: Centres [m], shape (N, 3); the first M of them move, and change.
        half: See ``Crowd``, shape (N,).
        wall: See ``Crowd``, shape (M,).
        walls: The walls.
        step: Largest step of each along an axis [m], shape (M,); its diagonal at most half of the margin that
            the skin gives, and shorter than the sphere is wide: none steps through a sheet.
        rounds: Moves tried of each.
        skin: See ``list_reach``.
        state: State of the random numbers, shape (1,), uint64; changes.

    Returns:
        Number of moves that each has made, shape (M,).
    """
    crowd = Crowd(center, half, wall)
    taken = np.zeros(len(step), np.int64)
    reference = mean_of(half, len(wall))
    outrun = True
    near = listed(crowd, walls, skin, reference)
    for number in range(rounds):
        if outrun and number > 0:
            near = listed(crowd, walls, skin, reference)
        outrun = stir_once(crowd, near, walls.features, step, state, taken)
    return taken


@inner_loop
def mean_of(half: NDArray[np.float64], moving: int) -> float:
    """Return the mean of the first values, ``moving`` of them."""
    total = 0.0
    for i in range(moving):
        total += half[i]
    return total / moving


@loop
def crowded(
    center: NDArray[np.float64], half: NDArray[np.float64], wall: NDArray[np.float64], walls: WallTable
) -> NDArray[np.bool_]:
    """Tell which moving spheres have to go so that the others keep all distances, shape (M,).

    Of two that are too close the smaller one goes, of two alike the one that comes later.
    """
    crowd = Crowd(center, half, wall)
    near = listed(crowd, walls, 0.0, mean_of(half, len(wall)))
    gone = np.zeros(len(wall), np.bool_)
    kind, row = walls.features
    wall_begin, wall_item, _ = near.walls
    for i in range(len(wall)):
        x, y, z = center[i, 0], center[i, 1], center[i, 2]
        for k in range(wall_begin[i], wall_begin[i + 1]):
            feature = wall_item[k]
            gone[i] |= wall_gap(kind[feature], row[feature], x, y, z, wall[i])[0] < 0.0
        for k in range(near.begin[i], near.begin[i + 1]):
            j = near.item[k]
            dx, dy, dz = x - center[j, 0], y - center[j, 1], z - center[j, 2]
            gone[i] |= is_to_go(i, j, dx, dy, dz, half, gone)
        for k in range(near.seam_begin[i], near.seam_begin[i + 1]):
            j = near.seam_item[k]
            dx = x - (center[j, 0] + near.seam_offset[k, 0])
            dy = y - (center[j, 1] + near.seam_offset[k, 1])
            dz = z - (center[j, 2] + near.seam_offset[k, 2])
            gone[i] |= is_to_go(i, j, dx, dy, dz, half, gone)
    return gone


@inlined
def is_to_go(
    i: int,
    j: int,
    dx: float,
    dy: float,
    dz: float,
    half: NDArray[np.float64],
    gone: NDArray[np.bool_],
) -> bool:
    """Tell whether sphere ``i`` is too close to ``j``, and the one of both that has to go."""
    apart = half[i] + half[j]
    if dx * dx + dy * dy + dz * dz >= apart * apart:
        return False
    if j >= len(gone):
        return True
    return not gone[j] and (half[i] < half[j] or (half[i] == half[j] and i > j))
