"""The independent check of a bed: does anything overlap, and is every sphere inside?

It shares no code with the core: pairs by scipy's k-d trees, walls by closed forms, meshes by distances of
its own. A bed is judged here and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed
from packgen.check.pairs import near_pairs
from packgen.check.parts import nearest_part_name
from packgen.check.walls import wall_clearance

PART_REACH = 2.0  # radii: how far from a sphere in a wall its part is looked for

__all__ = ["Check", "check_bed", "near_pairs", "wall_clearance"]


@dataclass(frozen=True, slots=True)
class Check:
    """What the check of a bed found; overlaps are fractions of the smaller radius.

    Attributes:
        overlap_max: Largest overlap of two spheres; 0 where none overlap.
        worst_pair: The two spheres of that overlap; None where none overlap.
        overlap_mean: Mean over the pairs that overlap; 0 where none do.
        overlap_count: Number of pairs that overlap.
        excess_count: Number of pairs that overlap by more than the tolerance.
        wall_overlap_max: Largest depth of a sphere in a wall, as a fraction of its radius; 0 where none.
        worst_wall_sphere: The sphere of that depth; None where none touches deeper than zero.
        outside_count: Number of spheres whose centre is outside the container.
        invalid_count: Number of spheres whose position is not finite, or whose radius is not finite and above
            0.
        tolerance: Largest overlap asked for; None: whatever the optimiser left.
        worst_wall_part: Name of the part of the walls that is nearest to that sphere; None where it has none.
    """

    overlap_max: float
    worst_pair: tuple[int, int] | None
    overlap_mean: float
    overlap_count: int
    excess_count: int
    wall_overlap_max: float
    worst_wall_sphere: int | None
    outside_count: int
    invalid_count: int
    tolerance: float | None
    worst_wall_part: str | None = None

    @property
    def within_tolerance(self) -> bool:
        """Whether every sphere is sound and inside, and no overlap exceeds the tolerance."""
        sound = self.invalid_count == 0 and self.outside_count == 0
        limit = np.inf if self.tolerance is None else self.tolerance
        return bool(sound and self.overlap_max <= limit and self.wall_overlap_max <= limit)

    def faults(self) -> tuple[str, ...]:
        """Return a line for each thing that is wrong, naming the worst sphere; empty when all is well."""
        lines = []
        if self.invalid_count:
            spheres = "1 sphere has" if self.invalid_count == 1 else f"{self.invalid_count:,} spheres have"
            lines.append(f"{spheres} a position or radius that is no finite number")
        if self.outside_count:
            alone = self.outside_count == 1
            lines.append(
                f"sphere {self.worst_wall_sphere} lies outside the container"
                if alone
                else f"{self.outside_count:,} spheres lie outside the container, "
                f"sphere {self.worst_wall_sphere} farthest"
            )
        if self.tolerance is not None and self.overlap_max > self.tolerance and self.worst_pair is not None:
            first, second = self.worst_pair
            pairs = "1 pair overlaps" if self.excess_count == 1 else f"{self.excess_count:,} pairs overlap"
            lines.append(
                f"{pairs} by more than the tolerance {self.tolerance:.3g}, worst "
                f"spheres {first} and {second}, by {self.overlap_max:.3g} of the smaller radius"
            )
        if self.tolerance is not None and self.wall_overlap_max > self.tolerance:
            part = "" if self.worst_wall_part is None else f" {self.worst_wall_part}"
            lines.append(
                f"sphere {self.worst_wall_sphere} is in the wall{part} by {self.wall_overlap_max:.3g} of its "
                f"radius, tolerance {self.tolerance:.3g}"
            )
        return tuple(lines)


def check_bed(bed: Bed, clearance: Float64Array | None = None) -> Check:
    """Check every pair and every wall of a bed; spheres of one body may overlap each other.

    Args:
        bed: The bed as the core left it.
        clearance: Result of `wall_clearance` for its spheres, where known; shape (N,).

    Returns:
        What was found; all zero for a bed without spheres.
    """
    sound = np.isfinite(bed.position).all(axis=1) & np.isfinite(bed.radius) & (bed.radius > 0.0)
    index = np.flatnonzero(sound)
    position, radius = (bed.position, bed.radius) if sound.all() else (bed.position[index], bed.radius[index])
    body_index = None if bed.body_index is None else bed.body_index[index]
    overlap_max, worst_pair, overlap_sum, overlap_count, excess_count = 0.0, None, 0.0, 0, 0
    limit = np.inf if bed.tolerance is None else bed.tolerance
    for pairs in near_pairs(position, radius, period=bed.container.period, body_index=body_index):
        overlap = -pairs.gap / np.minimum(radius[pairs.first], radius[pairs.second])
        overlap_sum += float(overlap.sum())
        overlap_count += int(np.count_nonzero(overlap > 0.0))
        excess_count += int(np.count_nonzero(overlap > limit))
        worst = int(overlap.argmax())
        if overlap[worst] > overlap_max:
            overlap_max = float(overlap[worst])
            worst_pair = (int(index[pairs.first[worst]]), int(index[pairs.second[worst]]))
    clearance = wall_clearance(bed.container, position, radius) if clearance is None else clearance[index]
    depth = 1.0 - clearance / radius
    worst_wall = int(depth.argmax()) if len(depth) else 0
    in_wall = bool(len(depth)) and depth[worst_wall] > 0.0
    return Check(
        overlap_max=overlap_max,
        worst_pair=worst_pair,
        overlap_mean=overlap_sum / overlap_count if overlap_count else 0.0,
        overlap_count=overlap_count,
        excess_count=excess_count,
        wall_overlap_max=float(depth[worst_wall]) if in_wall else 0.0,
        worst_wall_sphere=int(index[worst_wall]) if in_wall else None,
        outside_count=int(np.count_nonzero(clearance < 0.0)),
        invalid_count=int(bed.count - len(index)),
        tolerance=bed.tolerance,
        worst_wall_part=(
            nearest_part_name(bed.container, position[worst_wall], PART_REACH * float(radius[worst_wall]))
            if in_wall and bed.container.parts
            else None
        ),
    )
