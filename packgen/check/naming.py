"""The worst faults of a bed by name: which spheres they are, and where."""

from __future__ import annotations

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.bed import Bed
from packgen.check.pairs import near_pairs

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
    depth = 1.0 - clearance / bed.radius
    earlier = bed.is_earlier
    # Spheres that a solver has left before may overlap each other and walls by more.
    soft = bed.tolerance if bed.earlier is None else _limit(bed.earlier.tolerance)
    in_wall = _deepest(depth, np.where(earlier & (clearance >= 0.0), soft, bed.tolerance))
    first, second, overlap, pair_count = _worst_pairs(bed, bed.tolerance, soft, earlier)
    found = [
        (
            depth[each],
            f"{_named(bed, ids, each)} is outside the container"
            if clearance[each] < 0.0
            else f"{_named(bed, ids, each)} is in the wall by {depth[each]:.3g} of its radius",
        )
        for each in in_wall[:NAMED_MAX].tolist()
    ]
    for one, other, deep in zip(first.tolist(), second.tolist(), overlap.tolist(), strict=True):
        pair = f"{_named(bed, ids, one)} and {_named(bed, ids, other)}"
        found.append((deep, f"{pair} overlap by {deep:.3g} of the smaller radius"))
    found.sort(key=lambda each: -each[0])
    lines = [line for _, line in found[:NAMED_MAX]]
    rest = len(in_wall) + pair_count - len(lines)
    return (*lines, f"and {rest:,} more of these") if rest else tuple(lines)


def _limit(tolerance: float | None) -> float:
    return np.inf if tolerance is None else tolerance


def _deepest(depth: Float64Array, limit: float | Float64Array) -> Int64Array:
    """Return the places of depths above a limit, or each above its own, the largest first."""
    found = np.flatnonzero(depth > limit)
    return found[np.argsort(-depth[found], kind="stable")].astype(np.int64)


def _worst_pairs(
    bed: Bed, limit: float, soft: float, earlier: BoolArray
) -> tuple[Int64Array, Int64Array, Float64Array, int]:
    """Return the deepest pairs, at most twenty: both spheres and the overlap of each, and how many exceed.

    Args:
        bed: The bed.
        limit: Largest overlap that is no fault.
        soft: The one of two spheres that were there before.
        earlier: Which spheres were, shape (N,).
    """
    kept = [(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))]
    count = 0
    for pairs in near_pairs(bed.position, bed.radius, period=bed.container.period, body_index=bed.body_index):
        overlap = -pairs.gap / np.minimum(bed.radius[pairs.first], bed.radius[pairs.second])
        worst = _deepest(overlap, np.where(earlier[pairs.first] & earlier[pairs.second], soft, limit))
        count += len(worst)
        worst = worst[:NAMED_MAX]
        kept.append((pairs.first[worst], pairs.second[worst], overlap[worst]))
    first, second, overlap = (np.concatenate(parts) for parts in zip(*kept, strict=True))
    order = np.argsort(-overlap, kind="stable")[:NAMED_MAX]
    return first[order], second[order], overlap[order], count


def _named(bed: Bed, ids: Int64Array | None, place: int) -> str:
    x, y, z = bed.position[place]
    name = f"sphere {place}" if ids is None else f"sphere {place} (id {ids[place]})"
    return f"{name} at ({x:.6g}, {y:.6g}, {z:.6g})"
