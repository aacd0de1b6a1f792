"""Laws that count spheres: constant, uniform, normal, lognormal.

Truncated laws: Johnson, Kotz and Balakrishnan, Continuous Univariate Distributions, chapters 13 and 14.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache

import numpy as np
from typing_extensions import override

from packgen import portable
from packgen.arrays import Float64Array
from packgen.distributions.base import (
    UNIT_VOLUME,
    Distribution,
    ParameterError,
    StepLaw,
    check_bounds,
    clipped,
)

__all__ = ["Constant", "Lognormal", "Normal", "Uniform"]

CUT = 4.0  # standard deviations kept on each side where no bound is given
SIGMA_LIMIT = 5.0
PANELS = 128
TAIL = 38.0  # score beyond which the normal density is 0 in float64
PROBABILITY_LIMIT = 1.0e-6  # below it, differences of the normal integral lose their digits


@dataclass(frozen=True, eq=False)
class Constant(StepLaw):
    """Spheres of one size.

    Attributes:
        constant: The radius [m].
    """

    constant: float

    def __post_init__(self) -> None:
        if not 0.0 < self.constant < math.inf:
            raise ParameterError((("radius",), self.constant, "a radius greater than 0"))

    @property
    def radius(self) -> Float64Array:  # type: ignore[override]
        """The size [m], shape (1,)."""
        return np.array([self.constant])

    @property
    def number(self) -> Float64Array:  # type: ignore[override]
        """All spheres have it, shape (1,)."""
        return np.ones(1)


@dataclass(frozen=True)
class Uniform(Distribution):
    """Radii spread evenly by number between two bounds [m]; equal bounds give one size."""

    radius_min: float
    radius_max: float

    def __post_init__(self) -> None:
        if not 0.0 < self.radius_min <= self.radius_max < math.inf:
            expected = f"at least radius_min = {self.radius_min:g}"
            raise ParameterError((("radius_max",), self.radius_max, expected))

    @property
    @override
    def radius_bounds(self) -> tuple[float, float]:
        return self.radius_min, self.radius_max

    @override
    def mean_volume(self) -> float:
        low, high = self.radius_min, self.radius_max
        return UNIT_VOLUME * (low + high) * (low * low + high * high) / 4.0

    @override
    def cumulative_number(self, radius: Float64Array) -> Float64Array:
        low, high = self.radius_min, self.radius_max
        if low == high:
            return np.where(np.asarray(radius) >= high, 1.0, 0.0)
        return clipped((radius - low) / (high - low), 0.0, 1.0)

    @override
    def cumulative_mass(self, radius: Float64Array) -> Float64Array:
        low, high = self.radius_min, self.radius_max
        inside = clipped(radius, low, high)
        # (r^4 - a^4) / (b^4 - a^4), factored so that close bounds lose no digits.
        rest = (inside + low) * (inside**2 + low**2) / ((high + low) * (high**2 + low**2))
        return np.asarray(self.cumulative_number(radius) * rest)

    @override
    def quantile(self, share: Float64Array) -> Float64Array:
        radius = self.radius_min + share * (self.radius_max - self.radius_min)
        return clipped(radius, self.radius_min, self.radius_max)


class _Gaussian(Distribution):
    """What the truncated normal and lognormal laws share: a standard normal variable between two scores."""

    radius_min: float | None
    radius_max: float | None

    def _score(self, radius: Float64Array) -> Float64Array:
        """Return the standard normal score of each radius."""
        raise NotImplementedError

    def _radius(self, score: Float64Array) -> Float64Array:
        """Return the radius [m] of each score."""
        raise NotImplementedError

    def _mass_below(self, score: Float64Array) -> Float64Array:
        """Return the integral of r^3 over the normal density, from the lower bound to each score."""
        raise NotImplementedError

    def _mass_of_all(self) -> float:
        """Return that integral up to the upper bound, with the same digits on every machine."""
        raise NotImplementedError

    @property
    def _scores(self) -> tuple[float, float]:
        low, high = (float(each) for each in self._score(np.array(self.radius_bounds)))
        return low, high

    def _check(self) -> None:
        """Raise where the bounds leave nothing of the law."""
        check_bounds(*self.radius_bounds)
        low, high = self._scores
        probability = 0.5 * (math.erfc(-high / math.sqrt(2.0)) - math.erfc(-low / math.sqrt(2.0)))
        if probability < PROBABILITY_LIMIT:
            key = "radius_min" if low > 0.0 else "radius_max"
            expected = "bounds between which at least a millionth of the spheres is"
            raise ParameterError(((key,), getattr(self, key), expected))

    @override
    def mean_volume(self) -> float:
        low, high = self._scores
        number = portable.normal_integral(high) - portable.normal_integral(low)
        return UNIT_VOLUME * self._mass_of_all() / number

    @override
    def cumulative_number(self, radius: Float64Array) -> Float64Array:
        low, high = _integral(np.array(self._scores))
        inside = clipped(radius, *self.radius_bounds)
        return clipped((_integral(self._score(inside)) - low) / (high - low), 0.0, 1.0)

    @override
    def cumulative_mass(self, radius: Float64Array) -> Float64Array:
        inside = clipped(radius, *self.radius_bounds)
        total = self._mass_below(np.array([self._scores[1]]))
        return clipped(self._mass_below(self._score(inside)) / total, 0.0, 1.0)

    @override
    def quantile(self, share: Float64Array) -> Float64Array:
        low, high = (portable.normal_integral(score) for score in self._scores)
        radius = self._radius(portable.normal_quantile(low + share * (high - low)))
        return clipped(radius, *self.radius_bounds)


@dataclass(frozen=True)
class Normal(_Gaussian):
    """Normally distributed radii, truncated to bounds.

    Attributes:
        radius_mean: Mean before truncation [m].
        radius_std_dev: Standard deviation before truncation [m].
        radius_min: Lower bound [m]; None: four standard deviations below the mean, at least a tenth of it.
        radius_max: Upper bound [m]; None: four standard deviations above the mean.
    """

    radius_mean: float
    radius_std_dev: float
    radius_min: float | None = None
    radius_max: float | None = None

    def __post_init__(self) -> None:
        self._check()

    @property
    @override
    def radius_bounds(self) -> tuple[float, float]:
        mean, reach = self.radius_mean, CUT * self.radius_std_dev
        low = max(mean - reach, 0.1 * mean) if self.radius_min is None else self.radius_min
        return low, mean + reach if self.radius_max is None else self.radius_max

    def _score(self, radius: Float64Array) -> Float64Array:
        return np.asarray((radius - self.radius_mean) / self.radius_std_dev)

    def _radius(self, score: Float64Array) -> Float64Array:
        return self.radius_mean + self.radius_std_dev * score

    def _mass_below(self, score: Float64Array) -> Float64Array:
        # By quadrature: the closed recursion of truncated moments cancels where the bounds are close.
        low, high = np.clip(self._scores, -TAIL, TAIL)
        edge = np.linspace(low, high, PANELS + 1)
        inside = clipped(score, low, high)
        panel = np.clip(np.searchsorted(edge, inside, side="right") - 1, 0, PANELS - 1)
        below = np.concatenate([[0.0], np.cumsum(self._mass_between(edge[:-1], edge[1:]))])
        return np.asarray(below[panel] + self._mass_between(edge[panel], inside))

    def _mass_of_all(self) -> float:
        return float(self._mass_below(np.array([self._scores[1]]))[0])

    def _mass_between(self, low: Float64Array, high: Float64Array) -> Float64Array:
        """Return the integral of r^3 over the normal density between scores a panel apart; (n,) each."""
        point, weight = _gauss_legendre()
        half = 0.5 * (high - low)
        score = (low + half)[..., None] + half[..., None] * point
        return np.asarray(half * (_density(score) * portable.cube(self._radius(score)) * weight).sum(axis=-1))


@dataclass(frozen=True)
class Lognormal(_Gaussian):
    """Log-normally distributed radii, truncated to bounds.

    Attributes:
        radius_median: Median by number before truncation [m].
        sigma: Standard deviation of ln(radius) before truncation.
        radius_min: Lower bound [m]; None: four sigma below the median.
        radius_max: Upper bound [m]; None: four sigma above the median.
    """

    radius_median: float
    sigma: float
    radius_min: float | None = None
    radius_max: float | None = None

    def __post_init__(self) -> None:
        if not 0.0 < self.sigma <= SIGMA_LIMIT:
            expected = f"the standard deviation of ln(radius), greater than 0, at most {SIGMA_LIMIT:g}"
            raise ParameterError((("sigma",), self.sigma, expected))
        self._check()

    @property
    @override
    def radius_bounds(self) -> tuple[float, float]:
        factor = float(portable.exp(np.array(CUT * self.sigma)))
        low = self.radius_median / factor if self.radius_min is None else self.radius_min
        return low, self.radius_median * factor if self.radius_max is None else self.radius_max

    def _score(self, radius: Float64Array) -> Float64Array:
        return portable.log(np.asarray(radius) / self.radius_median) / self.sigma

    def _radius(self, score: Float64Array) -> Float64Array:
        return self.radius_median * portable.exp(self.sigma * score)

    def _mass_below(self, score: Float64Array) -> Float64Array:
        shift = 3.0 * self.sigma
        part = _integral(score - shift) - _integral(np.array(self._scores[0] - shift))
        return np.asarray(self._mass_scale * part)

    def _mass_of_all(self) -> float:
        low, high = (score - 3.0 * self.sigma for score in self._scores)
        return self._mass_scale * (portable.normal_integral(high) - portable.normal_integral(low))

    @property
    def _mass_scale(self) -> float:
        """Integral of r^3 over the whole law before truncation [m3]."""
        growth = float(portable.exp(np.array(4.5 * self.sigma * self.sigma)))
        return portable.scalar_power(self.radius_median, 3) * growth


@cache
def _gauss_legendre() -> tuple[Float64Array, Float64Array]:
    """Return the eight points and weights of Gauss-Legendre quadrature on -1 to 1."""
    point, weight = np.polynomial.legendre.leggauss(8)
    return point, weight


def _integral(score: Float64Array) -> Float64Array:
    """Return the standard normal integral up to each score."""
    from scipy.special import ndtr

    return np.asarray(ndtr(score))


def _density(score: Float64Array) -> Float64Array:
    """Return the standard normal density at each score."""
    return portable.exp(-0.5 * score * score) / math.sqrt(2.0 * math.pi)
