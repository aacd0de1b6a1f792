"""Soft spheres pushed apart: what is near each, the forces between them, and how stiffly each is held.

Two spheres whose centres are nearer than the sum s of their radii push each other by s times their overlap.
Under pressure all contacts then overlap by about the same share of s, whatever the sizes. A wall is a mirror:
it pushes as a second sphere of the same size would.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.listing import list_pairs
from packgen.arrange.neighbors.seam_pairs import seam_pairs
from packgen.arrange.projection.pair_rules import list_reach
from packgen.arrange.space.feature_kernels import Features, out_of_reach, wall_gap
from packgen.arrange.space.map_kernels import WallList
from packgen.arrange.space.seams import is_periodic, wrapped_coordinate
from packgen.arrange.space.walls import WallTable, walls_in_reach
from packgen.compiled import inlined, inner_loop

SKIN = 0.35
"""Skin of the neighbour lists, see ``list_reach``: shorter ones end too soon, longer ones hold too much."""

HELD_WITHIN = 1.05
"""Distance of two centres, in sums of their radii, up to which a neighbour counts as holding a sphere."""

HELD_LEAST = 3.0
"""Contacts with its like that hold a sphere at least; one without any would shoot off at the first touch."""


class Soft(NamedTuple):
    """Spheres as the loops have them, sorted by cell; all arrays change.

    Attributes:
        center: Centres [m], shape (N, 3), float64.
        velocity: Displacements in a unit of time [m], shape (N, 3), float64.
        radius: Radii [m], shape (N,), float64.
        identity: Place of each among the spheres given, shape (N,), int64.
    """

    center: NDArray[np.float64]
    velocity: NDArray[np.float64]
    radius: NDArray[np.float64]
    identity: NDArray[np.int64]


class Near(NamedTuple):
    """What each sphere can meet until one of them has moved by more than its margin.

    Attributes:
        begin: First neighbour of each, shape (N + 1,), int64; each pair is there once.
        item: Neighbours, sphere by sphere, int32.
        first: One sphere of each pair across a seam, shape (K,), int32.
        second: The other one, shape (K,), int32.
        offset: What takes the second one to its image near the first [m], shape (K, 3), float64.
        walls: The walls.
        anchor: Centres when the lists were made [m], shape (N, 3), float64.
        margin: How far each may move [m], shape (N,), float64.
        half: Radii times the common factor [m], shape (N,), float64.
        mass: Stiffness of all that holds each [m], shape (N,), float64; see ``find_masses``.
    """

    begin: NDArray[np.int64]
    item: NDArray[np.int32]
    first: NDArray[np.int32]
    second: NDArray[np.int32]
    offset: NDArray[np.float64]
    walls: WallList
    anchor: NDArray[np.float64]
    margin: NDArray[np.float64]
    half: NDArray[np.float64]
    mass: NDArray[np.float64]


class Strain(NamedTuple):
    """How much the spheres press each other.

    Attributes:
        contacts: Number of contacts, walls included.
        squares: Sum of the squares of the forces at contacts [m4].
        pressure: Sum over the contacts of overlap over s, times distance over s.
        worst: Largest overlap, as a fraction of the smaller radius.
    """

    contacts: int
    squares: float
    pressure: float
    worst: float


@inner_loop
def sorted_by_cell(spheres: Soft, grown: float, walls: WallTable):  # type: ignore[no-untyped-def]
    """Sort spheres by cell, back in the periodic box, and list what is near them.

    Args:
        spheres: The spheres; their arrays change places.
        grown: Common factor of all radii.
        walls: The walls.

    Returns:
        The lists, a ``Near``.
    """
    center, velocity, radius, identity = spheres
    count = len(radius)
    low, period = walls.seams
    ball = np.empty((count, 4))
    mean = 0.0
    for i in range(count):
        for axis in range(3):
            ball[i, axis] = wrapped_coordinate(center[i, axis], low[axis], period[axis])
        ball[i, 3] = grown * radius[i]
        mean += ball[i, 3] / count
    reach = list_reach(ball, count, SKIN, mean)
    order, (ball, reach, _), (owner, item) = list_pairs(ball, reach, count, np.empty(0, np.int32))
    speed, name = velocity.copy(), identity.copy()
    begin = np.zeros(count + 1, np.int64)
    anchor, margin, half = np.empty((count, 3)), np.empty(count), np.empty(count)
    for i in range(count):
        for axis in range(3):
            center[i, axis] = anchor[i, axis] = ball[i, axis]
            velocity[i, axis] = speed[order[i], axis]
        identity[i] = name[order[i]]
        half[i] = ball[i, 3]
        margin[i] = reach[i] - half[i]
    sizes = radius.copy()
    for i in range(count):
        radius[i] = sizes[order[i]]
    for k in range(len(owner)):
        begin[owner[k] + 1] += 1
    for i in range(count):
        begin[i + 1] += begin[i]
    first, second, offset = np.empty(0, np.int32), np.empty(0, np.int32), np.empty((0, 3))
    if is_periodic(period):
        first, second, offset = seam_pairs(ball, reach, count, walls.seams)
    none = WallList(np.empty(0, np.int64), np.empty(0, np.int32), np.empty(0))
    wall_begin, wall_item, room = walls_in_reach(ball, margin, walls, none)
    near = Near(
        begin, item, first, second, offset, WallList(wall_begin, wall_item, room), anchor, margin, half,
        np.empty(count),
    )  # fmt: skip
    find_masses(center, near)
    return near


@inner_loop
def find_masses(center: NDArray[np.float64], near: Near) -> None:
    """Find the mass of each sphere: the stiffness of all its contacts.

    Whatever the sizes, no oscillation of spheres so heavy is then faster than sqrt(2) a unit of time: no
    eigenvalue of a matrix of springs over the sums of their stiffnesses is larger than 2.
    """
    half, mass = near.half, near.mass
    for i in range(len(half)):
        mass[i] = HELD_LEAST * 2.0 * half[i]
        for k in range(near.walls.begin[i], near.walls.begin[i + 1]):
            if near.walls.room[k] < 2.0 * (HELD_WITHIN - 1.0) * half[i]:
                mass[i] += 2.0 * half[i]
    for i in range(len(half)):
        for k in range(near.begin[i], near.begin[i + 1]):
            j = near.item[k]
            dx, dy, dz = center[i, 0] - center[j, 0], center[i, 1] - center[j, 1], center[i, 2] - center[j, 2]
            apart = half[i] + half[j]
            if dx * dx + dy * dy + dz * dz < (HELD_WITHIN * apart) ** 2:
                mass[i] += apart
                mass[j] += apart
    for k in range(len(near.first)):
        i, j = near.first[k], near.second[k]
        mass[i] += half[i] + half[j]
        mass[j] += half[i] + half[j]


@inlined
def pressed(square: float, apart: float) -> tuple[float, float, float, float]:
    """Return how two spheres press each other that overlap.

    Args:
        square: Square of the distance of their centres [m2].
        apart: Sum of their radii [m].

    Returns:
        (force over distance [m], force [m2], share of the pressure, see ``Strain``, overlap [m]).
    """
    distance = max(math.sqrt(square), 1e-9 * apart)
    overlap = apart - distance
    strength = apart * overlap
    return strength / distance, strength, overlap * distance / (apart * apart), overlap


@inner_loop
def push(center: NDArray[np.float64], near: Near, features: Features, force: NDArray[np.float64]):  # type: ignore[no-untyped-def]
    """Find the forces upon all spheres.

    Args:
        center: Centres [m], shape (N, 3).
        near: What is near them.
        features: The walls.
        force: Out: the force upon each [m2], shape (N, 3).

    Returns:
        How much they press each other, a ``Strain``.
    """
    begin, item, first, second, offset, (wall_begin, wall_item, _), _, _, half, _ = near
    kind, row = features
    contacts, squares, pressure, worst = 0, 0.0, 0.0, 0.0
    for i in range(len(half)):
        force[i, 0] = force[i, 1] = force[i, 2] = 0.0
    for i in range(len(half)):
        x, y, z, own = center[i, 0], center[i, 1], center[i, 2], half[i]
        sx = sy = sz = 0.0
        for k in range(begin[i], begin[i + 1]):
            j = np.uint64(item[np.uint64(k)])  # unsigned: no code for negative indices
            dx, dy, dz = x - center[j, 0], y - center[j, 1], z - center[j, 2]
            square, apart = dx * dx + dy * dy + dz * dz, own + half[j]
            if square < apart * apart:
                factor, strength, part, overlap = pressed(square, apart)
                dx, dy, dz = factor * dx, factor * dy, factor * dz
                sx, sy, sz = sx + dx, sy + dy, sz + dz
                force[j, 0] -= dx
                force[j, 1] -= dy
                force[j, 2] -= dz
                contacts += 1
                squares += strength * strength
                pressure += part
                worst = max(worst, overlap / min(own, half[j]))
        for k in range(wall_begin[i], wall_begin[i + 1]):
            feature = wall_item[k]
            if out_of_reach(kind[feature], row[feature], x, y, z, own):
                continue
            gap, nx, ny, nz = wall_gap(kind[feature], row[feature], x, y, z, own)
            if gap < 0.0:
                factor = -2.0 * own * gap
                sx, sy, sz = sx + factor * nx, sy + factor * ny, sz + factor * nz
                contacts += 1
                squares += factor * factor
                pressure -= gap * (2.0 * own + gap) / (4.0 * own * own)
                worst = max(worst, -gap / own)
        force[i, 0] += sx
        force[i, 1] += sy
        force[i, 2] += sz
    for k in range(len(first)):
        i, j = first[k], second[k]
        dx = center[i, 0] - (center[j, 0] + offset[k, 0])
        dy = center[i, 1] - (center[j, 1] + offset[k, 1])
        dz = center[i, 2] - (center[j, 2] + offset[k, 2])
        square, apart = dx * dx + dy * dy + dz * dz, half[i] + half[j]
        if square < apart * apart:
            factor, strength, part, overlap = pressed(square, apart)
            force[i, 0] += factor * dx
            force[i, 1] += factor * dy
            force[i, 2] += factor * dz
            force[j, 0] -= factor * dx
            force[j, 1] -= factor * dy
            force[j, 2] -= factor * dz
            contacts += 1
            squares += strength * strength
            pressure += part
            worst = max(worst, overlap / min(half[i], half[j]))
    return Strain(contacts, squares, pressure, worst)
