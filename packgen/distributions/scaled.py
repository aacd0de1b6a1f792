"""A law of sizes, all of them multiplied by a factor."""

from __future__ import annotations

import numpy as np
from typing_extensions import override

from packgen.arrays import Float64Array
from packgen.distributions.base import Distribution, StepLaw
from packgen.distributions.listed import Listed

__all__ = ["scaled"]


def scaled(law: Distribution, factor: float) -> Distribution:
    """Return the law of radii that are ``factor`` times those of another law."""
    if factor == 1.0:
        return law
    if isinstance(law, Listed):
        return Listed(law.radius * factor)
    return _ScaledSteps(law, factor) if isinstance(law, StepLaw) else _Scaled(law, factor)


class _ScaledSteps(StepLaw):
    """Sizes in steps, multiplied by a factor."""

    def __init__(self, law: StepLaw, factor: float) -> None:
        self.radius, self.number = law.radius * factor, law.number


class _Scaled(Distribution):
    """Any law, its sizes multiplied by a factor."""

    def __init__(self, law: Distribution, factor: float) -> None:
        self._law, self._factor = law, factor

    @property
    @override
    def radius_bounds(self) -> tuple[float, float]:
        low, high = self._law.radius_bounds
        return low * self._factor, high * self._factor

    @override
    def mean_volume(self) -> float:
        return self._law.mean_volume() * self._factor * self._factor * self._factor

    @override
    def cumulative_number(self, radius: Float64Array) -> Float64Array:
        return self._law.cumulative_number(radius / self._factor)

    @override
    def cumulative_mass(self, radius: Float64Array) -> Float64Array:
        return self._law.cumulative_mass(radius / self._factor)

    @override
    def quantile(self, share: Float64Array) -> Float64Array:
        return np.asarray(self._law.quantile(share) * self._factor)

    @override
    def sample(self, rng: np.random.Generator, count: int) -> Float64Array:
        return np.asarray(self._law.sample(rng, count) * self._factor)
