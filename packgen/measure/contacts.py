"""How many neighbours a sphere touches, and how near its neighbours are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, add_at
from packgen.bed import Bed
from packgen.check import near_pairs, wall_clearance

GAPS = (0.0, 0.001, 0.01, 0.05)  # largest gaps of a contact [smaller radii]
HELD_MIN = 4  # contacts that a sphere needs to be held
# Bounds of the classes of gaps: a decade each, overlaps below 0, up to the largest of the gaps above.
GAP_EDGES = (-1e-2, -1e-3, -1e-4, -1e-5, -1e-6, 0.0, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 5e-2)


@dataclass(frozen=True, slots=True)
class Contacts:
    """Contacts a sphere at one gap.

    Attributes:
        gap: Largest gap that counts as a contact, as a fraction of the smaller radius.
        mean: Mean number of sphere contacts a sphere (coordination number), walls not counted.
        wall_mean: Mean number of spheres that touch a wall, each counted once.
        none: Share of the spheres that touch neither a sphere nor a wall.
        rattlers: Share of the spheres that no contacts can hold in place: fewer than `HELD_MIN`, a wall being
            one. Four that do not lie on one half of the sphere are needed in three dimensions (Torquato and
            Stillinger, J. Phys. Chem. B 105, 2001, 11849). A sphere that only rests on three others counts.
            `coordination` takes rattlers out one after the other, and asks for less under gravity.
        spread: Number of spheres with 0, 1, 2, ... sphere contacts.
    """

    gap: float
    mean: float
    wall_mean: float
    none: float
    rattlers: float
    spread: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Gaps:
    """How near neighbouring spheres are to each other; a negative gap is an overlap.

    Attributes:
        edge: Gaps as fractions of the smaller radius, rising.
        count: Number of pairs with gaps above the edge before and up to each edge; the first entry has all
            the pairs below.
    """

    edge: tuple[float, ...]
    count: tuple[int, ...]


def contacts(bed: Bed, gaps: Sequence[float] = GAPS) -> tuple[Contacts, ...]:
    """Return the contacts a sphere of a bed at given gaps.

    Args:
        bed: The bed.
        gaps: Largest gaps that count as contacts, as fractions of the smaller radius, none below 0.

    Returns:
        One entry a gap, in the order given.
    """
    return contacts_and_gaps(bed, gaps)[0]


def contacts_and_gaps(
    bed: Bed, gaps: Sequence[float] = GAPS, clearance: Float64Array | None = None
) -> tuple[tuple[Contacts, ...], Gaps]:
    """Return the contacts a sphere, and the gaps of all near pairs: both from one search.

    Spheres of one body are neither in contact nor a near pair.

    Args:
        bed: The bed.
        gaps: Largest gaps that count as contacts, as fractions of the smaller radius, none below 0.
        clearance: Distance of each centre from the nearest wall [m], exact as far as a contact, where it is
            known; shape (N,).

    Returns:
        Contacts, one entry a gap of ``gaps``; pairs counted between `GAP_EDGES`.
    """
    widest = max(*gaps, GAP_EDGES[-1])
    count = np.zeros((len(gaps), bed.count), dtype=np.int32)
    pair_count = np.zeros(len(GAP_EDGES), dtype=np.int64)
    for pairs in near_pairs(
        bed.position,
        bed.radius,
        gap_fraction=widest,
        period=bed.container.period,
        body_index=bed.body_index,
    ):
        share = pairs.gap / np.minimum(bed.radius[pairs.first], bed.radius[pairs.second])
        edge = np.searchsorted(GAP_EDGES, share)
        pair_count += np.bincount(edge, minlength=len(GAP_EDGES) + 1)[: len(GAP_EDGES)]
        for place, gap in enumerate(gaps):
            for end in (pairs.first, pairs.second):
                add_at(count[place], end[share <= gap])
    if clearance is None:
        clearance = wall_clearance(bed.container, bed.position, bed.radius * (1.0 + widest))
    total = max(bed.count, 1)
    found = []
    for place, gap in enumerate(gaps):
        at_wall = clearance <= bed.radius * (1.0 + gap)
        found.append(
            Contacts(
                gap=gap,
                mean=float(count[place].sum()) / total,
                wall_mean=float(np.count_nonzero(at_wall)) / total,
                none=float(np.count_nonzero((count[place] == 0) & ~at_wall)) / total,
                rattlers=float(np.count_nonzero(count[place] + at_wall < HELD_MIN)) / total,
                spread=tuple(np.bincount(count[place]).tolist()),
            )
        )
    return tuple(found), Gaps(GAP_EDGES, tuple(pair_count.tolist()))
