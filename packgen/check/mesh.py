"""Distance to a triangulated wall, and whether a point is inside it: numpy and scipy, no code of the core.

The closest point on a triangle is the nearest of the three edges' and, where the foot of the perpendicular
lies inside, the plane's.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array, Int64Array, distinct, unique_rows
from packgen.check.inside import inside
from packgen.check.pieces import candidates, pieces
from packgen.geometry import Surface


class MeshWalls:
    """Queries of one surface; an open top is closed by a lid across its rim.

    Args:
        surface: The walls; triangles that are degenerate count as their edges.
    """

    def __init__(self, surface: Surface) -> None:
        lids = lid_corners(surface)
        self._corners = np.concatenate([surface.vertices[surface.faces], lids])

    def distance(self, position: Float64Array, reach: Float64Array) -> Float64Array:
        """Return the distance to the nearest triangle, exact where it is below ``reach``.

        Args:
            position: Points [m], shape (N, 3), float64.
            reach: How far to look from each point [m], shape (N,), float64.

        Returns:
            Unsigned distance [m], at least ``reach`` where no triangle is that near, shape (N,), float64.
        """
        distance = reach.astype(np.float64).copy()
        if len(position) == 0:
            return distance
        limit = float(reach.max())
        centre, size, triangle = pieces(self._corners, 2.0 * limit)
        tree = cKDTree(position, balanced_tree=False, compact_nodes=False)
        for point, face in candidates(tree, centre, size + limit * (1.0 + 1e-9), triangle):
            np.minimum.at(distance, point, point_triangle_distance(position[point], self._corners[face]))
        return distance

    def distance_least(self, position: Float64Array, error: float) -> Float64Array:
        """Return a lower bound of the distance to the nearest triangle, wherever that is.

        Args:
            position: Points [m], shape (N, 3), float64.
            error: How far the bound may fall short of the distance [m].

        Returns:
            Distance to the nearest of the balls that cover the triangles [m], shape (N,), float64; it may be
            negative.
        """
        # The nearest point is in a ball, and each ball holds a point of the walls: at most twice a ball's
        # radius is lost.
        centre, size, _ = pieces(self._corners, error / np.sqrt(2.0))
        nearest = cKDTree(centre, balanced_tree=False, compact_nodes=False).query(position)[0]
        return np.asarray(nearest - float(size.max()))

    def contains(self, position: Float64Array, distance: Float64Array | None = None) -> np.ndarray:
        """Return whether each point (N, 3) [m] is inside, shape (N,), sooner where `distance` is known."""
        return inside(self._corners, position, distance)


def lid_corners(surface: Surface) -> Float64Array:
    """Return triangles (L, 3, 3) that close the open rims: a fan from the middle of each rim."""
    edges = surface.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    if _is_closed(edges, len(surface.vertices)):
        return np.empty((0, 3, 3))
    # Corners are matched by position: a mesh of loose triangles has each corner several times.
    _, corner = unique_rows(surface.vertices)
    place = np.zeros(corner.max() + 1, dtype=np.int64)
    place[corner] = np.arange(len(corner))
    edges = corner[edges]
    directed = {(int(a), int(b)) for a, b in edges}
    # The rim runs against the direction of the walls' open edges, so that the lid faces outward.
    following = {b: a for a, b in directed if (b, a) not in directed and a != b}
    lids: list[Float64Array] = []
    while following:
        start, current = following.popitem()
        loop = [start]
        while current != start and current in following:
            loop.append(current)
            current = following.pop(current)
        rim = surface.vertices[place[np.array(loop)]]
        middle = np.broadcast_to(rim.mean(axis=0), rim.shape)
        lids.append(np.stack([middle, rim, np.roll(rim, -1, axis=0)], axis=1))
    return np.concatenate(lids) if lids else np.empty((0, 3, 3))


def _is_closed(edges: Int64Array, count: int) -> bool:
    """Tell whether every directed edge (E, 2) between ``count`` corners runs the other way as well."""
    along, back = (distinct(edges[:, first] * count + edges[:, 1 - first]) for first in (0, 1))
    return np.array_equal(along, back)


def point_triangle_distance(point: Float64Array, corners: Float64Array) -> Float64Array:
    """Return the distance of each point (K, 3) to its triangle (K, 3, 3), shape (K,)."""
    best = np.full(len(point), np.inf)
    inside = np.ones(len(point), dtype=bool)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    for corner in range(3):
        start, edge = corners[:, corner], corners[:, (corner + 1) % 3] - corners[:, corner]
        relative = point - start
        squared = np.einsum("ij,ij->i", edge, edge)
        share = np.einsum("ij,ij->i", relative, edge) / np.where(squared > 0.0, squared, 1.0)
        rest = relative - np.clip(share, 0.0, 1.0)[:, None] * edge
        np.minimum(best, np.linalg.norm(rest, axis=1), out=best)
        inside &= np.einsum("ij,ij->i", np.cross(edge, relative), normal) >= 0.0
    height = np.abs(np.einsum("ij,ij->i", point - corners[:, 0], normal))
    height /= np.where(length > 0.0, length, 1.0)
    distance: Float64Array = np.where(inside & (length > 0.0), np.minimum(best, height), best)
    return distance
