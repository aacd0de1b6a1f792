"""Laws that weigh spheres: Rosin-Rammler and sieve curves, turned into numbers of spheres.

Where a mass fraction dF lies at radius r, there are dF / r^3 spheres (up to a constant): fine classes hold
nearly all spheres, coarse ones nearly all mass.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from typing_extensions import override

from packgen import portable
from packgen.arrays import Float64Array, Int64Array
from packgen.distributions.base import UNIT_VOLUME, Distribution, ParameterError, check_bounds, clipped

__all__ = ["RosinRammler", "Sieve"]

EXPONENT_MAX = 1000.0  # Rosin and Rammler's law is within a thousandth of one radius then
PANELS = 2048
SUM_SLACK = 1.0e-6


@dataclass(frozen=True, eq=False)
class _Panels:
    """A number density over ln(r), panel by panel.

    Attributes:
        node: Bounds of the panels in ln(r), shape (P + 1,).
        count: Spheres in each panel, shape (P,).
        below: Spheres below each bound, shape (P + 1,).
        slope: Logarithm of the density at a panel's end over that at its start, shape (P,).
    """

    node: Float64Array
    count: Float64Array
    below: Float64Array
    slope: Float64Array


@dataclass(frozen=True)
class RosinRammler(Distribution):
    """Rosin and Rammler's law (J. Inst. Fuel 7, 1933), truncated.

    The mass below r is 1 - exp(-(r / radius_63)^exponent) before truncation. The number of spheres below a
    radius is an incomplete gamma function of negative order; it is integrated panel by panel (Gauss-Legendre,
    8 points), and inside a panel its density follows a power of the radius. Cumulative curve and quantile are
    inverse to each other to rounding.

    Attributes:
        radius_63: Radius below which 63.2 % of the mass is before truncation [m].
        exponent: Uniformity; large: narrow.
        radius_min: Lower bound [m].
        radius_max: Upper bound [m].
    """

    radius_63: float
    exponent: float
    radius_min: float
    radius_max: float

    def __post_init__(self) -> None:
        check_bounds(self.radius_min, self.radius_max)
        if self.exponent > EXPONENT_MAX:
            expected = f"at most {EXPONENT_MAX:g}; for radii all alike use the law constant"
            raise ParameterError((("exponent",), self.exponent, expected))
        low, high = self._reduced(np.array(self.radius_bounds))
        # In reduced mass t = (r / radius_63)^exponent, the mass density is exp(-t).
        if not portable.exp(-low) - portable.exp(-high) > 1.0e-9:
            key = "radius_min" if low > 1.0 else "radius_max"
            expected = "bounds between which at least a billionth of the mass is"
            raise ParameterError(((key,), getattr(self, key), expected))

    @property
    @override
    def radius_bounds(self) -> tuple[float, float]:
        return self.radius_min, self.radius_max

    @override
    def mean_volume(self) -> float:
        return UNIT_VOLUME * portable.scalar_power(self.radius_63, 3) / float(self._panels.below[-1])

    @override
    def cumulative_mass(self, radius: Float64Array) -> Float64Array:
        low, high = self._reduced(np.array(self.radius_bounds))
        inside = self._reduced(clipped(radius, *self.radius_bounds))
        return np.asarray(portable.expm1(low - inside) / portable.expm1(low - high) + 0.0)

    @override
    def cumulative_number(self, radius: Float64Array) -> Float64Array:
        table = self._panels
        inside = portable.log(clipped(radius, *self.radius_bounds))
        panel = _panel(table.node, inside)
        part = (inside - table.node[panel]) / (table.node[panel + 1] - table.node[panel])
        share = portable.expm1(table.slope[panel] * part) / portable.expm1(table.slope[panel])
        return clipped((table.below[panel] + share * table.count[panel]) / table.below[-1], 0.0, 1.0)

    @override
    def quantile(self, share: Float64Array) -> Float64Array:
        table = self._panels
        wanted = np.asarray(share) * table.below[-1]
        panel = _panel(table.below, wanted)
        count = np.where(table.count[panel] > 0.0, table.count[panel], 1.0)
        part = clipped((wanted - table.below[panel]) / count, 0.0, 1.0)
        part = portable.log1p(part * portable.expm1(table.slope[panel])) / table.slope[panel]
        radius = portable.exp(table.node[panel] + part * (table.node[panel + 1] - table.node[panel]))
        return clipped(radius, *self.radius_bounds)

    def _reduced(self, radius: Float64Array) -> Float64Array:
        return portable.power(radius / self.radius_63, self.exponent)

    @cached_property
    def _panels(self) -> _Panels:
        """Panels over the whole law."""
        node = self._nodes()
        point, weight = np.polynomial.legendre.leggauss(8)
        width = np.diff(node)
        inner = node[:-1, None] + 0.5 * width[:, None] * (1.0 + point)
        count = 0.5 * width * (self._number_density(inner) * weight).sum(axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            slope = np.diff(portable.log(self._number_density(node)))
        slope = np.clip(np.nan_to_num(slope, nan=0.0), -500.0, 500.0)
        # expm1(s x) / expm1(s) tends to x; a slope of exactly 0 would divide by it.
        slope = np.where(np.abs(slope) < 1.0e-9, 1.0e-9, slope)
        return _Panels(node, count, np.concatenate([[0.0], np.cumsum(count)]), slope)

    def _nodes(self) -> Float64Array:
        """Return panel bounds in ln(r), even both in ln(r) and in mass, so that no peak is missed."""
        low, high = portable.log(np.array(self.radius_bounds))
        reduced_low, reduced_high = self._reduced(np.array(self.radius_bounds))
        share = np.linspace(0.0, 1.0, PANELS + 1)[1:-1]
        reduced = reduced_low - portable.log1p(share * portable.expm1(reduced_low - reduced_high))
        by_mass = portable.log(np.array(self.radius_63)) + portable.log(reduced) / self.exponent
        inside = by_mass[(by_mass > low) & (by_mass < high)]
        node = np.unique(np.concatenate([np.linspace(low, high, PANELS + 1), inside]))
        apart = np.diff(node) > 1.0e-15 * max(abs(low), abs(high), 1.0)
        return np.asarray(node[np.concatenate([[True], apart])])

    def _number_density(self, log_radius: Float64Array) -> Float64Array:
        """Return spheres per unit of ln(r) and of reduced volume (radius_63^3)."""
        ratio = log_radius - portable.log(np.array(self.radius_63))
        low, high = self._reduced(np.array(self.radius_bounds))
        reduced = portable.exp(self.exponent * ratio)
        log_exponent = portable.log(np.array(self.exponent))
        log_density = log_exponent + (self.exponent - 3.0) * ratio - (reduced - low)
        return np.asarray(portable.exp(log_density) / -portable.expm1(low - high))


class Sieve(Distribution):
    """A sieve curve: mass fractions that pass given diameters, linear in diameter between them.

    Where the finest sieve lets something pass, that fraction is spread below it as far as the next finer
    sieve of the series would be: down to its diameter squared over the next coarser one.
    """

    def __init__(self, diameters: Sequence[float], passing: Sequence[float]) -> None:
        """Check the curve.

        Args:
            diameters: Sieve openings [m], at least two, in rising (or all in falling) order.
            passing: Cumulative mass fraction below each, rising to 1.

        Raises:
            ParameterError: The two lists make no cumulative curve.
        """
        diameter, fraction = np.array(diameters, dtype=np.float64), np.array(passing, dtype=np.float64)
        _check_sieves(diameter, fraction)
        if diameter[0] > diameter[-1]:
            diameter, fraction = diameter[::-1], fraction[::-1]
        if fraction[0] > 0.0:
            diameter = np.concatenate([[diameter[0] * diameter[0] / diameter[1]], diameter])
            fraction = np.concatenate([[0.0], fraction])
        self._diameter = diameter
        self._passing = fraction / fraction[-1]

    @property
    @override
    def radius_bounds(self) -> tuple[float, float]:
        used = np.diff(self._passing) > 0.0
        return float(self._diameter[:-1][used][0]) / 2.0, float(self._diameter[1:][used][-1]) / 2.0

    @cached_property
    def _below(self) -> Float64Array:
        """Spheres below each diameter, per cubic metre of all, shape (K,)."""
        low, high = self._diameter[:-1], self._diameter[1:]
        # Mean of 6 / (pi d^3) over the class, its mass being spread evenly over d.
        count = np.diff(self._passing) * 3.0 / math.pi * (low + high) / (low**2 * high**2)
        return np.concatenate([[0.0], np.cumsum(count)])

    @override
    def mean_volume(self) -> float:
        return 1.0 / float(self._below[-1])

    @override
    def cumulative_mass(self, radius: Float64Array) -> Float64Array:
        return np.asarray(np.interp(2.0 * np.asarray(radius), self._diameter, self._passing))

    @override
    def cumulative_number(self, radius: Float64Array) -> Float64Array:
        diameter = np.clip(2.0 * np.asarray(radius), self._diameter[0], self._diameter[-1])
        panel = _panel(self._diameter, diameter)
        low, high = self._diameter[panel], self._diameter[panel + 1]
        part = (1.0 / low**2 - 1.0 / diameter**2) / (1.0 / low**2 - 1.0 / high**2)
        return np.asarray(
            (self._below[panel] + part * (self._below[panel + 1] - self._below[panel])) / self._below[-1]
        )

    @override
    def quantile(self, share: Float64Array) -> Float64Array:
        wanted = np.asarray(share) * self._below[-1]
        used = np.flatnonzero(np.diff(self._below) > 0.0)
        panel = used[np.clip(np.searchsorted(self._below[used], wanted, side="right") - 1, 0, len(used) - 1)]
        low, high = self._diameter[panel], self._diameter[panel + 1]
        part = np.clip(
            (wanted - self._below[panel]) / (self._below[panel + 1] - self._below[panel]), 0.0, 1.0
        )
        diameter = 1.0 / np.sqrt(1.0 / low**2 - part * (1.0 / low**2 - 1.0 / high**2))
        return np.asarray(np.clip(diameter, low, high) / 2.0)


def _panel(bound: Float64Array, value: Float64Array) -> Int64Array:
    """Return in which of the panels between rising bounds each value lies."""
    return np.clip(np.searchsorted(bound, value, side="right") - 1, 0, len(bound) - 2).astype(np.int64)


def _check_sieves(diameter: Float64Array, passing: Float64Array) -> None:
    """Raise where diameters and passing fractions make no cumulative curve."""
    if len(diameter) < 2:
        raise ParameterError((("diameters",), diameter.tolist(), "at least two diameters"))
    if len(diameter) != len(passing):
        expected = f"{len(diameter)} fractions, one a diameter"
        raise ParameterError((("passing",), f"{len(passing)} fractions", expected))
    order = 1.0 if diameter[0] < diameter[-1] else -1.0
    faults = []
    for name, steps, rule in (
        ("diameters", order * np.diff(diameter) > 0.0, "diameters in rising order, none twice"),
        ("passing", order * np.diff(passing) >= 0.0, "fractions that rise with the diameter"),
    ):
        if not steps.all():
            index = int(np.flatnonzero(~steps)[0]) + 1
            values = diameter if name == "diameters" else passing
            faults.append(((name, index), float(values[index]), rule))
    last = len(passing) - 1 if order > 0.0 else 0
    if abs(passing[last] - 1.0) > SUM_SLACK:
        faults.append(
            (("passing", last), float(passing[last]), "1 at the largest diameter, which all mass passes")
        )
    if faults:
        raise ParameterError(*faults)
