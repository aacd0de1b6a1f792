"""The independent check of a bed: does anything overlap, and is every sphere inside?

It shares no code with the core: pairs by scipy's k-d trees, walls by closed forms, meshes by distances of
its own. A bed is judged here and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.check.pairs import near_pairs
from packgen.check.walls import wall_clearance

__all__ = ["Check", "NewOverlaps", "check_bed", "near_pairs", "wall_clearance"]


@dataclass(frozen=True, slots=True)
class NewOverlaps:
    """Overlaps of the spheres that were placed beside others; fractions of the smaller radius.

    Attributes:
        overlap_max: Largest overlap of two spheres, one of which is new at least; 0 where none overlap.
        worst_pair: The two spheres of that overlap; None where none overlap.
        excess_count: Number of such pairs that overlap by more than the tolerance.
        wall_overlap_max: Largest depth of a new sphere in a wall; 0 where none.
        worst_wall_sphere: The sphere of that depth; None where none touches deeper than zero.
    """

    overlap_max: float
    worst_pair: tuple[int, int] | None
    excess_count: int
    wall_overlap_max: float
    worst_wall_sphere: int | None


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
        new: The overlaps of new spheres, where others were there before; None: all are new. Those may overlap
            each other by ``earlier_tolerance``, the new ones nothing by more than ``tolerance``.
        earlier_tolerance: Largest overlap of two spheres that were there before, or of one with a wall; None:
            any.
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
    new: NewOverlaps | None = None
    earlier_tolerance: float | None = None

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
                f"sphere {self.worst_wall_sphere}, which was there before, is in the wall by "
                f"{self.wall_overlap_max:.3g} of its radius, limit {limit:.3g}"
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
            f"sphere {found.worst_wall_sphere} is in the wall by {found.wall_overlap_max:.3g} of its "
            f"radius, tolerance {limit:.3g}"
        )
    return lines


class _Worst:
    """The worst of the pairs seen so far, by overlap.

    Args:
        limit: Overlap beyond which pairs are counted.
    """

    def __init__(self, limit: float) -> None:
        self._limit = limit
        self.overlap, self.pair, self.excess_count = 0.0, (-1, -1), 0

    def see(self, overlap: Float64Array, first: Int64Array, second: Int64Array) -> None:
        """Look at some pairs: overlaps (P,), and the indices of both spheres (P,)."""
        if len(overlap) == 0:
            return
        self.excess_count += int(np.count_nonzero(overlap > self._limit))
        worst = int(overlap.argmax())
        if overlap[worst] > self.overlap:
            self.overlap = float(overlap[worst])
            self.pair = (int(first[worst]), int(second[worst]))

    @property
    def worst_pair(self) -> tuple[int, int] | None:
        """The worst pair; None where none overlap."""
        return self.pair if self.overlap > 0.0 else None


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
    earlier = None if bed.earlier is None else bed.is_earlier
    limit = np.inf if bed.tolerance is None else bed.tolerance
    worst, worst_new, overlap_sum, overlap_count = _Worst(limit), _Worst(limit), 0.0, 0
    for pairs in near_pairs(position, radius, period=bed.container.period, body_index=body_index):
        overlap = -pairs.gap / np.minimum(radius[pairs.first], radius[pairs.second])
        overlap_sum += float(overlap.sum())
        overlap_count += int(np.count_nonzero(overlap > 0.0))
        first, second = index[pairs.first], index[pairs.second]
        worst.see(overlap, first, second)
        if earlier is not None:
            new = ~(earlier[first] & earlier[second])
            worst_new.see(overlap[new], first[new], second[new])
    clearance = wall_clearance(bed.container, position, radius) if clearance is None else clearance[index]
    depth = 1.0 - clearance / radius
    wall_overlap, worst_wall = _deepest(depth, index)
    new_overlaps = None
    if earlier is not None:
        of_new = ~earlier[index]
        new_overlaps = NewOverlaps(
            worst_new.overlap, worst_new.worst_pair, worst_new.excess_count,
            *_deepest(depth[of_new], index[of_new]),
        )  # fmt: skip
    return Check(
        overlap_max=worst.overlap,
        worst_pair=worst.worst_pair,
        overlap_mean=overlap_sum / overlap_count if overlap_count else 0.0,
        overlap_count=overlap_count,
        excess_count=worst.excess_count,
        wall_overlap_max=wall_overlap,
        worst_wall_sphere=worst_wall,
        outside_count=int(np.count_nonzero(clearance < 0.0)),
        invalid_count=int(bed.count - len(index)),
        tolerance=bed.tolerance,
        new=new_overlaps,
        earlier_tolerance=None if bed.earlier is None else bed.earlier.tolerance,
    )


def _deepest(depth: Float64Array, index: Int64Array) -> tuple[float, int | None]:
    """Return the largest depth in a wall and its sphere; 0 and None where none is in one."""
    worst = int(depth.argmax()) if len(depth) else -1
    if worst < 0 or not depth[worst] > 0.0:
        return 0.0, None
    return float(depth[worst]), int(index[worst])
