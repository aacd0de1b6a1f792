"""The independent check of a bed: does anything overlap, and is every sphere inside?

It shares no code with the core: pairs by scipy's k-d trees, walls by closed forms, meshes by distances of
its own. A bed is judged here and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from packgen.arrays import BoolArray, ExactSum, Float64Array, Int64Array
from packgen.bed import Bed, EarlierBed
from packgen.check.bodies import BodyCheck, check_bodies
from packgen.check.pairs import near_pairs
from packgen.check.parts import part_name_beside
from packgen.check.walls import wall_clearance
from packgen.part import Part

__all__ = ["BodyCheck", "Check", "Checker", "NewOverlaps", "check_bed", "near_pairs", "wall_clearance"]


@dataclass(frozen=True, slots=True)
class NewOverlaps:
    """Overlaps of the spheres that were placed beside others; fractions of the smaller radius.

    Attributes:
        overlap_max: Largest overlap of two spheres, one of which is new at least; 0 where none overlap.
        worst_pair: The two spheres of that overlap; None where none overlap.
        excess_count: Number of such pairs that overlap by more than the tolerance.
        wall_overlap_max: Largest depth of a new sphere in a wall; 0 where none.
        worst_wall_sphere: The sphere of that depth; None where none touches deeper than zero.
        worst_wall_part: Name of the part of the walls that is nearest to that sphere; None where it has none.
    """

    overlap_max: float
    worst_pair: tuple[int, int] | None
    excess_count: int
    wall_overlap_max: float
    worst_wall_sphere: int | None
    worst_wall_part: str | None


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
        new: The overlaps of new spheres, where others were there before; None: all are new. Those may overlap
            each other by ``earlier_tolerance``, the new ones nothing by more than ``tolerance``.
        earlier_tolerance: Largest overlap of two spheres that were there before, or of one with a wall; None:
            any.
        bodies: Whether the spheres of rigid bodies stand where these have them; None of a bed without, and of
            one in pieces.
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
    new: NewOverlaps | None = None
    earlier_tolerance: float | None = None
    bodies: BodyCheck | None = None

    @property
    def within_tolerance(self) -> bool:
        """Whether every sphere is sound and inside, and no overlap exceeds the tolerance."""
        return not self.faults()

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
        if self.bodies is not None:
            lines += self.bodies.faults()
        if self.new is None:
            return (*lines, *_excess(self, self.tolerance))
        return (*lines, *_excess(self.new, self.tolerance), *self._earlier_excess(self.new))

    def _earlier_excess(self, new: NewOverlaps) -> list[str]:
        """Return a line for each limit that spheres that were there before break, and more than new ones."""
        limit = self.earlier_tolerance
        if limit is None:
            return []
        lines = []
        if self.overlap_max > max(limit, new.overlap_max) and self.worst_pair is not None:
            first, second = self.worst_pair
            lines.append(
                f"spheres {first} and {second}, which were there before, overlap by {self.overlap_max:.3g} "
                f"of the smaller radius, limit {limit:.3g}"
            )
        if self.wall_overlap_max > max(limit, new.wall_overlap_max):
            lines.append(
                f"sphere {self.worst_wall_sphere}, which was there before, is in the wall"
                f"{_named(self.worst_wall_part)} by {self.wall_overlap_max:.3g} of its radius, "
                f"limit {limit:.3g}"
            )
        return lines


def _excess(found: Check | NewOverlaps, limit: float | None) -> list[str]:
    """Return a line for each tolerance that overlaps exceed."""
    lines = []
    if limit is not None and found.overlap_max > limit and found.worst_pair is not None:
        first, second = found.worst_pair
        pairs = "1 pair overlaps" if found.excess_count == 1 else f"{found.excess_count:,} pairs overlap"
        lines.append(
            f"{pairs} by more than the tolerance {limit:.3g}, worst "
            f"spheres {first} and {second}, by {found.overlap_max:.3g} of the smaller radius"
        )
    if limit is not None and found.wall_overlap_max > limit:
        lines.append(
            f"sphere {found.worst_wall_sphere} is in the wall{_named(found.worst_wall_part)} by "
            f"{found.wall_overlap_max:.3g} of its radius, tolerance {limit:.3g}"
        )
    return lines


def _named(part: str | None) -> str:
    """Return the name of a part of the walls with a blank before it."""
    return "" if part is None else f" {part}"


class _Worst:
    """The deepest overlaps seen so far.

    Args:
        tolerance: Overlap beyond which pairs are counted; None: none is.
    """

    def __init__(self, tolerance: float | None) -> None:
        self._limit = np.inf if tolerance is None else tolerance
        self._excess = 0
        self._overlap_max, self._pair = 0.0, (0, 0)
        self._depth_max, self._in_wall = 0.0, 0
        self._wall_part: str | None = None

    def see_pairs(self, first: Int64Array, second: Int64Array, overlap: Float64Array) -> None:
        """Look at pairs by number, (P,) each; of equally deep ones that of the lowest numbers is worst."""
        if len(overlap) == 0:
            return
        self._excess += int(np.count_nonzero(overlap > self._limit))
        most = float(overlap.max())
        if most < self._overlap_max or most <= 0.0:
            return
        deepest = np.flatnonzero(overlap == most)
        ends = np.sort(np.stack([first[deepest], second[deepest]], axis=1), axis=1)
        one, other = ends[np.lexsort((ends[:, 1], ends[:, 0]))[0]].tolist()
        if most > self._overlap_max or (one, other) < self._pair:
            self._overlap_max, self._pair = most, (one, other)

    def see_depths(self, bed: Bed, chosen: Int64Array, number: Int64Array, depth: Float64Array) -> None:
        """Look at spheres of a bed by place and number, and at their depths in walls in radii, (N,) each."""
        worst = int(depth.argmax()) if len(depth) else 0
        if len(depth) == 0 or depth[worst] <= self._depth_max:
            return
        self._depth_max, self._in_wall = float(depth[worst]), int(number[worst])
        self._wall_part = part_name_beside(bed, int(chosen[worst]))

    def found(self) -> NewOverlaps:
        """Return them, in the form in which those of new spheres are told."""
        return NewOverlaps(
            overlap_max=self._overlap_max,
            worst_pair=self._pair if self._overlap_max > 0.0 else None,
            excess_count=self._excess,
            wall_overlap_max=self._depth_max,
            worst_wall_sphere=self._in_wall if self._depth_max > 0.0 else None,
            worst_wall_part=self._wall_part,
        )


def check_bed(bed: Bed, clearance: Float64Array | None = None) -> Check:
    """Check every pair and every wall of a bed; spheres of one body may overlap each other.

    Args:
        bed: The bed as the core left it.
        clearance: Result of `wall_clearance` for its spheres, where known; shape (N,).

    Returns:
        What was found; all zero for a bed without spheres.
    """
    check = Checker(bed.tolerance, bed.earlier)
    check.add(Part.whole(bed), clearance)
    return replace(check.result(), bodies=check_bodies(bed))


class Checker:
    """The check of a bed in parts: what it finds is what it finds of the bed in one, to the last digit.

    Args:
        tolerance: Largest overlap asked for; None: whatever the optimiser left.
        earlier: The bed that was there before; None: all spheres are new.
    """

    def __init__(self, tolerance: float | None, earlier: EarlierBed | None = None) -> None:
        self._tolerance, self._earlier = tolerance, earlier
        self._overlap_sum = ExactSum()
        self._overlaps = self._outside = self._invalid = 0
        self._all, self._new = _Worst(tolerance), _Worst(tolerance)

    def add(self, part: Part, clearance: Float64Array | None = None) -> None:
        """Check a part; parts come in the order of their numbers.

        Args:
            part: The part, with all around it that its spheres may touch.
            clearance: Result of `wall_clearance` for its own spheres, where known; shape (own,).
        """
        bed = part.bed
        sound = np.isfinite(bed.position).all(axis=1) & np.isfinite(bed.radius) & (bed.radius > 0.0)
        index = np.flatnonzero(sound)
        new = None if self._earlier is None else ~bed.is_earlier
        self._see_pairs(part, index, new)
        own = index[: int(np.searchsorted(index, part.own))]
        self._invalid += part.own - len(own)
        radius, number = bed.radius[own], part.number[own]
        if clearance is None:
            found = wall_clearance(bed.container, bed.position[own], radius)
        else:
            found = clearance[own]
        self._outside += int(np.count_nonzero(found < 0.0))
        depth = 1.0 - found / radius
        self._all.see_depths(bed, own, number, depth)
        if new is not None:
            chosen = new[own]
            self._new.see_depths(bed, own[chosen], number[chosen], depth[chosen])

    def _see_pairs(self, part: Part, index: Int64Array, new: BoolArray | None) -> None:
        """Look at all pairs of a part's sound spheres, (S,), that count here; ``new`` has shape (N,)."""
        bed = part.bed
        whole = len(index) == bed.count
        position, radius = (bed.position, bed.radius) if whole else (bed.position[index], bed.radius[index])
        body_index = None if bed.body_index is None else bed.body_index[index]
        for pairs in near_pairs(position, radius, period=bed.container.period, body_index=body_index):
            overlap = -pairs.gap / np.minimum(radius[pairs.first], radius[pairs.second])
            first, second = index[pairs.first], index[pairs.second]
            if not part.is_whole:
                counted = part.counted(first, second)
                first, second, overlap = first[counted], second[counted], overlap[counted]
            if len(overlap) == 0:
                continue
            self._overlap_sum.add(overlap)
            self._overlaps += int(np.count_nonzero(overlap > 0.0))
            self._all.see_pairs(part.name[first], part.name[second], overlap)
            if new is not None:
                chosen = new[first] | new[second]
                ends = part.name[first[chosen]], part.name[second[chosen]]
                self._new.see_pairs(*ends, overlap[chosen])

    def result(self) -> Check:
        """Return what was found of all parts."""
        worst, earlier = self._all.found(), self._earlier
        return Check(
            overlap_max=worst.overlap_max,
            worst_pair=worst.worst_pair,
            overlap_mean=float(self._overlap_sum.exact() / self._overlaps) if self._overlaps else 0.0,
            overlap_count=self._overlaps,
            excess_count=worst.excess_count,
            wall_overlap_max=worst.wall_overlap_max,
            worst_wall_sphere=worst.worst_wall_sphere,
            outside_count=self._outside,
            invalid_count=self._invalid,
            tolerance=self._tolerance,
            worst_wall_part=worst.worst_wall_part,
            new=None if earlier is None else self._new.found(),
            earlier_tolerance=None if earlier is None else earlier.tolerance,
        )
