"""The end of a zone that was filled until full: spheres beyond the sets' proportions are taken out again."""

from __future__ import annotations

import numpy as np

from packgen.arrange.pile import Pile
from packgen.arrays import Float64Array, Int64Array
from packgen.portable import components, cube
from packgen.supply.shares import largest_remainder

TRIM_SHARE = 0.05
"""Largest share of a zone's volume of spheres that is taken out: where more is beyond the proportions, some
sizes found no room, and to keep only what matches them would empty the zone."""


def trim_to_shares(pile: Pile, zone_index: int, shares: Float64Array, up: Float64Array) -> None:
    """Take the highest spheres of sets that have too many out of a zone, until the others match them.

    Args:
        pile: All spheres; all of them become part of its front.
        zone_index: Number of the zone.
        shares: Share of each set by number, shape (sets,), sum 1.
        up: Unit vector against gravity, shape (3,).
    """
    pile.unearth()
    front = pile.front
    own = np.flatnonzero(front.zone_index == zone_index)
    sets = front.set_index[own]
    surplus = surplus_of(np.bincount(sets, minlength=len(shares)), shares)
    kept = np.ones(len(front), bool)
    altitude = components(front.position[own], up)
    for number in np.flatnonzero(surplus):
        members = np.flatnonzero(sets == number)
        highest = np.argsort(-altitude[members], kind="stable")[: surplus[number]]
        kept[own[members[highest]]] = False
    if cube(front.radius[~kept]).sum() <= TRIM_SHARE * cube(front.radius[own]).sum():
        pile.front = front[kept]


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
