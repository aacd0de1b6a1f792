"""Spheres of a bed that was there before and may move again: where they lie in a zone, near its surface.

None of them is ever lost. One that finds no place goes back to where it was, and newcomers give way to it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from packgen.arrange.collective.open_zone import OpenZone
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.space.region import Region
from packgen.arrange.spheres import Spheres, joined
from packgen.arrays import BoolArray, Float64Array

LOOSE = -1
"""Zone number that marks these spheres while a zone is filled."""

IN_WALL = 0.1
"""Depth in a wall [radii] from which such a sphere stays where it is: soft spheres are a few percent deep."""

TRIES = 4
"""Arrangements of a layer in which such spheres may lose their place; then all of them go back."""


def marked(earlier: Spheres, loose_count: int) -> Spheres:
    """Return the spheres at rest, the loose ones marked, each with its place as its batch's number.

    Args:
        earlier: The spheres at rest.
        loose_count: How many of them, the first ones, may move again. Bodies of several spheres may not.
    """
    if loose_count == 0:
        return earlier
    place = np.arange(len(earlier), dtype=np.int32)
    loose = place < loose_count
    if earlier.body_index is not None:
        _, body, size = np.unique(earlier.body_index, return_inverse=True, return_counts=True)
        loose &= size[body] == 1
    zone = np.where(loose, np.int32(LOOSE), earlier.zone_index)
    return replace(earlier, zone_index=zone.astype(np.int32), batch_index=place)


def places(spheres: Spheres, count: int, zone: int) -> Float64Array:
    """Return the centres of marked spheres in their former order [m], shape (count, 3).

    Args:
        spheres: All spheres, marked ones and a zone's own.
        count: Number of marked ones.
        zone: Number of the zone.
    """
    own = spheres.zone_index == zone
    position = np.empty((count, 3))
    position[spheres.batch_index[~own]] = spheres.position[~own]
    return position


def is_loose(spheres: Spheres, region: Region) -> BoolArray:
    """Tell which spheres of a bed that was there before may move again in a region, shape (N,)."""
    loose = spheres.zone_index == LOOSE
    if loose.any():
        loose[loose] = region.encloses(spheres.position[loose], spheres.radius[loose], IN_WALL)
    return np.asarray(loose)


def settled_with_loose(
    zone: OpenZone,
    moving: Spheres,
    fixed: Spheres,
    recipe: Recipe,
    allowed: Callable[[Float64Array, Float64Array], BoolArray],
) -> tuple[Float64Array, BoolArray]:
    """Arrange spheres among fixed ones, as ``OpenZone.settled`` does; all loose ones keep a place.

    Args:
        zone: The zone.
        moving: The spheres to arrange.
        fixed: Those at rest.
        recipe: Constants of the optimiser.
        allowed: Tells which centres (n, 3) of spheres with radii (n,) [m] may be places.

    Returns:
        (centres [m], shape (n, 3); which of them have a place, shape (n,), the loose ones all).
    """
    position, kept = zone.settled(moving, fixed, recipe)
    kept &= allowed(position, moving.radius)
    loose = moving.zone_index == LOOSE
    back = np.zeros(len(moving), bool)
    for tried in range(1, TRIES + 1):
        lost = loose & ~kept
        if not lost.any():
            break
        back |= loose if tried == TRIES else lost
        kept[back] = True
        position[back] = moving.position[back]
        others = np.flatnonzero(kept & ~back)
        again = replace(moving[others], position=position[others])
        position[others], found = zone.settled(again, joined([fixed, moving[back]]), recipe)
        kept[others] = found & allowed(position[others], again.radius)
    return position, kept
