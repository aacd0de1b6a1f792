"""The worst faults of a bed by name: which spheres they are, and where."""

from __future__ import annotations

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.bed import Bed
from packgen.check.pairs import near_pairs
from packgen.check.parts import part_name_beside
from packgen.part import Part

NAMED_MAX = 20


def named_faults(bed: Bed, clearance: Float64Array, ids: Int64Array | None = None) -> tuple[str, ...]:
    """Return a line for each of the worst faults: spheres in a wall or outside, and pairs that overlap.

    Args:
        bed: The bed, whose numbers are finite.
        clearance: Distance of each centre from the nearest wall [m], shape (N,).
        ids: What a file calls each sphere, shape (N,); None: it has no ids.

    Returns:
        At most twenty lines, the deepest first, and one that says how many more there are. None where the bed
        has no tolerance.
    """
    if bed.tolerance is None:
        return ()
    namer = FaultNamer(bed.tolerance, ids)
    namer.add(Part.whole(bed), clearance)
    return namer.result()


class FaultNamer:
    """Names the worst faults of a bed in parts, as `named_faults` does of one in one piece.

    Args:
        tolerance: Largest overlap that is no fault.
        ids: What a file calls each sphere, shape (N,); None: it has no ids.
    """

    def __init__(self, tolerance: float, ids: Int64Array | None = None) -> None:
        self._tolerance, self._ids = tolerance, ids
        self._found: list[tuple[float, str]] = []
        self._count = 0

    def add(self, part: Part, clearance: Float64Array) -> None:
        """Look at a part; clearance is that of its own spheres, shape (own,)."""
        bed = part.bed
        depth = 1.0 - clearance / bed.radius[: part.own]
        earlier = bed.is_earlier
        # Spheres that a solver has left before may overlap each other and walls by more.
        soft = self._tolerance if bed.earlier is None else _limit(bed.earlier.tolerance)
        may_be_in_wall = earlier[: part.own] & (clearance >= 0.0)
        in_wall = _deepest(depth, np.where(may_be_in_wall, soft, self._tolerance))
        self._count += len(in_wall)
        for each in in_wall[:NAMED_MAX].tolist():
            name = part_name_beside(bed, each)
            deep = f"in the wall{'' if name is None else f' {name}'} by {depth[each]:.3g} of its radius"
            where = "outside the container" if clearance[each] < 0.0 else deep
            self._found.append((depth[each], f"{self._named(part, each)} is {where}"))
        first, second, overlap, pairs = _worst_pairs(part, self._tolerance, soft, earlier)
        self._count += pairs
        for one, other, deep in zip(first.tolist(), second.tolist(), overlap.tolist(), strict=True):
            pair = f"{self._named(part, one)} and {self._named(part, other)}"
            self._found.append((deep, f"{pair} overlap by {deep:.3g} of the smaller radius"))
        self._found.sort(key=lambda each: -each[0])
        del self._found[NAMED_MAX:]

    def result(self) -> tuple[str, ...]:
        """Return the lines of all parts."""
        lines = tuple(line for _, line in self._found)
        rest = self._count - len(lines)
        return (*lines, f"and {rest:,} more of these") if rest else lines

    def _named(self, part: Part, place: int) -> str:
        x, y, z = part.bed.position[place]
        number = int(part.number[place])
        name = f"sphere {number}" if self._ids is None else f"sphere {number} (id {self._ids[number]})"
        return f"{name} at ({x:.6g}, {y:.6g}, {z:.6g})"


def _limit(tolerance: float | None) -> float:
    return np.inf if tolerance is None else tolerance


def _deepest(depth: Float64Array, limit: Float64Array) -> Int64Array:
    """Return the places of depths above their limits, both (N,), the largest first."""
    found = np.flatnonzero(depth > limit)
    return found[np.argsort(-depth[found], kind="stable")].astype(np.int64)


def _worst_pairs(
    part: Part, limit: float, soft: float, earlier: BoolArray
) -> tuple[Int64Array, Int64Array, Float64Array, int]:
    """Return the deepest pairs, at most twenty: both spheres and the overlap of each, and how many exceed.

    Args:
        part: The part of a bed.
        limit: Largest overlap that is no fault.
        soft: The one of two spheres that were there before.
        earlier: Which spheres were, shape (N,).
    """
    bed = part.bed
    kept = [(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))]
    count = 0
    for pairs in near_pairs(bed.position, bed.radius, period=bed.container.period, body_index=bed.body_index):
        overlap = -pairs.gap / np.minimum(bed.radius[pairs.first], bed.radius[pairs.second])
        if not part.is_whole:
            overlap[~part.counted(pairs.first, pairs.second)] = -np.inf
        worst = _deepest(overlap, np.where(earlier[pairs.first] & earlier[pairs.second], soft, limit))
        count += len(worst)
        worst = worst[:NAMED_MAX]
        kept.append((pairs.first[worst], pairs.second[worst], overlap[worst]))
    first, second, overlap = (np.concatenate(parts) for parts in zip(*kept, strict=True))
    order = np.argsort(-overlap, kind="stable")[:NAMED_MAX]
    return first[order], second[order], overlap[order], count
