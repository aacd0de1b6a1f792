"""A point that is certainly in the fluid: of many candidates the one farthest from all solids and walls.

Candidates are spread over the channel's box; on a tube the middles of inlet and outlet length are two more.
The best by a lower bound of their distances are measured exactly, from every sphere, bridge and wall.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from exporters.resolved.channel import Channel, cylinder_of
from packgen.arrays import Float64Array
from packgen.errors import ExportError

CANDIDATES = 4096
MEASURED = 64
# Powers of the inverse of the plastic number in three dimensions: no point comes to lie on a plane of cells.
STEPS = np.array([0.8191725133961645, 0.6710436067037893, 0.5497004779019703])


def fluid_point(
    channel: Channel, position: Float64Array, radius: Float64Array, rods: tuple[Float64Array, ...]
) -> tuple[Float64Array, float]:
    """Return a point in the fluid [m], shape (3,), and its distance from all solids and walls [m].

    Args:
        channel: The channel.
        position: Centres of the spheres and images [m], shape (M, 3).
        radius: Their radii [m], shape (M,).
        rods: Bridges: both ends, shape (B, 3) each, and radii, shape (B,) [m].

    Raises:
        ExportError: No candidate is in the fluid.
    """
    candidate = _candidates(channel)
    candidate = candidate[channel.contains(candidate)]
    bound = _bound(candidate, position, radius)
    if channel.kind == "vessel":
        # The walls are many triangles, measured for the best only: points with room enough are alike.
        bound = np.minimum(bound, radius.mean())
    else:
        bound = np.minimum(bound, channel.clearance(candidate))
    best = candidate[np.argsort(-bound, kind="stable")[:MEASURED]]
    clearance = [solid_clearance(point, position, radius, rods) for point in best]
    clear = np.minimum(clearance, channel.clearance(best)) if len(best) else np.empty(0)
    if not len(best) or clear.max() <= 0.0:
        raise ExportError(
            f"surface: no point in the fluid was found among {CANDIDATES} candidates, expected one for "
            "locationInMesh: the spheres fill the container"
        )
    chosen = int(np.argmax(clear))
    return best[chosen], float(clear[chosen])


def _candidates(channel: Channel) -> Float64Array:
    low, high = channel.bounds
    points = [low + (high - low) * ((np.arange(1, CANDIDATES + 1)[:, None] * STEPS) % 1.0)]
    if channel.is_tube:
        middle = cylinder_of(channel.container)[0] if channel.kind == "cylinder" else 0.5 * (low + high)
        for end, bed_end in zip(channel.ends, channel.bed_ends, strict=True):
            # Off the middle by a little: the axis of a tube may be an edge of cells.
            aside = 0.0137 * (high - low).min() * np.array([0.31, 0.53, 0.79])
            points.append((middle + (0.5 * (end + bed_end) - middle @ channel.up) * channel.up + aside)[None])
    return np.concatenate(points)


def _bound(point: Float64Array, position: Float64Array, radius: Float64Array) -> Float64Array:
    """Return a lower bound of the distance of points (M, 3) from all spheres [m], by octaves of radii."""
    octave = np.floor(np.log2(radius / radius.min()) + 1e-9)
    bound = np.full(len(point), np.inf)
    for value in np.unique(octave):
        own = octave == value
        distance, _ = cKDTree(position[own]).query(point)
        bound = np.minimum(bound, distance - radius[own].max())
    return bound


def solid_clearance(
    point: Float64Array, position: Float64Array, radius: Float64Array, rods: tuple[Float64Array, ...]
) -> float:
    """Return the distance of a point (3,) from all spheres and rods [m]; negative inside."""
    clear = float((np.linalg.norm(position - point, axis=1) - radius).min())
    start, stop, thick = rods
    if not len(thick):
        return clear
    axis = stop - start
    share = np.clip(((point - start) * axis).sum(axis=1) / (axis**2).sum(axis=1), 0.0, 1.0)
    away = np.linalg.norm(start + share[:, None] * axis - point, axis=1) - thick
    return min(clear, float(away.min()))
