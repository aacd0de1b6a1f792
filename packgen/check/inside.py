"""Which side of a triangulated wall a point is on, by winding numbers.

Space is cut into cells. A region of cells that no wall enters is on one side as a whole, and one point of it
decides, by the solid angles of all triangles (van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30, 1983,
125). A point in another cell is on the side of such a region where no wall is as near as one of its cells.
For the remaining points the signed crossings of two rays are counted. Where these disagree, solid angles
decide again.
"""

from __future__ import annotations

import numpy as np
from scipy.ndimage import label, maximum_filter
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.check.pieces import candidates, piece_count, pieces

CELLS_A_POINT = 250  # enough that few sphere centres share a cell with a wall
CELLS_MIN, CELLS_MAX = 20_000, 4_000_000
PIECES_MAX = 2_000_000
RINGS = 2  # cells around a point's own in which it looks for a region
BLOCK_SIZE = 1_000_000  # point-triangle pairs held at a time
# Directions along no edge of usual meshes.
RAYS = np.array([[0.28365421, -0.13972153, 0.94869273], [-0.91324517, 0.36481023, -0.18119206]])


def inside(corners: Float64Array, position: Float64Array, distance: Float64Array | None = None) -> np.ndarray:
    """Return whether points are inside a closed surface.

    Args:
        corners: Triangles [m], counter-clockwise from outside, shape (F, 3, 3), float64.
        position: Points [m], shape (N, 3), float64.
        distance: No triangle is nearer to each point than this [m], shape (N,); None: nothing is known.

    Returns:
        Whether each point is inside, shape (N,), bool.
    """
    result = np.zeros(len(position), dtype=bool)
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    near = np.flatnonzero(((position >= low) & (position <= high)).all(axis=1))
    if len(near) == 0:
        return result
    region = _regions(corners, position[near], None if distance is None else distance[near], low, high)
    at_wall = near[region == 0]
    result[at_wall] = _by_rays(corners, position[at_wall])
    free = near[region > 0]
    _, first, member = np.unique(region[region > 0], return_index=True, return_inverse=True)
    result[free] = (solid_angle_winding(corners, position[free[first]]) > 0.5)[member]
    return result


def _regions(
    corners: Float64Array,
    position: Float64Array,
    distance: Float64Array | None,
    low: Float64Array,
    high: Float64Array,
) -> Int64Array:
    """Return the number of the wall-free region that each point is in or sees, 0 for none, (N,), int64."""
    extent = high - low
    cells = min(max(CELLS_A_POINT * len(position), CELLS_MIN), CELLS_MAX)
    size = float(np.cbrt(np.maximum(extent, 1e-6 * extent.max()).prod() / cells))
    while piece_count(corners, size) > PIECES_MAX:
        size *= 1.5
    count = np.floor(extent / size).astype(np.int64) + 1
    centre, _, _ = pieces(corners, size)
    cell = np.clip(np.floor((centre - low) / size).astype(np.int64), 0, count - 1)
    walls = np.zeros(count, dtype=bool)
    walls[cell[:, 0], cell[:, 1], cell[:, 2]] = True
    # A piece reaches no farther than 0.71 cells from its middle.
    walls = maximum_filter(walls, size=3, mode="constant")
    regions = np.asarray(label(~walls)[0], dtype=np.int32)
    cell = np.clip(np.floor((position - low) / size).astype(np.int64), 0, count - 1)
    region: Int64Array = regions[cell[:, 0], cell[:, 1], cell[:, 2]].astype(np.int64)
    if distance is not None:
        _look_around(region, regions, position, distance, low, size)
    return region


