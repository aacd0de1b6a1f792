"""How a number of spheres is divided among particle sets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.distributions import Distribution
from packgen.portable import cube

if TYPE_CHECKING:
    from packgen.bed import Bed

__all__ = ["Amount", "SizedSet", "expected_count", "largest_remainder", "number_shares", "reached_shares"]


class SizedSet(Protocol):
    """What counts and radii need to know of a particle set; ``packgen.scene.SetKeys`` is one."""

    @property
    def distribution(self) -> Distribution:
        """The law of its radii."""
        ...

    @property
    def density(self) -> float:
        """Density of its spheres [kg/m3]."""
        ...


class Amount(Protocol):
    """How much of which sets a zone holds; ``packgen.scene.ZoneSpec`` is one."""

    @property
    def n_particles(self) -> int | None:
        """Number of spheres."""
        ...

    @property
    def volume(self) -> float | None:
        """Solid volume [m3]."""
        ...

    @property
    def mass(self) -> float | None:
        """Mass [kg]."""
        ...

    @property
    def set_proportions(self) -> tuple[float, ...]:
        """Share of each set."""
        ...

    @property
    def proportions_by(self) -> str:
        """``number``, ``volume`` or ``mass``."""
        ...


def number_shares(zone: Amount, sets: Sequence[SizedSet]) -> Float64Array:
    """Return the share of the spheres, by number, that each set has in a zone; shape (S,), adds up to 1."""
    share = np.array(zone.set_proportions, dtype=np.float64)
    if zone.proportions_by != "number":
        share /= mean_weights(zone.proportions_by, sets)
    return np.asarray(share / share.sum())


def mean_weights(by: str, sets: Sequence[SizedSet]) -> Float64Array:
    """Return what one sphere of each set counts on average; shape (S,).

    Args:
        by: ``number`` (1), ``volume`` [m3] or ``mass`` [kg].
        sets: The sets.
    """
    if by == "number":
        return np.ones(len(sets))
    volume = np.array([each.distribution.mean_volume() for each in sets])
    return volume if by == "volume" else volume * [each.density for each in sets]


def expected_count(zone: Amount, sets: Sequence[SizedSet]) -> float | None:
    """Return how many spheres a zone asks for, on average over the laws of size; None: until it is full."""
    if zone.n_particles is not None:
        return float(zone.n_particles)
    share = number_shares(zone, sets)
    if zone.volume is not None:
        return zone.volume / float((share * mean_weights("volume", sets)).sum())
    if zone.mass is not None:
        return zone.mass / float((share * mean_weights("mass", sets)).sum())
    return None


def largest_remainder(share: Float64Array, count: int) -> Int64Array:
    """Divide a whole number by Hamilton's method: quotas rounded down, the rest to the largest remainders.

    Args:
        share: Shares that add up to 1, shape (S,).
        count: What to divide.

    Returns:
        Whole numbers that add up to ``count``, shape (S,), int64; a share of 0 gets 0.
    """
    quota = share * count
    whole = np.floor(quota).astype(np.int64)
    remainder = np.where(share > 0.0, quota - whole, -1.0)
    first = np.argsort(-remainder, kind="stable")[: count - int(whole.sum())]
    whole[first] += 1
    return whole


def reached_shares(bed: Bed, zone: int, by: str) -> list[float]:
    """Return the share of each set in what a zone holds; all 0 of an empty zone.

    Args:
        bed: The bed.
        zone: Number of the zone.
        by: ``number``, ``volume`` or ``mass``.
    """
    own = bed.zone_index == zone
    weight = np.ones(int(own.sum())) if by == "number" else cube(bed.radius[own])
    if by == "mass":
        weight = weight * np.array([each.density for each in bed.particle_sets])[bed.set_index[own]]
    amount = np.bincount(bed.set_index[own], weight, len(bed.particle_sets))
    return [float(share) for share in amount / (amount.sum() or 1.0)]
