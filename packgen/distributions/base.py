"""What every law of sizes can do, and how spheres are drawn from it."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from typing import Any

import numpy as np
from typing_extensions import override

from packgen.arrays import Float64Array
from packgen.portable import cube

__all__ = ["UNIT_VOLUME", "Distribution", "ParameterError", "StepLaw", "check_bounds", "clipped"]

UNIT_VOLUME = 4.0 / 3.0 * math.pi
"""Volume of a sphere of radius 1."""

Fault = tuple[tuple[str | int, ...], Any, str]


class ParameterError(ValueError):
    """Parameters that make no law of sizes.

    Attributes:
        faults: Where (names and indices), the value found, and what was expected.
    """

    def __init__(self, *faults: Fault) -> None:
        self.faults = faults
        texts = (
            f"{'.'.join(map(str, where))}: found {found}, expected {expected}"
            for where, found, expected in faults
        )
        super().__init__("; ".join(texts))


class Distribution(ABC):
    """A law of sphere radii: how many spheres, and how much of their mass, is below each radius."""

    @property
    @abstractmethod
    def radius_bounds(self) -> tuple[float, float]:
        """Smallest and largest radius [m], both finite and greater than 0."""

    @abstractmethod
    def mean_volume(self) -> float:
        """Return the mean volume of a sphere [m3]."""

    @abstractmethod
    def cumulative_number(self, radius: Float64Array) -> Float64Array:
        """Return the fraction of spheres with at most each radius [m]; same shape."""

    @abstractmethod
    def cumulative_mass(self, radius: Float64Array) -> Float64Array:
        """Return the fraction of mass in spheres with at most each radius [m]; same shape."""

    @abstractmethod
    def quantile(self, share: Float64Array) -> Float64Array:
        """Return the radius [m] below which each share (0 to 1) of the spheres is; same shape."""

    def sample(self, rng: np.random.Generator, count: int) -> Float64Array:
        """Draw radii in random order, one from each of ``count`` equally likely size classes.

        Stratified sampling (Cochran, Sampling Techniques, chapter 5): every sphere follows the law, and all
        together they follow it more closely than independent draws would. The few largest spheres of a sieve
        curve hold much of the mass. Their number is the expected one, give or take one.

        Args:
            rng: Source of randomness.
            count: Number of spheres, at least 0.

        Returns:
            Radii [m], shape (count,), float64.
        """
        share = (np.arange(count) + rng.random(count)) / max(count, 1)
        return self.quantile(rng.permutation(share))


class StepLaw(Distribution):
    """A law of a few sizes, or of a list of spheres.

    Attributes:
        radius: The sizes in rising order [m], shape (K,), float64.
        number: Fraction of spheres of each size, adding up to 1, shape (K,), float64.
    """

    radius: Float64Array
    number: Float64Array

    @property
    @override
    def radius_bounds(self) -> tuple[float, float]:
        used = self.radius[self.number > 0.0]
        return float(used[0]), float(used[-1])

    @override
    def mean_volume(self) -> float:
        return UNIT_VOLUME * float((self.number * cube(self.radius)).sum())

    @override
    def cumulative_number(self, radius: Float64Array) -> Float64Array:
        return self._steps(self.number, radius)

    @override
    def cumulative_mass(self, radius: Float64Array) -> Float64Array:
        return self._steps(self.number * cube(self.radius), radius)

    @override
    def quantile(self, share: Float64Array) -> Float64Array:
        upper = np.cumsum(self.number)
        used = np.flatnonzero(self.number > 0.0)
        index = np.searchsorted(upper[used] / upper[-1], share, side="right")
        return self.radius[used[np.minimum(index, len(used) - 1)]]

    @override
    def sample(self, rng: np.random.Generator, count: int) -> Float64Array:
        """Draw radii in random order; each size has its share of ``count``, rounded up or down.

        Systematic sampling: equally spaced shares with one random offset, so that the numbers of each size
        are as exact as whole spheres allow and still right on average.
        """
        share = (np.arange(count) + rng.random()) / max(count, 1)
        return self.quantile(rng.permutation(share))

    def _steps(self, weight: Float64Array, radius: Float64Array) -> Float64Array:
        total = np.concatenate([[0.0], np.cumsum(weight)])
        return np.asarray(total[np.searchsorted(self.radius, radius, side="right")] / total[-1])


def clipped(value: Float64Array, low: float, high: float) -> Float64Array:
    """Return values moved to the nearer of two bounds where they are outside."""
    return np.asarray(np.clip(value, low, high))


def check_bounds(radius_min: float, radius_max: float) -> None:
    """Raise where two bounds [m] enclose nothing.

    Raises:
        ParameterError: ``radius_min`` is not below ``radius_max``.
    """
    if not 0.0 < radius_min < radius_max:
        raise ParameterError((("radius_max",), radius_max, f"more than radius_min = {radius_min:g}"))
