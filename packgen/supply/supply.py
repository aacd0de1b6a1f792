"""The spheres of a zone: how many of each set, with which radii, in which order; and those that come back.

Radii are drawn here and nowhere else. What a zone takes and does not place is put back and comes again with
the same radius, so that the radii of a complete zone are exactly the drawn ones. Spheres come and go in whole
bodies; without a column of bodies each sphere is one.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from copy import copy, deepcopy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from packgen.arrays import Float64Array, Int32Array, Int64Array, read_only
from packgen.bodies import are_in_rows, body_starts, joined_bodies
from packgen.distributions import UNIT_VOLUME, Free, Listed
from packgen.errors import PackingError
from packgen.portable import cube, cube_root, whole_power
from packgen.supply.close_packing import EQUAL_SPHERES, close_packing_fraction
from packgen.supply.fitting import Pool, SumFit, fit_by_amount, fit_by_number
from packgen.supply.mixtures import mixed_order
from packgen.supply.shares import (
    Amount,
    SizedSet,
    expected_count,
    free_sizes,
    largest_remainder,
    mean_weights,
    number_shares,
    set_amounts,
    size_weights,
)

__all__ = ["Draw", "Supply"]

BLOCK = 1024
COUNT_LIMIT = 2**31 - 1
QUANTILES = 1000


@dataclass(frozen=True, eq=False, slots=True)
class Draw:
    """Spheres taken from a supply.

    Attributes:
        radius: Radii [m], shape (k,), float64.
        set_index: Index of each sphere's particle set, shape (k,), int32.
        body_index: Body of each sphere, shape (k,), int32; spheres of one body have consecutive rows. None:
            each sphere is a body.
    """

    radius: Float64Array
    set_index: Int32Array
    body_index: Int32Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "radius", read_only(self.radius, np.float64, (None,), "draw.radius"))
        shape = (len(self.radius),)
        object.__setattr__(self, "set_index", read_only(self.set_index, np.int32, shape, "draw.set_index"))
        if self.body_index is not None:
            body_index = read_only(self.body_index, np.int32, shape, "draw.body_index")
            if not are_in_rows(body_index):
                raise ValueError("draw.body_index: a body comes in two places, expected consecutive rows")
            object.__setattr__(self, "body_index", body_index)

    @property
    def body_count(self) -> int:
        """Number of bodies; that of spheres where each is a body."""
        return len(self.radius) if self.body_index is None else len(body_starts(self.body_index))

    def split(self, count: int) -> tuple[Draw, Draw]:
        """Return the first bodies, up to a number, and the others."""
        row = count
        if self.body_index is not None:
            starts = body_starts(self.body_index)
            row = int(starts[count]) if count < len(starts) else len(self.radius)
        bodies = (None, None) if self.body_index is None else (self.body_index[:row], self.body_index[row:])
        return (
            Draw(self.radius[:row], self.set_index[:row], bodies[0]),
            Draw(self.radius[row:], self.set_index[row:], bodies[1]),
        )


class Supply:
    """The spheres still to be placed in a zone.

    A zone with a number, a solid volume or a mass has all its radii drawn here and now, and mixed. A zone
    without draws as it goes; the proportions hold at every moment for all spheres drawn so far. A zone
    without an amount that uses a file of radii ends when the file does.

    Attributes:
        asked: Number of spheres; None: until the zone is full.
        drawn_count: Number of different spheres handed out so far, or all where ``asked`` is known.
        mean_volume: Mean volume of a sphere [m3].
        radius_by_volume: Mean radius, each sphere counted by its volume [m].
        radius_min: Smallest radius that will come [m].
        radius_max: Largest radius that will come [m].
        shares: Share of each set by number, shape (sets,).
        counts: Number of spheres of each set, shape (sets,), int64; None where ``asked`` is None.
        fit: How closely the spheres add up to the volume or mass asked for; None: to none.
        free: Bounds of the sizes where these are to be those of the voids: all radii drawn are the least one,
            and stand for spheres still to be sized. None: radii are as drawn.
        fill_set: Set of free sizes of which the zone draws nothing: an algorithm may fill voids with its
            spheres. None: there is none.
    """

    def __init__(self, zone: Amount, particle_sets: Sequence[SizedSet], rng: np.random.Generator) -> None:
        """Draw the spheres of a zone.

        Args:
            zone: How much of which sets.
            particle_sets: The sets, in the order of the zone's proportions.
            rng: Source of randomness; the supply goes on using it.

        Raises:
            PackingError: The zone asks for more spheres than 2^31 - 1.
        """
        self._sets, self._rng = tuple(particle_sets), rng
        self.shares = number_shares(zone, particle_sets)
        self.free = free_sizes(zone, particle_sets)
        self.fill_set = next(
            (
                index
                for index, (each, share) in enumerate(zip(particle_sets, self.shares, strict=True))
                if share == 0.0 and isinstance(each.distribution, Free)
            ),
            None,
        )
        self._count_by_set = np.zeros(len(self._sets), dtype=np.int64)
        self._stock = [np.empty(0) for _ in self._sets]
        self._queue: deque[Draw] = deque()
        self._body_sizes: dict[int, int] = {}
        self.fit: SumFit | None = None
        draw = self._draw_amount(zone)
        self.counts = None if draw is None else np.bincount(draw.set_index, minlength=len(self._sets))
        self.asked = None if draw is None else len(draw.radius)
        self.drawn_count = self.asked or 0
        if draw is not None:
            self._queue.append(draw)
        self._set_sizes(draw)

    @property
    def remaining(self) -> int | None:
        """Number of bodies still to be placed; None: endless."""
        return None if self.asked is None else sum(each.body_count for each in self._queue)

    @property
    def finished(self) -> bool:
        """Whether no body is left."""
        return self.remaining == 0

    @property
    def radius_reference(self) -> float:
        """Radius of a sphere of mean volume [m]."""
        return cube_root(self.mean_volume / UNIT_VOLUME)

    @property
    def broad(self) -> bool:
        """Whether sizes differ by more than a factor of two: large spheres then choose their places first."""
        return self.radius_max > 2.0 * self.radius_min

    @cached_property
    def close_packing(self) -> float:
        """Solid fraction of a random close packing of these spheres."""
        return close_packing_fraction(*self._sizes)

    def solid_fraction(self, alone: float) -> float:
        """Return the solid fraction of a bed of these spheres where that of equal ones is ``alone``.

        A bed is taken to be as far below random close packing, in proportion, as that of equal spheres.
        """
        return alone * (self.close_packing / EQUAL_SPHERES)

    def take(self, count: int) -> Draw:
        """Return the next bodies: those put back come first.

        Args:
            count: How many bodies, at least 0.

        Returns:
            The spheres of ``count`` bodies, or of all that are left.
        """
        parts: list[Draw] = []
        missing = count
        while missing > 0 and self._queue:
            part, rest = self._queue.popleft().split(missing)
            parts.append(part)
            if len(rest.radius):
                self._queue.appendleft(rest)
            missing -= part.body_count
        if missing > 0 and self.asked is None:
            parts.append(self._draw_more(missing))
            self.drawn_count += missing
        draw = _joined(parts)
        self._body_sizes.update(_sizes_of(draw))
        return draw

    def put_back(self, draw: Draw) -> None:
        """Return bodies that found no place: they come first next time.

        Args:
            draw: Whole bodies, with the numbers that they were handed out with.

        Raises:
            ValueError: The draw holds a part of a body that was handed out.
        """
        for body, size in _sizes_of(draw).items():
            whole = self._body_sizes.get(body, size)
            if size != whole:
                raise ValueError(
                    f"put_back: found {size} spheres of body {body}, expected all {whole}; "
                    "put whole bodies back"
                )
        if len(draw.radius):
            self._queue.appendleft(draw)

    def offered(self) -> None:
        """Take all that was asked for as an offer: what was not chosen is not missing."""
        self.asked = self.counts = self.fit = None

    def add_made(self, set_index: int, count: int) -> None:
        """Count spheres of a set that an algorithm has sized and placed: they count as asked for, too."""
        self.drawn_count += count
        if self.asked is not None and self.counts is not None:
            self.asked += count
            self.counts = self.counts + np.where(np.arange(len(self._sets)) == set_index, count, 0)

    def copy(self) -> Supply:
        """Return a supply that goes on as this one would, and leaves this one as it is."""
        other = copy(self)
        other._rng, other._count_by_set = deepcopy(self._rng), self._count_by_set.copy()
        other._stock, other._queue = list(self._stock), deque(self._queue)
        return other

    def go_on_from(self, other: Supply) -> None:
        """Take the place of a copy of this supply from which spheres were taken."""
        self.__dict__.update(other.copy().__dict__)

    def split(self, shares: Sequence[float]) -> list[Supply]:
        """Return supplies that together hold what is left, each with its share and randomness of its own.

        Args:
            shares: Share of each, adding up to 1. Spheres are divided by largest remainder, in the mixed
                order; an endless supply has no spheres to divide, its parts draw by the same laws.
        """
        generators = deepcopy(self._rng).spawn(len(shares))
        parts = [self.copy() for _ in shares]
        for part, generator in zip(parts, generators, strict=True):
            part._rng = generator
        if self.asked is None:
            return parts
        rest = self.copy().take(self.remaining or 0)
        ends = np.cumsum(largest_remainder(np.asarray(shares, np.float64), len(rest.radius)))
        for part, end, start in zip(parts, ends, [0, *ends[:-1]], strict=True):
            own = Draw(rest.radius[start:end], rest.set_index[start:end])
            part._queue = deque([own] if len(own.radius) else [])
            part.asked = part.drawn_count = len(own.radius)
            part.counts, part.fit = np.bincount(own.set_index, minlength=len(self._sets)), None
        return parts

    def _draw_amount(self, zone: Amount) -> Draw | None:
        """Draw everything that a zone asks for; None: it asks for no amount."""
        expected = expected_count(zone, self._sets)
        if expected is not None and expected > COUNT_LIMIT:
            raise PackingError(
                f"a zone asks for about {expected:.3g} spheres, expected at most {COUNT_LIMIT}; "
                "check the unit of its amount and of the radii"
            )
        if zone.n_particles is not None:
            return self._draw_count(zone.n_particles)
        if expected is not None:
            wanted = zone.volume if zone.volume is not None else zone.mass
            return self._draw_sum(
                zone, "mass" if zone.volume is None else "volume", wanted or 0.0, round(expected)
            )
        lists = [
            (each.distribution.count, share)
            for each, share in zip(self._sets, self.shares, strict=True)
            if share > 0.0 and isinstance(each.distribution, Listed)
        ]
        # Rounded to nine digits first: 300 spheres at a share of 0.3 are 1000, not 999.
        total = min((int(round(count / share, 9)) for count, share in lists), default=None)
        return None if total is None else self._draw_count(total)

    def _draw_count(self, count: int) -> Draw:
        """Draw a number of spheres, divided among the sets by largest remainder."""
        counts = largest_remainder(self.shares, count)
        return self._mixed(counts, [self._radii(index, int(each)) for index, each in enumerate(counts)])

    def _draw_sum(self, zone: Amount, by: str, wanted: float, count: int) -> Draw:
        """Draw spheres whose volumes [m3] or masses [kg] add up to what is wanted, each set with its share.

        About the right number is drawn, and spare ones. One set alone meets the sum to half its smallest
        sphere.
        """
        pools = self._pools(by, largest_remainder(self.shares, count))
        used = np.flatnonzero(self.shares > 0.0)
        if len(used) > 1 and zone.proportions_by == "number":
            fit_by_number([pools[each] for each in used], self.shares[used], count, wanted)
        else:
            fit_by_amount(pools, set_amounts(zone, self._sets))
        smallest = min(pools[each].smallest for each in used)
        self.fit = SumFit(by, wanted, sum(pool.total for pool in pools), 0.5 * smallest, len(used) > 1)
        radii = [pool.chosen for pool in pools]
        return self._mixed(np.array([len(each) for each in radii]), radii)

    def _pools(self, by: str, counts: Int64Array) -> list[Pool]:
        """Draw a number of spheres of each set, and spare ones."""
        used = self.shares > 0.0
        reserve = np.where(used, np.maximum(BLOCK * self.shares, 1.0), 0.0).astype(np.int64)
        if used.sum() > 1:
            # The spheres drawn from a broad law are far from the expected sum: the count has to give way.
            reserve = np.where(used, np.maximum(BLOCK, counts // 2), 0)
        pools = []
        for index, each in enumerate(self._sets):
            law, count = each.distribution, int(counts[index])
            density = each.density if by == "mass" else 1.0
            if isinstance(law, Listed):
                order = self._rng.permutation(law.radius)
                order = order if self.shares[index] > 0.0 else order[:0]
                pools.append(Pool(order[:count], order[count:], density, once=True))
            else:
                drawn, spare = self._radii(index, count), self._radii(index, int(reserve[index]))
                pools.append(Pool(drawn, spare, density, once=False))
        return pools

    def _draw_more(self, count: int) -> Draw:
        """Draw the next spheres of an endless zone: each set gets what it is short of."""
        quota = self.shares * (int(self._count_by_set.sum()) + count)
        short = np.maximum(quota - self._count_by_set, 0.0)
        counts = largest_remainder(short / short.sum(), count)
        self._count_by_set += counts
        return self._mixed(counts, [self._from_stock(index, int(each)) for index, each in enumerate(counts)])

    def _from_stock(self, index: int, count: int) -> Float64Array:
        """Return radii of a set from stratified blocks: few at a time follow the law as well as many."""
        while len(self._stock[index]) < count:
            block = self._radii(index, max(BLOCK, count))
            self._stock[index] = np.concatenate([self._stock[index], block])
        taken, self._stock[index] = np.split(self._stock[index], [count])
        return taken

    def _radii(self, index: int, count: int) -> Float64Array:
        return self._sets[index].distribution.sample(self._rng, count)

    def _mixed(self, counts: Int64Array, radii: list[Float64Array]) -> Draw:
        set_index = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
        radius = np.concatenate(radii)
        order = mixed_order(radius, set_index, self._rng)
        return Draw(radius[order], set_index[order])

    def _set_sizes(self, draw: Draw | None) -> None:
        """Keep the sizes that will come: those drawn, or those that the laws allow."""
        if draw is not None and len(draw.radius):
            volume = cube(draw.radius)
            self.mean_volume = float(UNIT_VOLUME * np.mean(volume))
            self.radius_by_volume = float(np.mean(whole_power(draw.radius, 4)) / np.mean(volume))
            self.radius_min, self.radius_max = float(draw.radius.min()), float(draw.radius.max())
            self._sizes: tuple[Float64Array, Float64Array | None] = (draw.radius, None)
            return
        used = [each for each, share in zip(self._sets, self.shares, strict=True) if share > 0.0]
        self.mean_volume = float((self.shares * mean_weights("volume", self._sets)).sum())
        level = (np.arange(QUANTILES) + 0.5) / QUANTILES
        radius = np.stack([each.distribution.quantile(level) for each in used])
        volume = self.shares[self.shares > 0.0, None] * cube(radius)
        self.radius_by_volume = float((volume * radius).sum() / volume.sum())
        self.radius_min = min(each.distribution.radius_bounds[0] for each in used)
        self.radius_max = max(each.distribution.radius_bounds[1] for each in used)
        self._sizes = size_weights(self.shares, self._sets)


def _joined(parts: list[Draw]) -> Draw:
    if len(parts) == 1:
        return parts[0]
    radius = np.concatenate([np.empty(0), *(each.radius for each in parts)])
    set_index = np.concatenate([np.empty(0, dtype=np.int32), *(each.set_index for each in parts)])
    bodies = joined_bodies([each.body_index for each in parts], [len(each.radius) for each in parts])
    return Draw(radius, set_index, bodies)


def _sizes_of(draw: Draw) -> dict[int, int]:
    """Return the number of spheres of each body by its number; none where each sphere is a body."""
    if draw.body_index is None:
        return {}
    starts = body_starts(draw.body_index)
    sizes = np.diff(starts, append=len(draw.radius))
    return dict(zip(draw.body_index[starts].tolist(), sizes.tolist(), strict=True))
