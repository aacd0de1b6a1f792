"""Spheres dispersed in a zone: started at random, parted, and stirred until they are a hard-sphere fluid."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.dispersed.crowding import Room
from packgen.arrange.dispersed.part_kernels import part
from packgen.arrange.dispersed.starts import start_classes, starts_of, voids
from packgen.arrange.dispersed.stir_kernels import DIAGONAL, crowded, stir
from packgen.arrange.projection.pair_rules import push_weights
from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.compiled import signals_heard
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube, cube_root

LOOSE_FRACTION = 0.59
"""Solid fraction that equal spheres, enlarged while they are parted, reach in few sweeps."""

FULL_FRACTION = 0.55
"""Solid fraction away from the walls at which equal spheres fill a zone; more are added a few at a time."""

ENLARGED_MAX = 0.12
"""Most by which they are enlarged: parted spheres then are about as far apart as those of a fluid, and small
moves have little left to even out. Parted just so far that none overlaps, pairs that touch would stay."""

ENLARGED_LAST = (0.3, 0.05, 0.002)
"""Shares of that with which they are parted again where some still overlap."""

SWEEPS, SWEEPS_AGAIN = 600, 150
"""Sweeps of one parting, and of one after some spheres were taken out."""

A_FEW = 0.03
"""Share of the spheres that is added to a full zone at a time, or taken out where some overlap for good."""

THROWS_MAX = 20
"""Times that some are taken out."""

SKIN_PARTING, SKIN_STIRRING = 0.6, 1.8
"""Skins of the neighbour lists: a longer one costs each round more, and lasts for more rounds."""

STIRRED_AT, STIRRED = (0.0, 0.3, 0.45, 0.5, 0.55), (25.0, 30.0, 90.0, 450.0, 600.0)
"""Solid fractions, and rounds of small moves from parted equal spheres to a fluid: g(r) is that of hard
spheres to its noise below 0.45. Other sizes take as many at the same share of what they can reach."""

MIXING = 20
"""Rounds of moves before spheres that found no place are tried in other voids."""

TAKEN = 0.35
"""Share of the moves that are to be taken; the steps are made so long."""

STEP_FIRST, STEP_MAX = 0.12, 0.45
"""First and longest step along an axis, in radii."""

ADAPTED, ADAPTED_EVERY = 20, 5
"""Rounds over which the steps are fitted, and rounds from one fit to the next."""

STALLED_MAX = 3
"""Tries in a row without a gain after which what is left finds no place."""

TRIES_MAX = 60

STEPS_MAX = 5_000_000
"""Spheres times sweeps of one run of a compiled loop: a signal waits for its end."""


class Dispersion:
    """The spheres of a zone while they are dispersed.

    Attributes:
        room: The space.
        half: See ``Crowd``, shape (M,), of the zone's own spheres.
        wall: See ``Crowd``, shape (M,).
        fraction: Solid fraction away from the walls of spheres as large as their distances.
        enlarged: How much larger they are while they are parted, as a fraction.
        center: Their centres [m], shape (M, 3).
        kept: Which have a place, shape (M,).
    """

    def __init__(
        self, room: Room, half: Float64Array, wall: Float64Array, loose: float, rng: np.random.Generator
    ) -> None:
        self.room, self.half, self.wall, self._rng = room, half, wall, rng
        self._like_equal = LOOSE_FRACTION / loose
        full = FULL_FRACTION / self._like_equal
        most = int(np.searchsorted(np.cumsum(UNIT_VOLUME * cube(half)), room.solid(full, half, wall)))
        self._first = max(most, 1)
        self.fraction = min(room.fraction(half, wall), loose)
        ratio = cube_root(max(loose / self.fraction, 1.0))
        self.enlarged = min(max(ratio - 1.0, 0.01), ENLARGED_MAX)
        self.center = np.empty((len(half), 3))
        self.kept = np.zeros(len(half), bool)
        self._state = rng.integers(0, 2**64, 1, np.uint64)

    def start(self) -> None:
        """Give spheres their places, the large ones first, until the zone is full."""
        for members in start_classes(self.half[: self._first]):
            placed = np.flatnonzero(self.kept)
            points = starts_of(
                self.room,
                (self.half[members], self.wall[members]),
                (self.center[placed], self.half[placed]),
                self.fraction,
                self._rng,
            )
            chosen = members[: len(points)]
            self.center[chosen] = points
            self.kept[chosen] = True
            self._part(np.flatnonzero(self.kept), 0.25 if len(chosen) < self._first else 1.0)
        self._drop_crowded()

    def retry(self) -> None:
        """Try the spheres without a place in the largest voids until no more of them find one."""
        stalled = 0
        for _ in range(TRIES_MAX):
            missing = np.flatnonzero(~self.kept)
            if len(missing) == 0 or stalled == STALLED_MAX:
                return
            if self.kept.any():
                self.stir(MIXING)
            missing = missing[np.argsort(-self.half[missing], kind="stable")]
            missing = missing[: max(round(A_FEW * self.kept.sum()), 1)]
            placed = np.flatnonzero(self.kept)
            points = voids(
                self.room,
                self.half[missing],
                float(self.wall[missing].min()),
                (
                    np.concatenate([self.center[placed], self.room.fixed_center]),
                    np.concatenate([self.half[placed], self.room.fixed_half]),
                ),
                self._rng,
            )
            before = self.center.copy(), self.kept.copy()
            self.center[missing[: len(points)]] = points
            self.kept[missing[: len(points)]] = True
            self._drop_crowded()
            stalled += 1
            if self.kept.sum() > before[1].sum():
                stalled = 0
            else:
                self.center, self.kept = before

    def settle_rounds(self) -> int:
        """Return how many rounds of moves make a fluid of the spheres as they are now."""
        return round(float(np.interp(self.fraction * self._like_equal, STIRRED_AT, STIRRED)))

    def stir(self, rounds: int, tell: Callable[[float], None] = lambda _: None) -> None:
        """Move the spheres that have a place, each ``rounds`` times; all keep their distances.

        Args:
            rounds: Moves tried of each.
            tell: Called with the share of them that is done.
        """
        members = np.flatnonzero(self.kept)
        if len(members) == 0:
            return
        center, half, wall = self._crowd(members)
        mean, skin = float(half[: len(members)].mean()), SKIN_STIRRING
        margin = 0.5 * skin * np.sqrt(mean * half[: len(members)])
        longest = np.minimum(STEP_MAX * half[: len(members)], 0.9 * margin / DIAGONAL)
        groups = np.zeros(len(members), np.int64)
        for number, group in enumerate(start_classes(half[: len(members)])):
            groups[group] = number
        step = np.minimum(STEP_FIRST * half[: len(members)], longest)
        done = 0
        while done < rounds:
            most = max(STEPS_MAX // len(members), 1)
            count = min(ADAPTED_EVERY if done < ADAPTED else most, most, rounds - done)
            with signals_heard():
                taken = stir(center, half, wall, self.room.region.walls, step, count, skin, self._state)
            if done < ADAPTED:
                step = _fitted(step, longest, groups, taken, count)
            done += count
            tell(done / rounds)
        self.center[members] = center[: len(members)]

    def _crowd(self, members: Int64Array) -> tuple[Float64Array, Float64Array, Float64Array]:
        """Return the columns of a ``Crowd`` of some spheres and of those that were there before."""
        return (
            np.concatenate([self.center[members], self.room.fixed_center]),
            np.concatenate([self.half[members], self.room.fixed_half]),
            self.wall[members],
        )

    def _part(self, members: Int64Array, share: float, sweeps_max: int = SWEEPS) -> None:
        """Part some spheres, enlarged by a share of ``enlarged``, in so many sweeps at most."""
        if len(members) == 0:
            return
        center, half, wall = self._crowd(members)
        larger = 1.0 + share * self.enlarged
        ball = np.column_stack([center, half])
        weight = push_weights(ball, len(members), float(half[: len(members)].mean()))
        calm = 0.9 * (larger - 1.0) / larger
        left, most = sweeps_max, max(STEPS_MAX // len(members), 1)
        while left > 0:
            with signals_heard():
                sweeps, worst = part(
                    center, half * larger, wall * larger, weight, self.room.region.walls,
                    min(left, most), SKIN_PARTING, calm,
                )  # fmt: skip
            left -= sweeps
            if worst <= calm:
                break
        self.center[members] = center[: len(members)]

    def _drop_crowded(self) -> None:
        """Part what overlaps, and take out what has no room, a few at a time: that leaves others theirs."""
        members = np.flatnonzero(self.kept)
        shares = (0.0, *ENLARGED_LAST)
        for number in range(len(shares) + THROWS_MAX):
            if len(members) == 0:
                return
            share = shares[min(number, len(shares) - 1)]
            if share:
                self._part(members, share, SWEEPS if number < len(shares) else SWEEPS_AGAIN)
            gone = np.flatnonzero(self._gone(members))
            if len(gone) == 0:
                return
            if share == ENLARGED_LAST[-1]:
                most = max(1, min(len(gone) // 4, round(A_FEW * len(members))))
                self.kept[members[gone[:: -(-len(gone) // most)]]] = False
                members = np.flatnonzero(self.kept)
        if len(members):
            self.kept[members[self._gone(members)]] = False

    def _gone(self, members: Int64Array) -> BoolArray:
        """Tell which of some spheres have to go so that the others keep their distances, shape (m,)."""
        center, half, wall = self._crowd(members)
        with signals_heard():
            gone = crowded(center, half, wall, self.room.region.walls)
        self.center[members] = center[: len(members)]
        return np.asarray(gone | ~self.room.region.holds(self.center[members]))


def _fitted(
    step: Float64Array,
    longest: Float64Array,
    groups: Int64Array,
    taken: NDArray[np.int64],
    count: int,
) -> Float64Array:
    """Return steps of which about the wanted share is taken, group by group, shape (m,)."""
    share = np.bincount(groups, taken) / (count * np.bincount(groups))
    factor = np.clip(share / TAKEN, 0.5, 1.5)
    return np.asarray(np.minimum(step * factor[groups], longest))
