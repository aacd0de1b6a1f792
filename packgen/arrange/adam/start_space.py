"""Where adam's batches may start: the part of a zone's region that is clear of earlier spheres."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.adam.zone import ZoneSpace
from packgen.arrange.neighbors.point_kernels import close_points, point_grid
from packgen.arrange.space.region import SECTION_POINTS, Region
from packgen.arrange.spheres import Spheres
from packgen.arrays import Float64Array
from packgen.errors import PackingError

SAMPLE_ROUNDS = 200
"""Rounds of random points until a narrow zone is given up."""


def zone_space(region: Region, earlier: Spheres, radius: float, place: str) -> ZoneSpace:
    """Return where the spheres of a zone may start.

    Args:
        region: The zone's space.
        earlier: The spheres that are there already.
        radius: The zone's largest radius [m]: every start is clear of the earlier spheres by it.
        place: Where the scene names the zone, for messages.

    Returns:
        The space. The free share of a section is known to about 1 %. Drawing from a space too narrow to find
        room in raises PackingError.
    """

    def clear(points: Float64Array) -> NDArray[np.bool_]:
        closed = np.zeros(len(points), bool)
        if len(points) and len(earlier):
            seams = region.walls.seams
            grid = point_grid(points, seams.low, seams.period)
            close_points(earlier.position, earlier.radius + radius, grid, closed)
        return ~closed

    def free(altitude: float) -> float:
        if not len(earlier):
            return 1.0
        points = region.sample(np.random.default_rng(0), SECTION_POINTS, altitude, altitude)
        return float(clear(points).mean()) if len(points) else 0.0

    def sample_above(rng: np.random.Generator, count: int, height: float, thickness: float) -> Float64Array:
        points = np.empty((0, 3))
        for _ in range(SAMPLE_ROUNDS):
            more = region.sample(rng, 2 * count + 64, height, height + thickness)
            points = np.concatenate([points, more[clear(more)]])[:count]
            if len(points) == count:
                return points
        raise PackingError(
            f"{place}: no room at altitude {height:.4g} m; expected a zone wider than its spheres"
        )

    return ZoneSpace(region.floor, region.ceiling, region.area, free, sample_above)
