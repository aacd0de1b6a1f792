"""Starts and moves: where spheres are put at first, and how a good arrangement becomes a better one."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from packgen.arrange.optimal.descend import LOOSE, Placed, contact_counts, descend, loose_factor
from packgen.arrange.optimal.press_kernels import press
from packgen.arrange.optimal.room import Room
from packgen.arrays import Float64Array
from packgen.compiled import signals_heard
from packgen.portable import cube_root, matrix_product

FCC = np.array([[0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]]) / np.sqrt(2.0)
"""Vectors of the densest lattice of points a length of 1 apart, as rows."""

HOLE_POINTS = 1000
"""Points among which the largest hole is sought."""

SHAKEN = 0.3
"""Largest move along an axis of spheres that are shaken, in radii."""

BETTER = 1.0e-9
"""Share by which a factor is larger to be better."""

FAILURES, FAILURES_MORE = 60, 6
"""Moves in a row that help nothing after which a chain ends, and more of them for each sphere."""

PRESSED = 1.005
"""Factor of the radii at which arrangements are compared, in the best one's."""

PRESSED_FIRST = 0.55
"""Solid fraction to which the spheres of a start are pressed, about that of a jammed bed between walls."""

ROOMIER = 1.03
"""Energy, in that of the best arrangement, up to which another one is worth linear programmes."""

ALIKE = 1.0e-3
"""Share by which energies differ of arrangements that are one and the same, but for rattlers."""

START, SHORT = 0.3, 0.1
"""Length of the first step after a start, in the longest one, and of those after a move."""

STEPS, CALM = 4000, 1.0e-10
"""Steps of soft spheres at most, and their rest; see ``press``."""


@dataclass(frozen=True, eq=False, slots=True)
class Improved:
    """What a chain of moves led to.

    Attributes:
        placed: The best arrangement.
        tried: Arrangements that were tried.
        programmes: Linear programmes solved.
    """

    placed: Placed
    tried: int
    programmes: int


def chain(
    room: Room, radius: Float64Array, number: int, seed: np.random.SeedSequence, until: float
) -> Improved:
    """Return what a start leads to, improved until moves help no more.

    Args:
        room: The room.
        radius: Radii [m], shape (N,).
        number: Number of the start; tells its kind.
        seed: Seed of its randomness.
        until: Time at which it ends [s since 1970].
    """
    rng = np.random.default_rng(seed)
    first = start(room, radius, number, rng)
    factor = loose_factor(room, radius) * float(cube_root(PRESSED_FIRST / LOOSE))
    center, _ = pressed(room, factor * radius, first)
    best = descend(room, radius, center, START)
    tried, programmes, failures = 1, best.programmes, 0
    _, least = pressed(room, PRESSED * best.factor * radius, best.center)
    seen = [least]
    patience = FAILURES + FAILURES_MORE * len(radius)
    while len(radius) > 1 and failures < patience and time.time() < until:
        center = moved(room, radius, best, rng)
        center, energy = pressed(room, PRESSED * best.factor * radius, center)
        tried, failures = tried + 1, failures + 1
        if energy > ROOMIER * least or min(abs(energy - each) for each in seen) < ALIKE * least:
            continue
        seen.append(energy)
        there = descend(room, radius, center, SHORT, best.factor)
        programmes += there.programmes
        if there.factor > best.factor * (1.0 + BETTER):
            best, failures = there, 0
            _, least = pressed(room, PRESSED * best.factor * radius, best.center)
            seen = [least]
    return Improved(best, tried, programmes)


def pressed(room: Room, half: Float64Array, center: Float64Array) -> tuple[Float64Array, float]:
    """Return where soft spheres of some radii come to rest [m], shape (N, 3), and their energy."""
    unit = 2.0 * float(half.mean())
    place = np.ascontiguousarray((center - room.bounds[0]) / unit)
    offset = (room.offset - matrix_product(room.normal, room.bounds[0])) / unit
    with signals_heard():
        energy = press(
            place, half / unit, np.ascontiguousarray(room.normal), offset,
            (room.center - room.bounds[0]) / unit, room.radius / unit, STEPS, CALM,
        )  # fmt: skip
    return place * unit + room.bounds[0], float(energy)


