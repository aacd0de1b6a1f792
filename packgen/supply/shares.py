"""How a number of spheres is divided among particle sets."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.distributions import UNIT_VOLUME, Distribution, Free
from packgen.distributions.base import StepLaw
from packgen.portable import cube

if TYPE_CHECKING:
    from packgen.bed import AnyBed

__all__ = [
    "Amount",
    "SizedSet",
    "expected_count",
    "free_sizes",
    "largest_remainder",
    "largest_remainders",
    "number_shares",
    "reached_amounts",
    "reached_shares",
    "set_amounts",
    "size_weights",
]

CLASSES = 256
"""Classes of equally many spheres that stand for a law; the last one, of the largest, is divided."""

HALVINGS, PIECES = 32, 16
"""How often that class is halved, the larger spheres apart, and pieces of each half: a broad law has much of
its volume in very few spheres."""


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


def free_sizes(zone: Amount, sets: Sequence[SizedSet]) -> Free | None:
    """Return the bounds of the sizes of a zone that fills voids; None: its sizes are drawn."""
    used = [each.distribution for each, share in zip(sets, zone.set_proportions, strict=True) if share > 0.0]
    return next((law for law in used if isinstance(law, Free)), None)


def mean_weights(by: str, sets: Sequence[SizedSet]) -> Float64Array:
    """Return the mean amount of one sphere of each set; shape (S,).

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


def set_amounts(zone: Amount, sets: Sequence[SizedSet]) -> Float64Array:
    """Return how much of each set makes the sum of a zone with its shares by volume or mass; shape (S,).

    Args:
        zone: A zone with a volume, then these are volumes [m3], or with a mass, then masses [kg].
        sets: The sets.
    """
    by, wanted = ("mass", zone.mass) if zone.volume is None else ("volume", zone.volume)
    share = np.array(zone.set_proportions, dtype=np.float64)
    if zone.proportions_by != by:
        density = np.array([each.density for each in sets])
        share = share * density if by == "mass" else share / density
    return np.asarray((wanted or 0.0) * (share / share.sum()))


def size_weights(share: Float64Array, sets: Sequence[SizedSet]) -> tuple[Float64Array, Float64Array]:
    """Return radii that stand for the laws of some sets.

    Args:
        share: Share of the spheres, by number, that each set has, shape (S,).
        sets: The sets.

    Returns:
        (radii [m], share of the spheres that has each), shape (k,) each; of a law in steps, its own.
    """
    radius, weight = [np.empty(0)], [np.empty(0)]
    edge = _class_edges()
    for part, each in zip(share, sets, strict=True):
        law = each.distribution
        if isinstance(law, StepLaw):
            radius.append(law.radius)
            weight.append(part * law.number)
        else:
            radius.append(law.quantile(0.5 * (edge[1:] + edge[:-1])))
            weight.append(part * np.diff(edge))
    joined = np.concatenate(weight)
    return np.concatenate(radius)[joined > 0.0], joined[joined > 0.0]


def _class_edges() -> Float64Array:
    """Return the bounds of classes as shares of the spheres, from 0 to 1, finer and finer towards 1."""
    above = np.ldexp(1.0, -np.arange(HALVINGS + 1)) / CLASSES
    piece = np.arange(PIECES) / PIECES
    last = (above[:-1, None] + piece * (above[1:] - above[:-1])[:, None]).ravel()
    return np.concatenate([np.arange(CLASSES - 1) / CLASSES, 1.0 - last, [1.0]])


def largest_remainder(share: Float64Array, count: int) -> Int64Array:
    """Divide a whole number by Hamilton's method: quotas rounded down, the rest to the largest remainders.

    Args:
        share: Shares that add up to 1, shape (S,).
        count: What to divide.

    Returns:
        Whole numbers that add up to ``count``, shape (S,), int64; a share of 0 gets 0.
    """
    return np.asarray(largest_remainders(share, np.array([count]))[0])


def largest_remainders(share: Float64Array, counts: Int64Array) -> Int64Array:
    """Divide several whole numbers as ``largest_remainder`` does, one a row.

    Args:
        share: Shares that add up to 1, shape (S,).
        counts: What to divide, shape (K,).

    Returns:
        Whole numbers, shape (K, S), int64.
    """
    quota = share * counts[:, None]
    whole = np.floor(quota).astype(np.int64)
    remainder = np.where(share > 0.0, quota - whole, -1.0)
    rank = np.argsort(np.argsort(-remainder, axis=1, kind="stable"), axis=1, kind="stable")
    return np.asarray(whole + (rank < (counts - whole.sum(axis=1))[:, None]))


def reached_shares(bed: AnyBed, zone: int, by: str) -> list[float]:
    """Return the share of each set in what a zone holds; all 0 of an empty zone.

    Args:
        bed: The bed.
        zone: Number of the zone.
        by: ``number``, ``volume`` or ``mass``.
    """
    amount, _ = reached_amounts(bed, zone, by)
    return [float(share) for share in amount / (amount.sum() or 1.0)]


def reached_amounts(bed: AnyBed, zone: int, by: str) -> tuple[Float64Array, Float64Array]:
    """Return what a zone holds of each set, and the largest of its spheres of each; shape (S,) each.

    Args:
        bed: The bed.
        zone: Number of the zone.
        by: ``number`` (a sphere counts 1), ``volume`` [m3] or ``mass`` [kg].
    """
    total, largest = np.zeros((2, len(bed.particle_sets)))
    for chunk in bed.chunks():
        own = chunk.zone_index == zone
        set_index = chunk.set_index[own]
        weight = np.ones(len(set_index)) if by == "number" else UNIT_VOLUME * cube(chunk.radius[own])
        if by == "mass":
            weight = weight * np.array([each.density for each in bed.particle_sets])[set_index]
        np.maximum.at(largest, set_index, weight)
        total += np.bincount(set_index, weight, len(bed.particle_sets))
    return total, largest
