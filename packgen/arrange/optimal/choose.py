"""Which of some spheres fill a room best: sets of larger volume than the best one are tried in turn."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from packgen.arrange.optimal.bounds import Bound, possible_sets
from packgen.arrange.optimal.chain import Improved, moved, pressed, start
from packgen.arrange.optimal.descend import Placed, descend
from packgen.arrange.optimal.room import Room
from packgen.arrays import Float64Array, Int64Array
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube, matrix_product

FITS = 1.0 - 1.0e-12
"""Common factor of the radii from which a set fits."""

FREE, NEAR = 1.0e-14, 3.0e-3
"""Energy of soft spheres that fit, and energy a sphere from which linear programmes are no use."""

FAILURES, FAILURES_MORE = 20, 4
"""Moves in a row that help nothing after which a try ends, and more of them for each sphere."""

BETTER = 1.0e-12
"""Share by which a volume is larger to be better."""

AT_ONCE = 40
"""Sets of more volume than the best one that are tried in turn."""


@dataclass(frozen=True, eq=False, slots=True)
class Chosen:
    """The best set so far.

    Attributes:
        numbers: Number of spheres of each size, shape (S,).
        placed: Where they are, in the order of the sizes.
        tried: Arrangements that were tried.
        programmes: Linear programmes that were solved.
        hits: Tries of this set that succeeded.
        tries: Sets that were tried, again and again.
        finished: Whether no set of larger volume is left to be tried.
    """

    numbers: Int64Array
    placed: Placed
    tried: int = 0
    programmes: int = 0
    hits: int = 1
    tries: int = 0
    finished: bool = False


def volume_bound(room: Room, size: Float64Array, number: Int64Array) -> Bound:
    """Return what the volume of chosen spheres cannot exceed [m3]."""
    volume = UNIT_VOLUME * cube(size)
    total = float(matrix_product(number, volume))
    sets = possible_sets(room, size, number)
    if sets is not None:
        best = float(matrix_product(sets[0], volume))
        return Bound(best, "all of them" if best == total else "sets whose pairs fit")
    return min(
        Bound(total, "all of them"),
        Bound(room.volume, "volume of the container"),
        key=lambda each: each.value,
    )


def fits(
    room: Room, radius: Float64Array, number: int, seed: np.random.SeedSequence, until: float
) -> Improved:
    """Try to place spheres of given radii: soft ones are moved until their overlaps are gone.

    Args:
        room: The room.
        radius: Radii [m], shape (N,).
        number: Number of the try; tells how it starts.
        seed: Seed of its randomness.
        until: Time at which it ends [s since 1970].
    """
    rng = np.random.default_rng(seed)
    center, least = pressed(room, radius, start(room, radius, number, rng))
    tried, failures = 1, 0
    while least > FREE and failures < FAILURES + FAILURES_MORE * len(radius) and time.time() < until:
        there, energy = pressed(room, radius, moved(room, radius, Placed(center, 1.0), rng))
        tried, failures = tried + 1, failures + 1
        if energy < least * (1.0 - 1.0e-6):
            center, least, failures = there, energy, 0
    if least > NEAR * len(radius):
        return Improved(Placed(center, 0.0), tried, 0)
    found = descend(room, radius, center, 0.1)
    return Improved(found, tried, found.programmes)


def search(
    room: Room,
    size: Float64Array,
    number: Int64Array,
    seed: np.random.SeedSequence,
    until: float,
    tries: int,
    tell: Callable[[Chosen], None],
) -> Iterator[Chosen]:
    """Yield better and better sets, and at last the best one once more.

    Args:
        room: The room.
        size: Radii, each once, falling [m], shape (S,).
        number: How many spheres there are of each, shape (S,).
        seed: Seed of all tries.
        until: Time at which it ends [s since 1970].
        tries: How often each set of larger volume is tried before it is given up.
        tell: Called after each try.
    """
    volume = UNIT_VOLUME * cube(size)
    sets = possible_sets(room, size, number)
    best = Chosen(np.zeros(len(size), np.int64), Placed(np.empty((0, 3)), 1.0))
    counted: dict[tuple[int, ...], int] = {}
    nearest: dict[tuple[int, ...], float] = {}
    tried = programmes = total = 0
    while time.time() < until:
        found = _following(best.numbers, sets, number, volume)
        left = [each for each in found if counted.get(each, 0) < tries]
        if not left:
            break
        # Each set is tried once; then those come first that came nearest to fitting.
        chosen = min(left, key=lambda each: _order(counted.get(each, 0), nearest.get(each, 0.0)))
        attempt = counted.get(chosen, 0)
        radius = np.repeat(size, chosen)
        own = np.random.SeedSequence(seed.entropy, spawn_key=(*seed.spawn_key, total))
        result = fits(room, radius, attempt, own, until)
        counted[chosen], total = attempt + 1, total + 1
        nearest[chosen] = max(nearest.get(chosen, 0.0), min(result.placed.factor, 1.0))
        tried, programmes = tried + result.tried, programmes + result.programmes
        if result.placed.factor >= FITS:
            best = Chosen(np.array(chosen), result.placed, tried, programmes, 1, total)
            yield best
        tell(Chosen(best.numbers, best.placed, tried, programmes, best.hits, total))
    yield Chosen(best.numbers, best.placed, tried, programmes, best.hits, total, time.time() < until)


def _order(attempts: int, nearest: float) -> tuple[bool, float]:
    """Return what sorts sets: those not tried yet, then those that came near and were tried seldom."""
    return attempts > 0, 0.01 * attempts - nearest


def _following(
    best: Int64Array, sets: Int64Array | None, number: Int64Array, volume: Float64Array
) -> list[tuple[int, ...]]:
    """Return sets of larger volume than the best one: of all the next ones, or of many its neighbours."""
    least = float(matrix_product(best, volume)) * (1.0 + BETTER)
    if sets is None:
        around = _neighbours(best, number)
        larger = around[matrix_product(around, volume) > least]
        order = np.argsort(matrix_product(larger, volume), kind="stable")
        return [tuple(each) for each in larger[order][:AT_ONCE].tolist()]
    larger = sets[matrix_product(sets, volume) > least]
    if not best.any():  # nothing is known yet: the smallest fit, and the middle ones may
        larger = larger[:: max(1, len(larger) // AT_ONCE)]
    return [tuple(each) for each in larger[::-1][:AT_ONCE].tolist()]


def _neighbours(best: Int64Array, number: Int64Array) -> Int64Array:
    """Return sets with a sphere more, or another one or two in place of one, shape (sets, S)."""
    step = np.eye(len(best), dtype=np.int64)
    more = best + step
    swapped = (best[None, None] - step[:, None] + step[None]).reshape(-1, len(best))
    twice = (swapped[:, None] + step[None]).reshape(-1, len(best))
    found = np.unique(np.concatenate([more, swapped, twice]), axis=0)
    return np.asarray(found[((found >= 0) & (found <= number)).all(axis=1)])
