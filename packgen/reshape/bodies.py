"""Spheres of one body beside each other, where a box that wraps around has torn it apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.bodies import Bodies, members_of


def periods(bed: Bed) -> Int64Array:
    """Return by how many periods each sphere is to be moved to be beside the first one of its body.

    Bodies are narrower than half the box.

    Returns:
        Whole numbers of periods along x, y, z, shape (N, 3), int64; zero where the box does not wrap around,
        and for all spheres of a bed without bodies.
    """
    moves = np.zeros((bed.count, 3), np.int64)
    if bed.body_index is None:
        return moves
    _, first, member = np.unique(bed.body_index, return_index=True, return_inverse=True)
    apart = bed.position - bed.position[first[member]]
    for axis, length in enumerate(bed.container.period):
        if length is not None:
            moves[:, axis] = -np.rint(apart[:, axis] / length).astype(np.int64)
    return moves


def bodies_beside(bed: Bed, position: Float64Array) -> Bodies | None:
    """Return the bodies of a bed whose spheres were moved as wholes, each beside its first sphere.

    Args:
        bed: The bed.
        position: Where its spheres are now, turned by nothing [m], shape (N, 3).
    """
    if bed.bodies is None or bed.body_index is None:
        return None
    first = np.unique(bed.body_index, return_index=True)[1]
    members, _, owner = members_of(bed.bodies)
    apart = members[np.searchsorted(owner, np.arange(len(bed.bodies)))] - bed.bodies.position
    return replace(bed.bodies, position=position[first] - apart)
