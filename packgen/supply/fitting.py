"""Spheres whose volumes or masses add up to what a zone asks for, each set keeping its share.

The shares come first, exact to the sphere. By number, the counts are those of a total; by volume or mass,
each set has an amount of its own. Then spheres are exchanged within their sets, drawn ones for spare ones of
the same law, until the sum is met or no exchange comes nearer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube
from packgen.supply.shares import largest_remainders

__all__ = ["Pool", "SumFit", "fit_by_amount", "fit_by_number"]

EXCHANGED_SHARE, EXCHANGES_MIN, EXCHANGES_MAX = 0.05, 4, 64
"""Largest share of the spheres that is exchanged, and bounds of that number: the sizes stay those of the law.
Many exchanges towards one sum would take its largest spheres only, or its smallest."""

TOTALS_MIN = 8
"""Least number of totals tried above and below the expected one; two more for each set."""

TOLD = 1.0e-6
"""Error, as a share of an amount, below which a sum counts as met: the smallest sphere of a broad law is far
less."""


@dataclass(frozen=True, slots=True)
class SumFit:
    """How closely the spheres of a zone add up to the amount that it asks for.

    Attributes:
        by: ``volume`` or ``mass``.
        wanted: The amount asked for [m3 or kg].
        found: The sum of the spheres drawn [m3 or kg].
        limit: Half the smallest sphere, the error that whole spheres allow [m3 or kg].
        shared: Whether several sets share the sum.
    """

    by: str
    wanted: float
    found: float
    limit: float
    shared: bool = False

    @property
    def missed(self) -> bool:
        """Whether the sum is off by more than half the smallest sphere, and by more than a millionth."""
        return abs(self.found - self.wanted) > max(self.limit * (1.0 + 1e-9), TOLD * self.wanted)


@dataclass(frozen=True, slots=True)
class _Move:
    """What is missing after a move [m3 or kg], and the chosen and the spare sphere that it moves."""

    missing: float
    removed: int | None = None
    added: int | None = None


NO_MOVE = _Move(np.inf)


class Pool:
    """The spheres of one set: chosen ones, and spare ones that may come instead.

    Attributes:
        radius: Radii of the chosen spheres and then of the spare ones [m], shape (n,).
        weight: Their volumes [m3] or masses [kg], shape (n,).
    """

    def __init__(self, chosen: Float64Array, spare: Float64Array, density: float, *, once: bool) -> None:
        """Take the spheres of a set.

        Args:
            chosen: Radii of the spheres drawn [m], shape (k,).
            spare: Radii of others of the same law [m], shape (m,).
            density: Factor on volumes: 1, or the density [kg/m3].
            once: Whether each spare sphere exists only once, as those of a file do.
        """
        self.radius = np.concatenate([chosen, spare])
        self.weight = UNIT_VOLUME * cube(self.radius) * density
        self._once = once
        self.choose(len(chosen))

    def choose(self, count: int) -> None:
        """Choose the first ``count`` spheres; all others are spare."""
        self._first = count
        self._keep = np.ones(count, dtype=bool)
        self._usable = np.ones(len(self.radius) - count, dtype=bool)
        self._added: list[int] = []

    def choose_sum(self, wanted: float) -> None:
        """Choose as many of the first spheres as come nearest to an amount [m3 or kg]; some stay spare."""
        most = len(self.weight) if self._once else (len(self.weight) + self._first) // 2
        sums = np.concatenate([[0.0], np.cumsum(self.weight[:most])])
        self.choose(int(np.argmin(np.abs(sums - wanted))))

    @property
    def chosen(self) -> Float64Array:
        """Radii of the chosen spheres [m]."""
        return np.concatenate(
            [self.radius[: self._first][self._keep], self.radius[self._first :][self._added]]
        )

    @property
    def total(self) -> float:
        """Sum of the chosen spheres [m3 or kg]."""
        kept = self.weight[: self._first]
        kept = kept if self._keep.all() else kept[self._keep]
        return float(kept.sum()) + float(self.weight[self._first :][self._added].sum())

    @property
    def smallest(self) -> float:
        """The smallest sphere, chosen or spare [m3 or kg]; infinite where there is none."""
        return float(self.weight.min(initial=np.inf))

    def fit(self, wanted: float) -> None:
        """Add, remove and exchange spheres until they add up to ``wanted`` to half the smallest.

        Spheres can run out before the sum is met only where each exists once.
        """
        missing, limit = wanted - self.total, 0.5 * self.smallest
        scarce = self._once and len(self._usable) > 0
        while abs(missing) > limit:
            move = self._single(missing)
            if scarce or not abs(move.missing) < abs(missing):
                move = min((move, self.exchange(missing)), key=lambda each: abs(each.missing))
            if not abs(move.missing) < abs(missing):
                break
            missing = move.missing
            self.apply(move)

    def _single(self, missing: float) -> _Move:
        """Return the best addition or removal."""
        adds = missing > 0.0
        weight = self.weight[self._first :] if adds else self.weight[: self._first]
        usable = self._usable if adds else self._keep
        if not usable.any():
            return NO_MOVE
        best = int(np.argmin(np.where(usable, np.abs(weight - abs(missing)), np.inf)))
        if adds:
            return _Move(missing - float(weight[best]), None, best)
        return _Move(missing + float(weight[best]), best, None)

    def exchange(self, missing: float) -> _Move:
        """Return the best exchange of a chosen sphere for a spare one."""
        out, into = np.flatnonzero(self._keep), np.flatnonzero(self._usable)
        if not len(out) or not len(into):
            return NO_MOVE
        spare = self.weight[self._first :]
        into = into[np.argsort(spare[into], kind="stable")]
        weight = spare[into]
        target = self.weight[: self._first][out] + missing
        above = np.clip(np.searchsorted(weight, target), 1 if len(weight) > 1 else 0, len(weight) - 1)
        below = np.maximum(above - 1, 0)
        near = np.where(np.abs(weight[above] - target) < np.abs(weight[below] - target), above, below)
        best = int(np.argmin(np.abs(weight[near] - target)))
        return _Move(float(target[best] - weight[near[best]]), int(out[best]), int(into[near[best]]))

    def apply(self, move: _Move) -> None:
        """Carry out a move."""
        if move.removed is not None:
            self._keep[move.removed] = False
        if move.added is not None:
            self._added.append(move.added)
            self._usable[move.added] = not self._once


def fit_by_amount(pools: Sequence[Pool], wanted: Float64Array) -> None:
    """Let each set meet an amount of its own, to half its smallest sphere, and more closely by exchanges.

    Args:
        pools: The sets.
        wanted: Amount of each [m3 or kg], shape (sets,); 0 or less than half a sphere: none of it.
    """
    used = [(pool, float(amount)) for pool, amount in zip(pools, wanted, strict=True) if amount > 0.0]
    alone = len(used) == 1
    for pool, amount in used:
        if not alone:
            pool.choose_sum(amount)
        pool.fit(amount)
    if not alone:
        limit = 0.5 * min(pool.smallest for pool, _ in used) / len(used)
        for pool, amount in used:
            _exchange([pool], amount, limit)


def fit_by_number(pools: Sequence[Pool], shares: Float64Array, count: int, wanted: float) -> None:
    """Choose the total whose shares come nearest to an amount; exchange spheres within the sets for the rest.

    Args:
        pools: The sets, each with its share of ``count`` chosen.
        shares: Share of each by number, shape (sets,), sum 1.
        count: The expected total.
        wanted: The amount [m3 or kg].
    """
    for pool, each in zip(pools, _nearest_counts(pools, shares, count, wanted), strict=True):
        pool.choose(int(each))
    _exchange(pools, wanted, 0.5 * min(pool.smallest for pool in pools))


def _nearest_counts(pools: Sequence[Pool], shares: Float64Array, count: int, wanted: float) -> Sequence[int]:
    """Return the counts of that total whose spheres, in the order drawn, come nearest to an amount."""
    sums = [np.concatenate([[0.0], np.cumsum(pool.weight)]) for pool in pools]
    missing = abs(wanted - sum(pool.total for pool in pools))
    around = TOTALS_MIN + 2 * len(pools) + 2 * int(np.ceil(missing * max(count, 1) / wanted))
    totals = np.arange(max(count - around, 0), count + around + 1)
    counts = largest_remainders(shares, totals)
    there = np.array([len(pool.weight) for pool in pools])
    possible = (counts <= there).all(axis=1)
    totals, counts = totals[possible], counts[possible]
    found = sum(each[column] for each, column in zip(sums, counts.T, strict=True))
    # The expected total wins over others that come equally near: rounding must not choose.
    off = np.abs(found - wanted)
    near = off <= off.min() + 1e-12 * wanted
    best = np.flatnonzero(near)[np.argmin(np.abs(totals[near] - count))]
    chosen: list[int] = counts[best].tolist()
    return chosen


def _exchange(pools: Sequence[Pool], wanted: float, limit: float) -> None:
    """Exchange spheres within their sets while that brings the sum nearer to an amount, to within a limit."""
    missing = wanted - sum(pool.total for pool in pools)
    most = EXCHANGED_SHARE * sum(len(pool.chosen) for pool in pools)
    for _ in range(int(np.clip(most, EXCHANGES_MIN, EXCHANGES_MAX))):
        if abs(missing) <= limit:
            return
        moves = [(pool.exchange(missing), pool) for pool in pools]
        move, pool = min(moves, key=lambda each: abs(each[0].missing))
        if not abs(move.missing) < abs(missing):
            return
        missing = move.missing
        pool.apply(move)
