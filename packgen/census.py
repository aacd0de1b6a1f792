"""A bed's spheres in short: how many of each set there are, how large they are, and how far they reach.

It is the same for a bed in one piece and for the same bed in many, to the last digit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from packgen.arrays import ExactSum, Float64Array, Int32Array


@dataclass(frozen=True, slots=True)
class Census:
    """Numbers, sizes and places of spheres, those by set as tuples of one entry a set.

    Attributes:
        counts: Number of spheres.
        radius_min: Smallest radius [m]; infinite of a set without spheres.
        radius_max: Largest radius [m]; 0 of a set without spheres.
        radius_sum: Sum of the radii [m].
        cube_sum: Sum of their third powers [m3].
        low: Least coordinates of the centres [m].
        high: Largest coordinates of the centres [m].
    """

    counts: tuple[int, ...]
    radius_min: tuple[float, ...]
    radius_max: tuple[float, ...]
    radius_sum: tuple[Fraction, ...]
    cube_sum: tuple[Fraction, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]

    @property
    def count(self) -> int:
        """Number of all spheres."""
        return sum(self.counts)

    @property
    def radius_mean(self) -> float:
        """Mean radius of all spheres [m]."""
        return float(sum(self.radius_sum, start=Fraction(0)) / self.count)

    def join(self, other: Census) -> Census:
        """Return the census of the spheres of both."""

        def by_set(name: str, choose: Any) -> tuple[Any, ...]:
            return tuple(map(choose, getattr(self, name), getattr(other, name)))

        def add(a: Any, b: Any) -> Any:
            return a + b

        return Census(
            by_set("counts", add), by_set("radius_min", min), by_set("radius_max", max),
            by_set("radius_sum", add), by_set("cube_sum", add), by_set("low", min), by_set("high", max),
        )  # fmt: skip

    def as_json(self) -> dict[str, Any]:
        """Return what `from_json` reads; sums are whole numbers and powers of two."""
        found: dict[str, Any] = {name: list(getattr(self, name)) for name in ("counts", "low", "high")}
        found["radius_min"] = [None if each == np.inf else each for each in self.radius_min]
        found["radius_max"] = list(self.radius_max)
        for name in ("radius_sum", "cube_sum"):
            found[name] = [
                [each.numerator, 1 - each.denominator.bit_length()] for each in getattr(self, name)
            ]
        return found

    @classmethod
    def from_json(cls, found: Mapping[str, Any]) -> Census:
        """Return a census from what `as_json` gave.

        Raises:
            KeyError: Something is missing.
            TypeError: Something is of another kind.
            ValueError: Likewise.
        """
        sums = {
            name: tuple(int(whole) * Fraction(2) ** int(power) for whole, power in found[name])
            for name in ("radius_sum", "cube_sum")
        }
        return cls(
            tuple(int(each) for each in found["counts"]),
            tuple(np.inf if each is None else float(each) for each in found["radius_min"]),
            tuple(float(each) for each in found["radius_max"]),
            sums["radius_sum"],
            sums["cube_sum"],
            tuple(float(each) for each in found["low"]),
            tuple(float(each) for each in found["high"]),
        )


def count_spheres(position: Float64Array, radius: Float64Array, set_index: Int32Array, sets: int) -> Census:
    """Return the census of spheres; numbers that are not finite count for no size and no place.

    Args:
        position: Centres [m], shape (N, 3).
        radius: Radii [m], shape (N,).
        set_index: Set of each sphere, shape (N,).
        sets: Number of sets.
    """
    least, most = np.full(sets, np.inf), np.zeros(sets)
    radius_sum: list[Fraction] = []
    cube_sum: list[Fraction] = []
    finite = np.isfinite(radius)
    place = position[np.isfinite(position).all(axis=1)]
    for each in range(sets):
        own = radius[finite if sets == 1 else finite & (set_index == each)]
        least[each], most[each] = own.min(initial=np.inf), own.max(initial=0.0)
        for sums, values in ((radius_sum, own), (cube_sum, own**3)):
            total = ExactSum()
            total.add(values)
            sums.append(total.exact())
    return Census(
        tuple(np.bincount(set_index, minlength=sets).tolist()),
        tuple(least.tolist()),
        tuple(most.tolist()),
        tuple(radius_sum),
        tuple(cube_sum),
        tuple(place.min(axis=0, initial=np.inf).tolist()),
        tuple(place.max(axis=0, initial=-np.inf).tolist()),
    )
