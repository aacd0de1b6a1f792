"""The sizes of a bed's spheres against those that were asked for, by number and by mass."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from packgen.arrays import Float64Array

SHARES = (0.05, 0.10, 0.25, 0.50, 0.75, 0.90, 0.95)


class SizeLaw(Protocol):
    """What the report needs of a size distribution."""

    @property
    def radius_bounds(self) -> tuple[float, float]:
        """Smallest and largest radius [m]."""

    def cumulative_number(self, radius: Float64Array) -> Float64Array:
        """Share of the spheres, by number, with radii up to ``radius`` [m]."""

    def cumulative_mass(self, radius: Float64Array) -> Float64Array:
        """Share of the spheres, by mass, with radii up to ``radius`` [m]."""


@dataclass(frozen=True, slots=True)
class SizeCurve:
    """One cumulative size curve, asked and reached.

    Attributes:
        share: Shares at which radii are given.
        asked: Radii [m] below which these shares are to lie; empty where nothing is known of what was asked.
        reached: Radii [m] below which these shares lie.
        distance_max: Largest difference of the two curves (Kolmogorov's distance); None where nothing was
            asked.
    """

    share: tuple[float, ...]
    asked: tuple[float, ...]
    reached: tuple[float, ...]
    distance_max: float | None


@dataclass(frozen=True, slots=True)
class Sizes:
    """Sizes of a particle set.

    Attributes:
        name: The set.
        count: Number of spheres.
        radius_min: Smallest radius [m].
        radius_mean: Mean radius by number [m].
        radius_max: Largest radius [m].
        by_number: Curve by number.
        by_mass: Curve by mass.
    """

    name: str
    count: int
    radius_min: float
    radius_mean: float
    radius_max: float
    by_number: SizeCurve
    by_mass: SizeCurve


def sizes(name: str, radius: Float64Array, law: SizeLaw | None) -> Sizes | None:
    """Compare radii with the distribution that they were drawn from.

    Args:
        name: Name of the set.
        radius: Radii of its spheres [m], shape (N,), float64.
        law: The distribution asked for; None where it is not known.

    Returns:
        The comparison; None for a set without spheres.
    """
    return sizes_of_classes(name, np.sort(radius), np.ones(len(radius)), law)


def sizes_of_classes(
    name: str, ordered: Float64Array, number: Float64Array, law: SizeLaw | None
) -> Sizes | None:
    """Compare classes of radii with the distribution that they were drawn from, as `sizes` does.

    Args:
        name: Name of the set.
        ordered: Radii in rising order [m], shape (K,), float64.
        number: How many spheres have each, shape (K,), float64.
        law: The distribution asked for; None where it is not known.
    """
    if len(ordered) == 0:
        return None
    count = float(number.sum())
    return Sizes(
        name=name,
        count=round(count),
        radius_min=float(ordered[0]),
        radius_mean=float((number * ordered).sum() / count),
        radius_max=float(ordered[-1]),
        by_number=_curve(ordered, number, law, law.cumulative_number if law else None),
        by_mass=_curve(ordered, number * ordered**3, law, law.cumulative_mass if law else None),
    )


def _curve(
    ordered: Float64Array,
    weight: Float64Array,
    law: SizeLaw | None,
    cumulative: Callable[[Float64Array], Float64Array] | None,
) -> SizeCurve:
    """Compare weighted radii in rising order with a cumulative curve."""
    share = np.cumsum(weight)
    share /= share[-1]
    place = np.minimum(np.searchsorted(share, np.array(SHARES) - 1e-12), len(ordered) - 1)
    reached = tuple(float(value) for value in ordered[place])
    if law is None or cumulative is None:
        return SizeCurve(SHARES, (), reached, None)
    asked = tuple(float(value) for value in _quantiles(cumulative, law.radius_bounds, np.array(SHARES)))
    return SizeCurve(SHARES, asked, reached, curve_distance(ordered, share, cumulative))


def curve_distance(
    ordered: Float64Array, share: Float64Array, cumulative: Callable[[Float64Array], Float64Array]
) -> float:
    """Return Kolmogorov's distance of a stepped curve from a distribution, which may have steps too.

    Args:
        ordered: Radii in rising order [m], shape (N,), float64.
        share: Share up to and with each radius, shape (N,), float64.
        cumulative: The distribution.

    Returns:
        Largest difference, from 0 to 1.
    """
    radius, last = np.unique(ordered[::-1], return_index=True)
    after = share[len(ordered) - 1 - last]
    before = np.concatenate([[0.0], after[:-1]])
    # A step of both curves at the same radius is no difference: compare on either side of it.
    above = np.abs(after - cumulative(radius))
    below = np.abs(before - cumulative(np.nextafter(radius, -np.inf)))
    return float(max(above.max(), below.max()))


def _quantiles(
    cumulative: Callable[[Float64Array], Float64Array], bounds: tuple[float, float], share: Float64Array
) -> Float64Array:
    """Return the radii [m] at which a cumulative curve reaches shares: by bisection; same shape."""
    low, high = (np.full(share.shape, bound) for bound in bounds)
    for _ in range(60):
        middle = 0.5 * (low + high)
        below = cumulative(middle) < share
        low, high = np.where(below, middle, low), np.where(below, high, middle)
    return high
