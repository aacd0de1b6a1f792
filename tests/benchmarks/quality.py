"""What a bed is worth: overlap, density, and what its overlaps would do to it."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from packgen.bed import Bed
from packgen.check import check_bed
from packgen.measure import against_gravity, solid_fraction
from packgen.validation import predicted_forces


@dataclass(frozen=True, slots=True)
class Quality:
    """The figures of a bed.

    Attributes:
        overlap_max: Largest overlap, of pairs or with a wall, as a fraction of the (smaller) radius.
        overlap_mean: Mean overlap of the pairs that overlap, likewise; 0 where none do.
        depth: Height of the bed's top above the floor, in mean diameters.
        core_density: Solid fraction of the core; None where the bed is too small for one.
        force_max: Largest contact force before anything moves, in mean sphere weights, by Hertz' law.
        outside: Spheres whose centre is outside the container.
    """

    overlap_max: float
    overlap_mean: float
    depth: float
    core_density: float | None
    force_max: float
    outside: int

    def as_row(self) -> dict[str, Any]:
        """Return the figures by name."""
        return asdict(self)


def quality(bed: Bed) -> Quality:
    """Measure a bed by the project's own independent check, measures and force law."""
    check, fraction = check_bed(bed), solid_fraction(bed)
    floor = float((bed.container.bounds @ against_gravity(bed)).min())
    return Quality(
        overlap_max=max(check.overlap_max, check.wall_overlap_max),
        overlap_mean=check.overlap_mean,
        depth=(fraction.top - floor) / (2.0 * float(bed.radius.mean())),
        core_density=fraction.core,
        force_max=predicted_forces(bed).force_max,
        outside=check.outside_count,
    )
