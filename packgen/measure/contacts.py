"""How many neighbours a sphere touches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.bed import Bed
from packgen.check import near_pairs, period, wall_clearance

GAPS = (0.0, 0.001, 0.01, 0.05)  # of the smaller radius


@dataclass(frozen=True, slots=True)
class Contacts:
    """Contacts a sphere at one gap.

    Attributes:
        gap: Largest gap that counts as a contact, as a fraction of the smaller radius.
        mean: Mean number of sphere contacts a sphere (coordination number), walls not counted.
        wall_mean: Mean number of spheres that touch a wall, each counted once.
        none: Share of the spheres that touch neither a sphere nor a wall.
    """

    gap: float
    mean: float
    wall_mean: float
    none: float


def contacts(bed: Bed) -> tuple[Contacts, ...]:
    """Return the contacts a sphere of a bed at gaps of 0, 0.1 %, 1 % and 5 % of the smaller radius.

    Args:
        bed: The bed.

    Returns:
        One entry a gap, narrow ones first.
    """
    count = np.zeros((len(GAPS), bed.count), dtype=np.int32)
    for pairs in near_pairs(bed.position, bed.radius, gap_fraction=GAPS[-1], period=period(bed.container)):
        share = pairs.gap / np.minimum(bed.radius[pairs.first], bed.radius[pairs.second])
        for place, gap in enumerate(GAPS):
            for end in (pairs.first, pairs.second):
                count[place] += np.bincount(end[share <= gap], minlength=bed.count).astype(np.int32)
    clearance = wall_clearance(bed.container, bed.position, bed.radius * (1.0 + GAPS[-1]))
    total = max(bed.count, 1)
    found = []
    for place, gap in enumerate(GAPS):
        at_wall = clearance <= bed.radius * (1.0 + gap)
        found.append(
            Contacts(
                gap=gap,
                mean=float(count[place].sum()) / total,
                wall_mean=float(np.count_nonzero(at_wall)) / total,
                none=float(np.count_nonzero((count[place] == 0) & ~at_wall)) / total,
            )
        )
    return tuple(found)