def _look_around(
    region: Int64Array,
    regions: Int32Array,
    position: Float64Array,
    distance: Float64Array,
    low: Float64Array,
    size: float,
) -> None:
    """Give points without a region that of a cell whose middle is nearer to them than any wall."""
    cell = np.floor((position - low) / size).astype(np.int64)
    steps = np.stack(np.meshgrid(*[np.arange(-RINGS, RINGS + 1)] * 3), axis=-1).reshape(-1, 3)
    for step in steps[np.argsort((steps**2).sum(axis=1), kind="stable")]:
        lost = np.flatnonzero(region == 0)
        other = cell[lost] + step
        apart = np.linalg.norm(low + (other + 0.5) * size - position[lost], axis=1)
        seen = (apart < distance[lost] * (1.0 - 1e-9)) & ((other >= 0) & (other < regions.shape)).all(axis=1)
        lost, other = lost[seen], other[seen]
        region[lost] = regions[other[:, 0], other[:, 1], other[:, 2]]


def _by_rays(corners: Float64Array, position: Float64Array) -> np.ndarray:
    """Return whether points are inside by two rays each; solid angles decide where one ray meets an edge."""
    first, second = (ray_winding(corners, position, ray) for ray in RAYS)
    result: np.ndarray = first == 1
    doubtful = np.flatnonzero((first != second) | ((first != 0) & (first != 1)))
    result[doubtful] = solid_angle_winding(corners, position[doubtful]) > 0.5
    return result


def ray_winding(corners: Float64Array, position: Float64Array, ray: Float64Array) -> Int64Array:
    """Return how often a ray from each point leaves the surface less how often it enters, shape (N,)."""
    winding = np.zeros(len(position), dtype=np.int64)
    if len(position) == 0:
        return winding
    side = np.cross(ray, [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    frame = np.stack([side, np.cross(ray, side), ray])  # rows: two across the ray, one along
    extent = float(np.linalg.norm(np.ptp(corners.reshape(-1, 3), axis=0)))
    centre, size, triangle = pieces(corners, extent / 40.0)
    points, turned = position @ frame.T, corners @ frame.T
    flat = cKDTree(points[:, :2], balanced_tree=False, compact_nodes=False)
    for point, face in candidates(flat, (centre @ frame.T)[:, :2], size, triangle):
        np.add.at(winding, point, _crossings(turned[face] - points[point][:, None, :]))
    return winding


def _crossings(relative: Float64Array) -> Int64Array:
    """Return +1 or -1 where the ray along the third axis from the origin leaves or enters by a triangle.

    Args:
        relative: Corners as seen from the points, in the ray's frame [m], shape (K, 3, 3), float64.

    Returns:
        +1 out, -1 in, 0 past it, shape (K,), int64.
    """
    a, b, c = relative[:, 0], relative[:, 1], relative[:, 2]
    area_a = b[:, 0] * c[:, 1] - b[:, 1] * c[:, 0]
    area_b = c[:, 0] * a[:, 1] - c[:, 1] * a[:, 0]
    area_c = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    outward = (area_a > 0) & (area_b > 0) & (area_c > 0)
    inward = (area_a < 0) & (area_b < 0) & (area_c < 0)
    # The height of the hit times the projected area, whose sign is that of the direction.
    lifted = area_a * a[:, 2] + area_b * b[:, 2] + area_c * c[:, 2]
    return (outward & (lifted > 0)).astype(np.int64) - (inward & (lifted < 0)).astype(np.int64)


def solid_angle_winding(corners: Float64Array, position: Float64Array) -> Float64Array:
    """Return the winding number of the surface around each point, shape (N,), float64."""
    winding = np.empty(len(position))
    step = max(1, BLOCK_SIZE // max(1, len(corners)))
    for start in range(0, len(position), step):
        relative = corners[None] - position[start : start + step, None, None, :]
        a, b, c = relative[:, :, 0], relative[:, :, 1], relative[:, :, 2]
        length_a, length_b, length_c = (np.linalg.norm(each, axis=-1) for each in (a, b, c))
        triple = np.einsum("ijk,ijk->ij", a, np.cross(b, c))
        bottom = (
            length_a * length_b * length_c
            + np.einsum("ijk,ijk->ij", a, b) * length_c
            + np.einsum("ijk,ijk->ij", b, c) * length_a
            + np.einsum("ijk,ijk->ij", c, a) * length_b
        )
        winding[start : start + step] = np.arctan2(triple, bottom).sum(axis=1) / (2.0 * np.pi)
    return winding
