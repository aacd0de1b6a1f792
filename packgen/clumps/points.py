"""Points within a body, round it and on its surface, spread evenly: what spheres are chosen and judged by."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.clumps.column_kernels import column_crossings

GOLDEN = 0.6180339887498949
PLASTIC = (0.7548776662466927, 0.5698402909980532)
"""Steps of the most even sequences on a line and in a square (Roberts, 2018)."""

GRID_MAX = 12
"""Points of the whole grid for each one asked for: a body may fill little of its box."""

NEAR_CORNERS = (0.03, 0.1, 0.25, 0.5)
"""Where points near a facet's corners are, as shares of the way to its middle."""

FACETS_CORNERED = 3000
"""A mesh of more facets has points enough near its corners anyway."""


@dataclass(frozen=True, eq=False, slots=True)
class VolumePoints:
    """Points of a grid, each shifted within its cell.

    Attributes:
        inside: Points in the body [m], shape (I, 3), float64.
        outside: Points in its box and a margin, but not in the body [m], shape (O, 3), float64.
        cell: Volume that each point stands for [m3].
    """

    inside: Float64Array
    outside: Float64Array
    cell: float


def volume_points(
    corners: Float64Array, volume: float, count: int, margin: float = 0.0, shift: float = 0.0
) -> VolumePoints:
    """Return points within a closed surface and round it.

    Args:
        corners: Triangles, counter-clockwise from outside [m], shape (F, 3, 3).
        volume: What they bound [m3].
        count: About how many points inside; fewer where the body fills little of its box.
        margin: How far round the body's box points are wanted [m].
        shift: Which of many sets of points, any number.
    """
    low, high = corners.min(axis=(0, 1)) - margin, corners.max(axis=(0, 1)) + margin
    box = float(np.prod(high - low))
    size = float(np.cbrt(max(volume / count, box / (GRID_MAX * count))))
    cells = np.maximum(np.ceil((high - low) / size), 1).astype(np.int64)
    columns = int(cells[0] * cells[1])
    number = np.arange(columns)
    place = np.stack([number // cells[1], number % cells[1]], axis=1).astype(np.float64)
    for axis, step in enumerate(PLASTIC):
        # Shifted, so that columns run through no edge of a facet.
        place[:, axis] += (0.5 + shift * GOLDEN + step * (number + 1)) % 1.0
    column = low[:2] + size * place
    height = low[2] + size * (
        np.arange(cells[2]) + (GOLDEN * np.arange(columns * cells[2]) + shift).reshape(columns, -1) % 1.0
    )
    start, crossing, turn = column_crossings(
        np.ascontiguousarray(corners.reshape(-1, 9)), column, low[:2], size, cells[:2]
    )
    within = _between(start, crossing, turn, height)
    point = np.empty((columns, int(cells[2]), 3))
    point[:, :, :2], point[:, :, 2] = column[:, None], height
    return VolumePoints(np.ascontiguousarray(point[within]), np.ascontiguousarray(point[~within]), size**3)


def _between(start: Int64Array, crossing: Float64Array, turn: Int64Array, height: Float64Array) -> np.ndarray:
    """Return whether points of columns (C, Z) are where the surface has been entered more often than left."""
    owner = np.repeat(np.arange(len(height)), np.diff(start))
    order = np.lexsort((crossing, owner))
    crossing, turn, owner = crossing[order], turn[order], owner[order]
    winding = np.zeros(height.shape, np.int64)
    for column, first, last in zip(range(len(height)), start[:-1], start[1:], strict=True):
        if last > first:
            depth = np.append(0, np.cumsum(turn[first:last]))
            if depth[-1] == 0:  # else the column met an edge
                winding[column] = depth[np.searchsorted(crossing[first:last], height[column])]
    return winding > 0


def surface_points(corners: Float64Array, count: int, shift: float = 0.5) -> tuple[Float64Array, Int64Array]:
    """Return points spread evenly over triangles.

    Args:
        corners: Triangles [m], shape (F, 3, 3).
        count: How many points.
        shift: Which of many sets of points, from 0 to 1.

    Returns:
        (points [m], shape (N, 3), float64; triangle of each, shape (N,), int64).
    """
    area = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    total = np.cumsum(area)
    place = (np.arange(count) + shift) / count * total[-1]
    triangle = np.minimum(np.searchsorted(total, place, side="right"), len(corners) - 1)
    pair = [(0.5 + step * (np.arange(count) + 1)) % 1.0 for step in PLASTIC]
    root = np.sqrt(pair[0])
    share = np.stack([1.0 - root, root * (1.0 - pair[1]), root * pair[1]], axis=1)
    return np.einsum("nk,nki->ni", share, corners[triangle]), triangle


def corner_points(corners: Float64Array) -> tuple[Float64Array, Int64Array]:
    """Return points near the corners of a coarse mesh's triangles, and the triangle of each; else none."""
    if len(corners) > FACETS_CORNERED:
        return np.empty((0, 3)), np.empty(0, np.int64)
    middle = corners.mean(axis=1, keepdims=True)
    share = np.array(NEAR_CORNERS)[:, None, None, None]
    point = (corners + share * (middle - corners)).reshape(-1, 3)
    return point, np.tile(np.repeat(np.arange(len(corners)), 3), len(NEAR_CORNERS))


def inward(corners: Float64Array) -> Float64Array:
    """Return the unit vectors into the body across triangles (F, 3, 3), shape (F, 3)."""
    normal = np.cross(corners[:, 2] - corners[:, 0], corners[:, 1] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    return np.asarray(normal / np.where(length > 0.0, length, 1.0))
