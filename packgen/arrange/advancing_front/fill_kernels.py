"""Spheres for voids taken one by one where they still have room; the nearest walls of points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.advancing_front.cell_kernels import enter, is_free
from packgen.arrange.advancing_front.place_kernels import Bed
from packgen.arrange.advancing_front.surface_kernels import wall_room
from packgen.arrange.space.feature_kernels import Features, wall_gap
from packgen.arrange.space.map_kernels import FeatureMap
from packgen.compiled import loop


@loop
def take_places(bed: Bed, count: int, found: NDArray[np.float64], volume: float) -> int:
    """Place spheres in their order where they overlap nothing, up to a volume.

    Args:
        bed: The spheres that there are; changes. Its arrays have room for all that are found.
        count: How many spheres there are.
        found: Centres and radii [m], shape (F, 4).
        volume: Sum of the cubes of their radii at which no more are placed [m3].

    Returns:
        How many spheres there are now.
    """
    total = 0.0
    for k in range(len(found)):
        if total >= volume:
            break
        radius = found[k, 3]
        if is_free(bed.cells, bed.ball, found[k], radius, bed.radius_max[0], bed.slack[0]):
            bed.ball[count] = found[k]
            enter(bed.cells, bed.ball, count)
            bed.radius_max[0] = max(bed.radius_max[0], radius)
            total += radius * radius * radius
            count += 1
    return count


@loop
def nearest_walls(  # type: ignore[no-untyped-def]
    points: NDArray[np.float64], features: Features, near: FeatureMap
):
    """Return the distances of points, shape (N, 3), from the nearest walls [m], (N,), and unit vectors away.

    The distance is infinite where no wall is near.
    """
    gap, push = np.full(len(points), np.inf), np.zeros((len(points), 3))
    for p in range(len(points)):
        x, y, z = points[p, 0], points[p, 1], points[p, 2]
        _, f = wall_room(x, y, z, 0.0, features, near)
        if f >= 0:
            gap[p], push[p, 0], push[p, 1], push[p, 2] = wall_gap(
                features.kind[f], features.row[f], x, y, z, 0.0
            )
    return gap, push
