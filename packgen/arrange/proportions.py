"""The end of a zone that was filled until full: spheres beyond the sets' proportions are taken out again."""

from __future__ import annotations

import numpy as np

from packgen.arrange.spheres import Spheres, rows_of_bodies
from packgen.arrays import Float64Array, Int64Array
from packgen.portable import components, cube
from packgen.supply.shares import largest_remainder

TRIM_SHARE = 0.05
"""Largest share of a zone's solid volume that is taken out. Where more is beyond the proportions, some sizes
found no room, and taking out all that exceeds them would empty the zone."""


def trimmed_to_shares(spheres: Spheres, shares: Float64Array, up: Float64Array) -> Spheres:
    """Return a zone without the highest spheres, or bodies, of sets that have too many.

    Args:
        spheres: The spheres of the zone.
        shares: Share of each set by number, shape (sets,), sum 1.
        up: Unit vector against gravity, shape (3,).
    """
    each = rows_of_bodies(spheres)
    surplus = surplus_of(np.bincount(each.set_index, minlength=len(shares)), shares)
    kept = np.ones(len(each), bool)
    altitude = components(each.position, up)
    for number in np.flatnonzero(surplus):
        members = np.flatnonzero(each.set_index == number)
        highest = np.argsort(-altitude[members], kind="stable")[: surplus[number]]
        kept[members[highest]] = False
    if cube(each.radius[~kept]).sum() > TRIM_SHARE * cube(each.radius).sum():
        return spheres
    if each is not spheres and spheres.body_index is not None and each.body_index is not None:
        return spheres[np.isin(spheres.body_index, each.body_index[kept])]
    return spheres[kept]


def surplus_of(count: Int64Array, shares: Float64Array) -> Int64Array:
    """Return how many spheres of each set are beyond the largest zone that matches the shares, shape (sets,).

    Args:
        count: Spheres of each set, shape (sets,).
        shares: Share of each set by number, shape (sets,), sum 1.
    """
    used = shares > 0.0
    total = min(int(np.floor(((count + 1)[used] / shares[used]).min())), int(count.sum()))
    while (largest_remainder(shares, total) > count).any():
        total -= 1
    return count - largest_remainder(shares, total)
