"""Distance to a triangulated wall, and which side of it a point is on: numpy and scipy, no code of the core.

Closest point on a triangle: the nearest of the three edges and, where the foot of the perpendicular lies
inside, the plane. Inside or outside: the sum of signed crossings of a ray, which is the winding number; where
it is in doubt, the winding number by the solid angles of the triangles (van Oosterom and Strackee, IEEE
Trans. Biomed. Eng. 30, 1983, 125).
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array, Int64Array
from packgen.geometry import Surface

BLOCK_SIZE = 1_000_000  # point-triangle pairs held at a time: about 250 MB at the peak
# A direction that is along no edge of any mesh that people draw.
RAY = np.array([0.28365421, -0.13972153, 0.94869273])


class MeshWalls:
    """Queries of one surface; an open top is closed by a lid across its rim.

    Args:
        surface: The walls; triangles that are degenerate count as their edges.
    """

    def __init__(self, surface: Surface) -> None:
        lids = _lid_corners(surface)
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
        centre, size, triangle = _pieces(self._corners, 3.0 * limit)
        tree = cKDTree(position, balanced_tree=False, compact_nodes=False)
        for point, face in _candidates(tree, centre, size + limit * (1.0 + 1e-9), triangle):
            np.minimum.at(distance, point, _point_triangle_distance(position[point], self._corners[face]))
        return distance

    def contains(self, position: Float64Array) -> np.ndarray:
        """Return whether each point (N, 3) [m] is inside, shape (N,), bool."""
        winding = self._ray_winding(position)
        # A ray through an edge miscounts; a miscount looks outside, or inside more than once.
        doubtful = np.flatnonzero(winding != 1)
        exact = self._solid_angle_winding(position[doubtful])
        winding = winding.astype(np.float64)
        winding[doubtful] = exact
        inside: np.ndarray = winding > 0.5
        return inside

    def _ray_winding(self, position: Float64Array) -> Int64Array:
        """Return the signed number of walls that a ray from each point crosses on its way out."""
        side = np.cross(RAY, [1.0, 0.0, 0.0])
        side /= np.linalg.norm(side)
        frame = np.stack([side, np.cross(RAY, side), RAY])  # rows: two across the ray, one along
        points = position @ frame.T
        centre, size, triangle = _pieces(self._corners, self._piece_size())
        flat = cKDTree(points[:, :2], balanced_tree=False, compact_nodes=False)
        corners = self._corners @ frame.T
        winding = np.zeros(len(position), dtype=np.int64)
        for point, face in _candidates(flat, (centre @ frame.T)[:, :2], size, triangle):
            crossing = _crossings(corners[face] - points[point][:, None, :])
            np.add.at(winding, point, crossing)
        return winding

    def _piece_size(self) -> float:
        """Size [m] below which the ray search cuts no triangle: a fortieth of the surface's extent."""
        return float(np.linalg.norm(np.ptp(self._corners.reshape(-1, 3), axis=0))) / 40.0

    def _solid_angle_winding(self, position: Float64Array) -> Float64Array:
        """Return the winding number of the surface around each point by the solid angles of its triangles."""
        winding = np.empty(len(position))
        step = max(1, BLOCK_SIZE // max(1, len(self._corners)))
        for start in range(0, len(position), step):
            relative = self._corners[None] - position[start : start + step, None, None, :]
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


def _lid_corners(surface: Surface) -> Float64Array:
    """Return triangles (L, 3, 3) that close the open rims: a fan from the middle of each rim."""
    edges = surface.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    # Corners are matched by position: a mesh of loose triangles has each corner several times.
    _, corner = np.unique(surface.vertices, axis=0, return_inverse=True)
    place = np.zeros(corner.max() + 1, dtype=np.int64)
    place[corner] = np.arange(len(corner))
    edges = corner.reshape(-1)[edges]
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


def _pieces(corners: Float64Array, size: float) -> tuple[Float64Array, Float64Array, Int64Array]:
    """Return balls that cover the triangles: centre (B, 3), radius (B,), and the triangle of each (B,).

    Long triangles are halved across their longest edge until no edge exceeds ``size``: one ball around the
    whole of a long and thin triangle would hold most of the bed.
    """
    triangle = np.arange(len(corners))
    done: list[tuple[Float64Array, Int64Array]] = []
    while len(corners):
        lengths = np.linalg.norm(corners[:, [1, 2, 0]] - corners, axis=2)
        longest = lengths.argmax(axis=1)
        split = lengths.max(axis=1) > size
        done.append((corners[~split], triangle[~split]))
        turn = (longest[split, None] + np.arange(3)) % 3
        turned = np.take_along_axis(corners[split], turn[:, :, None], axis=1)
        a, b, c = turned[:, 0], turned[:, 1], turned[:, 2]
        middle = 0.5 * (a + b)
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        triangle = np.tile(triangle[split], 2)
    pieces = np.concatenate([each[0] for each in done])
    centre = pieces.mean(axis=1)
    radius = np.linalg.norm(pieces - centre[:, None], axis=2).max(axis=1)
    return centre, radius * (1.0 + 1e-9), np.concatenate([each[1] for each in done])


def _candidates(
    tree: cKDTree, centre: Float64Array, reach: Float64Array, triangle: Int64Array
) -> Iterator[tuple[Int64Array, Int64Array]]:
    """Yield each pair (point of the tree, triangle) with the point in one of the triangle's balls once."""
    order = np.argsort(triangle, kind="stable")
    centre, reach, triangle = centre[order], reach[order], triangle[order]
    first_piece = np.flatnonzero(np.diff(triangle, prepend=-1))
    # All pieces of a triangle are in one batch, so that no pair comes twice.
    places = np.searchsorted(first_piece, np.arange(0, len(triangle), 1000))
    bounds = [*np.unique(first_piece[places[places < len(first_piece)]]), len(triangle)]
    width = int(triangle[-1]) + 1 if len(triangle) else 1
    for start, stop in pairwise(bounds):
        near = tree.query_ball_point(centre[start:stop], reach[start:stop])
        counts = np.array([len(each) for each in near])
        if counts.sum() == 0:
            continue
        points = np.concatenate([np.asarray(each, dtype=np.int64) for each in near])
        keys = np.unique(points * width + np.repeat(triangle[start:stop], counts))
        for block in range(0, len(keys), BLOCK_SIZE):
            point, face = np.divmod(keys[block : block + BLOCK_SIZE], width)
            yield point, face


def _crossings(relative: Float64Array) -> Int64Array:
    """Return +1 or -1 where the ray along the third axis from the origin leaves or enters through a triangle.

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


def _point_triangle_distance(point: Float64Array, corners: Float64Array) -> Float64Array:
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
