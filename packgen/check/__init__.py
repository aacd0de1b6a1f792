"""The independent check of a bed: does anything overlap, and is every sphere inside?

It shares no code with the core: pairs by scipy's k-d trees, walls by closed forms, meshes by distances of
its own. A bed is judged here and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import ExactSum, Float64Array, Int64Array
from packgen.bed import Bed
from packgen.check.pairs import near_pairs
from packgen.check.parts import nearest_part_name
from packgen.check.walls import wall_clearance
from packgen.part import Part

PART_REACH = 2.0  # radii: how far from a sphere in a wall its part is looked for

__all__ = ["Check", "Checker", "check_bed", "near_pairs", "wall_clearance"]


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
    check = Checker(bed.tolerance)
    check.add(Part.whole(bed), clearance)
    return check.result()


class Checker:
    """The check of a bed in parts: what it finds is what it finds of the bed in one, to the last digit.

    Args:
        tolerance: Largest overlap asked for; None: whatever the optimiser left.
    """

    def __init__(self, tolerance: float | None) -> None:
        self._tolerance = tolerance
        self._limit = np.inf if tolerance is None else tolerance
        self._overlap_sum = ExactSum()
        self._overlaps = self._excess = self._outside = self._invalid = 0
        self._overlap_max, self._pair = 0.0, (0, 0)
        self._depth_max, self._in_wall = 0.0, 0
        self._wall_part: str | None = None

    def add(self, part: Part, clearance: Float64Array | None = None) -> None:
        """Check a part; parts come in the order of their numbers.

        Args:
            part: The part, with all around it that its spheres may touch.
            clearance: Result of `wall_clearance` for its own spheres, where known; shape (own,).
        """
        bed = part.bed
        sound = np.isfinite(bed.position).all(axis=1) & np.isfinite(bed.radius) & (bed.radius > 0.0)
        index = np.flatnonzero(sound)
        whole = len(index) == bed.count
        position, radius = (bed.position, bed.radius) if whole else (bed.position[index], bed.radius[index])
        body_index = None if bed.body_index is None else bed.body_index[index]
        for pairs in near_pairs(position, radius, period=bed.container.period, body_index=body_index):
            overlap = -pairs.gap / np.minimum(radius[pairs.first], radius[pairs.second])
            first, second = index[pairs.first], index[pairs.second]
            if not part.is_whole:
                counted = part.counted(first, second)
                first, second, overlap = first[counted], second[counted], overlap[counted]
            self._note_pairs(part.number[first], part.number[second], overlap)
        own = int(np.searchsorted(index, part.own))
        self._invalid += part.own - own
        position, radius, number = position[:own], radius[:own], part.number[index[:own]]
        found = (
            wall_clearance(bed.container, position, radius) if clearance is None else clearance[index[:own]]
        )
        self._outside += int(np.count_nonzero(found < 0.0))
        depth = 1.0 - found / radius
        worst = int(depth.argmax()) if len(depth) else 0
        if len(depth) and depth[worst] > self._depth_max:
            self._depth_max, self._in_wall = float(depth[worst]), int(number[worst])
            reach = PART_REACH * float(radius[worst])
            self._wall_part = nearest_part_name(bed.container, position[worst], reach)

    def _note_pairs(self, first: Int64Array, second: Int64Array, overlap: Float64Array) -> None:
        """Count pairs that touch or overlap; of equally deep ones that of the lowest numbers is the worst."""
        if len(overlap) == 0:
            return
        self._overlap_sum.add(overlap)
        self._overlaps += int(np.count_nonzero(overlap > 0.0))
        self._excess += int(np.count_nonzero(overlap > self._limit))
        most = float(overlap.max())
        if most < self._overlap_max or most <= 0.0:
            return
        deepest = np.flatnonzero(overlap == most)
        ends = np.sort(np.stack([first[deepest], second[deepest]], axis=1), axis=1)
        one, other = ends[np.lexsort((ends[:, 1], ends[:, 0]))[0]].tolist()
        if most > self._overlap_max or (one, other) < self._pair:
            self._overlap_max, self._pair = most, (one, other)

    def result(self) -> Check:
        """Return what was found of all parts."""
        return Check(
            overlap_max=self._overlap_max,
            worst_pair=self._pair if self._overlap_max > 0.0 else None,
            overlap_mean=float(self._overlap_sum.exact() / self._overlaps) if self._overlaps else 0.0,
            overlap_count=self._overlaps,
            excess_count=self._excess,
            wall_overlap_max=self._depth_max,
            worst_wall_sphere=self._in_wall if self._depth_max > 0.0 else None,
            outside_count=self._outside,
            invalid_count=self._invalid,
            tolerance=self._tolerance,
            worst_wall_part=self._wall_part,
        )