def start(room: Room, radius: Float64Array, number: int, rng: np.random.Generator) -> Float64Array:
    """Return places inside a room [m], shape (N, 3): random ones, a lattice's, or holes, largest first."""
    kind = number % 3
    if kind == 1 and len(radius) > 1:
        return _lattice(room, len(radius), rng)
    if kind == 2:
        return _largest_first(room, radius, rng)
    return room.points(len(radius), rng)


def moved(room: Room, radius: Float64Array, placed: Placed, rng: np.random.Generator) -> Float64Array:
    """Return places with one of three moves: into the largest hole, two changed, or all shaken."""
    center = placed.center.copy()
    unequal = bool((radius != radius[0]).any())
    kind = int(rng.integers(3 if unequal else 2))
    if kind == 0:
        counts = contact_counts(room, radius, placed) + rng.random(len(radius))
        few = np.argsort(counts)[: max(1, len(radius) // 3)]
        one = int(rng.choice(few))
        others = np.arange(len(radius)) != one
        center[one] = _hole(room, center[others], placed.factor * radius[others], rng)
        # A little of all goes with it: the hole is never as large as the sphere.
        return _shaken(room, center, 0.1 * placed.factor * radius, rng)
    if kind == 2:
        one = int(rng.integers(len(radius)))
        other = int(rng.choice(np.flatnonzero(radius != radius[one])))
        center[[one, other]] = center[[other, one]]
        return center
    return _shaken(room, center, SHAKEN * placed.factor * radius, rng)


def _shaken(room: Room, center: Float64Array, reach: Float64Array, rng: np.random.Generator) -> Float64Array:
    tried = center + (2.0 * rng.random(center.shape) - 1.0) * reach[:, None]
    inside = room.distances(tried).min(axis=1) > 0.0
    return np.where(inside[:, None], tried, center)


def _hole(room: Room, center: Float64Array, own: Float64Array, rng: np.random.Generator) -> Float64Array:
    """Return the point that is farthest from all surfaces [m], shape (3,), of some random ones."""
    points = room.points(HOLE_POINTS, rng)
    clearance = room.distances(points).min(axis=1)
    if len(center):
        way = points[:, None] - center[None]
        clearance = np.minimum(clearance, (np.sqrt((way * way).sum(axis=2)) - own).min(axis=1))
    return np.asarray(points[int(clearance.argmax())])


def _largest_first(room: Room, radius: Float64Array, rng: np.random.Generator) -> Float64Array:
    """Return a place for each sphere in the largest hole of some, one after the other."""
    own, center = loose_factor(room, radius) * radius, np.empty((len(radius), 3))
    order = np.lexsort((rng.random(len(radius)), -radius))
    for place, one in enumerate(order):
        before = order[:place]
        center[one] = _hole(room, center[before], own[before], rng)
    return center


def _lattice(room: Room, count: int, rng: np.random.Generator) -> Float64Array:
    """Return as many points of a lattice inside a room, cut anywhere, along its axes or turned."""
    turn = np.eye(3)
    if rng.random() < 0.5:
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    spacing, origin = cube_root(math.sqrt(2.0) * room.volume / count), rng.random(3)
    middle, half = room.bounds.mean(axis=0), 0.5 * np.ptp(room.bounds, axis=0)
    while True:
        most = int(np.ceil(2.0 * np.sqrt((half * half).sum()) / spacing)) + 1
        steps = np.stack(np.meshgrid(*[np.arange(-most, most + 1)] * 3, indexing="ij"), -1).reshape(-1, 3)
        points = middle + matrix_product(matrix_product(spacing * (steps + origin), FCC), turn)
        points = points[room.distances(points).min(axis=1) > 0.0]
        if len(points) >= count:
            return np.asarray(points[rng.permutation(len(points))[:count]])
        spacing *= 0.97
