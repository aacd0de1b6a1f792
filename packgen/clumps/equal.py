"""Equal spheres for a body: the radius at which so many of them cover most, and where they may be."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array
from packgen.clumps.body import Body
from packgen.clumps.cover_kernels import choose, gaps

RADII = 12
THINNED = 3  # of so many points one is enough to compare radii
SMALLEST = 0.2  # of the largest inscribed sphere: the least radius that is tried
FEET = 600


def equal_balls(
    body: Body, inside: Float64Array, ball: Float64Array, most: int, rest: int, least: float
) -> tuple[Float64Array, float]:
    """Return inscribed balls of one radius to choose from, by the best radius.

    Args:
        body: The body.
        inside: Points in it, in equivalent diameters, shape (N, 3).
        ball: Its largest inscribed balls, shape (K, 4).
        most: Number of spheres at most.
        rest: Number of points that may stay uncovered.
        least: Least radius.

    Returns:
        (centres and the radius, shape (K, 4), float64; the radius).
    """
    largest = float(ball[:, 3].max())
    lowest = min(max(SMALLEST * largest, least), largest)
    point, into = body.feet(FEET)
    few, rest = np.ascontiguousarray(inside[::THINNED]), rest // THINNED
    spread = inside[:: max(len(inside) // FEET, 1)]
    found: list[tuple[tuple[int, int], Float64Array, float]] = []
    for radius in np.geomspace(lowest, largest, RADII):
        centre = np.concatenate([ball[ball[:, 3] >= radius][:FEET, :3], point + radius * into, spread])
        centre = centre[body.tree.distance(centre) >= radius * (1.0 - 1e-12)]
        if not len(centre):
            continue
        # Centres outside of the body are as far from its surface: they cover nothing of it.
        equal = np.column_stack([centre, np.full(len(centre), radius)])
        chosen = equal[choose(few, equal, 0, most, rest)]
        left = int((gaps(few, chosen) > 0.0).sum())
        found.append(((max(left - rest, 0), len(chosen)), equal, float(radius)))
    _, equal, radius = min(found, key=lambda each: each[0])
    return equal, radius
