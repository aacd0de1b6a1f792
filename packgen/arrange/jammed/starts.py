"""Where the soft spheres start: at random in a region, and not beyond its walls."""

from __future__ import annotations

import numpy as np

from packgen.arrange.space.region import Region
from packgen.arrays import Float64Array
from packgen.errors import PackingError

SHARES = (0.8, 0.4, 0.1, 0.0)
"""Shares of its radius that a sphere keeps from the walls: close to a sheet it might be pushed through."""

ROUNDS = 50
"""Times that points are drawn with one of these shares."""

SAMPLES = 8_192
"""Random points that measure a region."""

SHELL_LOSS = 0.23
"""Share of its solid that a wall costs the space within a radius of it, in a jammed bed."""


def random_points(region: Region, radius: Float64Array, rng: np.random.Generator, place: str) -> Float64Array:
    """Return a random centre for each sphere in a region [m], shape (N, 3); spheres may overlap.

    Args:
        region: The region.
        radius: Radii [m], shape (N,).
        rng: Source of randomness.
        place: Where the scene names the zone, for messages.

    Raises:
        PackingError: Hardly any point is inside.
    """
    low, high = region.bounds
    points = np.empty((len(radius), 3))
    missing = np.arange(len(radius))
    for share in SHARES:
        for _ in range(ROUNDS):
            if len(missing) == 0:
                return points
            tried = low + rng.random((len(missing), 3)) * (high - low)
            good = region.clearance(tried) >= share * radius[missing]
            points[missing[good]] = tried[good]
            missing = missing[~good]
    if len(missing) == 0:
        return points
    raise PackingError(f"{place}: not one sphere fits; expected a larger container or smaller spheres")


def volume_and_loss(region: Region, radius: float) -> tuple[float, float]:
    """Return the volume of a region [m3], by points, and the share of its solid that walls cost a jammed bed.

    Args:
        region: The region.
        radius: Mean radius, each sphere counted by its volume [m].
    """
    low, high = region.bounds
    points = low + np.random.default_rng(0).random((SAMPLES, 3)) * (high - low)
    clearance = region.clearance(points)
    inside = float((clearance >= 0.0).mean())
    deep = float((clearance >= radius).mean())
    volume = inside * float(np.prod(high - low))
    return volume, SHELL_LOSS * (1.0 - deep / max(inside, 1e-300))
