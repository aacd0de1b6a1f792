"""The places where a new sphere touches one of the front and two other surfaces, and how good each is."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.advancing_front.cap_kernels import Bench, caps_around
from packgen.arrange.advancing_front.cell_kernels import Cells
from packgen.arrange.advancing_front.surface_kernels import (
    is_borne,
    polished,
    polished_at_walls,
    room_among,
)
from packgen.arrange.space.feature_kernels import Features
from packgen.arrange.space.map_kernels import FeatureMap
from packgen.compiled import inner_loop

ALTITUDE, DISTANCE = 0, 1
"""What is least at the best place: the height, or the distance from a point."""

PLACES_MAX = 64
"""Places of one radius at one sphere that are kept."""

ROUNDING = 1.0e-14
"""By how much, of the largest cosine, a place may be inside a cap."""

LOOSE = 0.1
"""The same for places at curved walls before they are exact."""


ON_WALL = 1.0e-5
"""Two spheres that meet so near to a wall, in radii, are on either side of it."""


class Aim(NamedTuple):
    """Which places are best: those where a number is least.

    Attributes:
        kind: ALTITUDE or DISTANCE.
        vector: Unit vector against gravity, or the point [m], shape (3,).
        by_radius: What a sphere's radius adds to that number, in radii.
    """

    kind: int
    vector: NDArray[np.float64]
    by_radius: float


class Bed(NamedTuple):
    """The spheres that there are, and what bounds them.

    Attributes:
        ball: Centres and radii [m], shape (capacity, 4).
        cells: The cells that they lie in.
        features: The features of the walls.
        near: Which of them are near.
        radius_max: Largest radius [m], shape (1,).
        slack: Largest gap or overlap that counts as a contact [m], shape (1,).
    """

    ball: NDArray[np.float64]
    cells: Cells
    features: Features
    near: FeatureMap
    radius_max: NDArray[np.float64]
    slack: NDArray[np.float64]


@inner_loop
def worth(x: float, y: float, z: float, radius: float, aim: Aim) -> float:
    """Return what is least at the best place [m]."""
    vector = aim.vector
    if aim.kind == ALTITUDE:
        return float(x * vector[0] + y * vector[1] + z * vector[2] + aim.by_radius * radius)
    dx, dy, dz = x - vector[0], y - vector[1], z - vector[2]
    return math.sqrt(dx * dx + dy * dy + dz * dz) + aim.by_radius * radius


@inner_loop
def _closing(
    ux: float,
    uy: float,
    uz: float,
    i: int,
    j: int,
    count: int,
    cap: NDArray[np.float64],
    slack: float,
    guess: int,
) -> int:
    """Return a cap, of the first ones but two, that a direction is in; -1: in none.

    Args:
        ux: Direction.
        uy: Direction.
        uz: Direction.
        i: A cap that does not count.
        j: Another one.
        count: How many caps there are.
        cap: The caps, shape (count, 4) or longer.
        slack: How deep inside, of the cosine.
        guess: The cap to be looked at first: neighbours are often in one.
    """
    k = guess
    if k != i and k != j and ux * cap[k, 0] + uy * cap[k, 1] + uz * cap[k, 2] - cap[k, 3] > slack:
        return guess
    for k in range(count):
        inside = ux * cap[k, 0] + uy * cap[k, 1] + uz * cap[k, 2] - cap[k, 3]
        if inside > slack and k != i and k != j:
            return k
    return -1


@inner_loop
def _kept(
    x: NDArray[np.float64],
    push: NDArray[np.float64],
    base: NDArray[np.float64],
    radius: float,
    borne: bool,
    aim: Aim,
    place: NDArray[np.float64],
    found: int,
) -> int:
    """Write a place down, unless it is to bear weight and does not; return how many there are."""
    if borne and not is_borne(push, aim.vector):
        return found
    px, py, pz = base[0] + x[0], base[1] + x[1], base[2] + x[2]
    place[found, 0], place[found, 1], place[found, 2] = px, py, pz
    place[found, 3] = worth(px, py, pz, radius, aim)
    return found + 1


@inner_loop
def meets_in_wall(
    x: NDArray[np.float64],
    base: NDArray[np.float64],
    radius: float,
    features: Features,
    item: NDArray[np.int64],
) -> bool:
    """Tell whether a sphere meets that at ``base`` in a wall: rounding lets it touch both from outside."""
    share = base[3] / (base[3] + radius)
    px, py, pz = base[0] + share * x[0], base[1] + share * x[1], base[2] + share * x[2]
    return bool(room_among(px, py, pz, 0.0, features, item)[0] < ON_WALL * radius)


@inner_loop
def places_at(
    bed: Bed, s: int, radius: float, aim: Aim, borne: bool, bench: Bench, place: NDArray[np.float64]
) -> int:
    """Find the places where a sphere touches sphere ``s`` and two other surfaces and overlaps nothing.

    Args:
        bed: The spheres that there are.
        s: One of them.
        radius: Radius of the new one [m].
        aim: Which places are best.
        borne: Whether its contacts have to bear its weight.
        bench: Room for what is near.
        place: Out: centres, and what is least at the best place [m], shape (PLACES_MAX, 4).

    Returns:
        How many; -1: fewer than two other surfaces are near.
    """
    base, slack = bed.ball[s], bed.slack[0]
    far = base[3] + radius
    count, makers, curved, walls = caps_around(
        bed.cells, bed.ball, base, radius, bed.radius_max[0], bed.features, bed.near, bench
    )
    if makers < 0:
        return 0
    if makers < 2:
        return -1
    cap, item, found, guess = bench.cap, bench.item[:walls], 0, 0
    x, kind, surface, push = np.empty(3), np.empty(3, np.int64), np.empty((3, 4)), np.empty((3, 3))
    for a in range(1, makers):
        i = bench.maker[a]
        for b in range(a):
            j = bench.maker[b]
            rough = i >= count or j >= count
            if i >= count and j >= count and bench.surface[i, 0] == bench.surface[j, 0]:
                continue
            turn = cap[i, 0] * cap[j, 0] + cap[i, 1] * cap[j, 1] + cap[i, 2] * cap[j, 2]
            det = 1.0 - turn * turn
            first, second = cap[i, 3], cap[j, 3]
            rest = det - first * first - second * second + 2.0 * turn * first * second
            if rest < 0.0 or det < 1e-10:
                continue
            inverse = 1.0 / det
            p, q = (first - turn * second) * inverse, (second - turn * first) * inverse
            root = math.sqrt(rest) * inverse
            mx = p * cap[i, 0] + q * cap[j, 0]
            my = p * cap[i, 1] + q * cap[j, 1]
            mz = p * cap[i, 2] + q * cap[j, 2]
            nx = root * (cap[i, 1] * cap[j, 2] - cap[i, 2] * cap[j, 1])
            ny = root * (cap[i, 2] * cap[j, 0] - cap[i, 0] * cap[j, 2])
            nz = root * (cap[i, 0] * cap[j, 1] - cap[i, 1] * cap[j, 0])
            for side in range(2):
                sign = 1.0 - 2.0 * side
                ux, uy, uz = mx + sign * nx, my + sign * ny, mz + sign * nz
                closing = _closing(ux, uy, uz, i, j, count, cap, LOOSE if rough else ROUNDING, guess)
                if closing >= 0 or found == len(place):
                    guess = max(closing, 0)
                    continue
                x[0], x[1], x[2] = far * ux, far * uy, far * uz
                kind[0], kind[1], kind[2] = 0, bench.kind[i], bench.kind[j]
                surface[0, 0] = surface[0, 1] = surface[0, 2] = 0.0
                surface[0, 3] = far
                surface[1] = bench.surface[i]
                surface[2] = bench.surface[j]
                if not curved:
                    if polished(x, kind, surface, push, base, radius, bed.features, slack):
                        found = _kept(x, push, base, radius, borne, aim, place, found)
                    continue
                if rough and not (
                    polished(x, kind, surface, push, base, radius, bed.features, slack)
                    and _closing(x[0] / far, x[1] / far, x[2] / far, i, j, count, cap, LOOSE, guess) < 0
                ):
                    continue
                if not polished_at_walls(x, kind, surface, push, base, radius, bed.features, item, slack):
                    continue
                if rough and 0 <= _closing(
                    x[0] / far, x[1] / far, x[2] / far,
                    i if i < count else -1, j if j < count else -1, count, cap, ROUNDING, guess,
                ):  # fmt: skip
                    continue
                if meets_in_wall(x, base, radius, bed.features, item):
                    continue
                found = _kept(x, push, base, radius, borne, aim, place, found)
    return found
