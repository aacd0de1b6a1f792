"""How many neighbours a sphere touches, and how near its neighbours are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, add_at, tallied
from packgen.bed import Bed, has_clumps
from packgen.check import near_pairs, wall_clearance
from packgen.part import Part

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

    Spheres of one body are neither in contact nor a near pair. Of a bed with clumps the contacts are those a
    clump, as `packgen.measure.bodies.body_contacts` has them.

    Args:
        bed: The bed.
        gaps: Largest gaps that count as contacts, as fractions of the smaller radius, none below 0.
        clearance: Distance of each centre from the nearest wall [m], exact as far as a contact, where it is
            known; shape (N,).

    Returns:
        Contacts, one entry a gap of ``gaps``; pairs counted between `GAP_EDGES`.
    """
    if has_clumps(bed):
        from packgen.measure.bodies import body_contacts

        return body_contacts(bed, clearance, gaps)
    counter = ContactCounter(gaps)
    counter.add(Part.whole(bed), clearance)
    return counter.result()


class ContactCounter:
    """Counts contacts and gaps of a bed in parts, as of the bed in one.

    Args:
        gaps: Largest gaps that count as contacts, as fractions of the smaller radius, none below 0.

    Attributes:
        widest: Largest gap that is looked for, as a fraction of the smaller radius.
    """

    def __init__(self, gaps: Sequence[float] = GAPS) -> None:
        self._gaps, self.widest = gaps, max(*gaps, GAP_EDGES[-1])
        self._pairs = np.zeros(len(GAP_EDGES), dtype=np.int64)
        self._spread = [np.zeros(0, dtype=np.int64) for _ in gaps]
        self._at_wall, self._none, self._rattlers = np.zeros((3, len(gaps)), dtype=np.int64)
        self._spheres = 0

    def add(self, part: Part, clearance: Float64Array | None = None) -> None:
        """Count the contacts of a part.

        Args:
            part: The part, with all around it that its spheres may touch.
            clearance: Distance of each own centre from the nearest wall [m], exact as far as a contact, where
                it is known; shape (own,).
        """
        bed, own = part.bed, slice(part.own)
        count = np.zeros((len(self._gaps), bed.count), dtype=np.int32)
        for pairs in near_pairs(
            bed.position,
            bed.radius,
            gap_fraction=self.widest,
            period=bed.container.period,
            body_index=bed.body_index,
        ):
            share = pairs.gap / np.minimum(bed.radius[pairs.first], bed.radius[pairs.second])
            for place, gap in enumerate(self._gaps):
                for end in (pairs.first, pairs.second):
                    add_at(count[place], end[share <= gap])
            counted = share if part.is_whole else share[part.counted(pairs.first, pairs.second)]
            edge = np.searchsorted(GAP_EDGES, counted)
            self._pairs += np.bincount(edge, minlength=len(GAP_EDGES) + 1)[: len(GAP_EDGES)]
        radius = bed.radius[own]
        if clearance is None:
            clearance = wall_clearance(bed.container, bed.position[own], radius * (1.0 + self.widest))
        self._spheres += part.own
        for place, gap in enumerate(self._gaps):
            at_wall, number = clearance <= radius * (1.0 + gap), count[place, own]
            self._at_wall[place] += np.count_nonzero(at_wall)
            self._none[place] += np.count_nonzero((number == 0) & ~at_wall)
            self._rattlers[place] += np.count_nonzero(number + at_wall < HELD_MIN)
            self._spread[place] = tallied(self._spread[place], number)

    def result(self) -> tuple[tuple[Contacts, ...], Gaps]:
        """Return what was counted of all parts, as `contacts_and_gaps` does."""
        total = max(self._spheres, 1)
        found = tuple(
            Contacts(
                gap=gap,
                mean=float(self._spread[place] @ np.arange(len(self._spread[place]))) / total,
                wall_mean=float(self._at_wall[place]) / total,
                none=float(self._none[place]) / total,
                rattlers=float(self._rattlers[place]) / total,
                spread=tuple(self._spread[place].tolist()),
            )
            for place, gap in enumerate(self._gaps)
        )
        return found, Gaps(GAP_EDGES, tuple(self._pairs.tolist()))
