"""Where spheres touch walls, and in which direction: a sphere in a corner touches several."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array, Int64Array
from packgen.check.mesh import lid_corners
from packgen.check.pieces import candidates, pieces
from packgen.geometry import Ball, Box, Cone, Container, Mesh, Polyhedron, Surface

SAME_WALL = (
    0.985  # cosine (10 degrees): a contact of a mesh this near to the direction of a nearer one is that one
)


def wall_contacts(
    container: Container, position: Float64Array, radius: Float64Array, gap_fraction: float
) -> tuple[Int64Array, Float64Array, Float64Array]:
    """Return all contacts of spheres with walls.

    Args:
        container: The vessel.
        position: Sphere centres [m], shape (N, 3), float64.
        radius: Sphere radii [m], shape (N,), float64.
        gap_fraction: Largest gap of a contact, as a fraction of the sphere's radius.

    Returns:
        The sphere of each contact, shape (W,); unit vectors from its centre to the wall, shape (W, 3); its
        centre's distance from the wall [m], shape (W,).
    """
    reach = radius * (1.0 + gap_fraction)
    shape = container.shape
    if isinstance(shape, Mesh):
        return _mesh_contacts(shape.surface, position, reach)
    found = []
    if isinstance(shape, Box):
        for axis in np.flatnonzero(~np.array(container.periodic)):
            normal = np.broadcast_to(np.eye(3)[axis], position.shape)
            found.append((position[:, axis] - shape.min[axis], -normal))
            found.append((shape.max[axis] - position[:, axis], normal))
    elif isinstance(shape, Polyhedron):
        corner = shape.surface.vertices[0]
        for normal, offset in zip(shape.normal, shape.offset, strict=True):
            away = offset - normal @ corner - (position - corner) @ normal
            found.append((away, np.broadcast_to(normal, position.shape)))
    elif isinstance(shape, Ball):
        outward, distance = _directions(position - shape.center)
        found.append((shape.radius - distance, outward))
    elif isinstance(shape, Cone):
        found = _cone_walls(shape, position)
    parts = []
    for away, normal in found:
        near = np.flatnonzero(away <= reach)
        parts.append((near, normal[near], away[near]))
    if not parts:
        return np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0)
    sphere, normal, away = (np.concatenate(each) for each in zip(*parts, strict=True))
    return sphere, normal, away


def _directions(vectors: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return unit vectors (N, 3), zero where there is none, and lengths (N,)."""
    length = np.linalg.norm(vectors, axis=1)
    return vectors / np.where(length > 0.0, length, 1.0)[:, None], length


def _cone_walls(cone: Cone, position: Float64Array) -> list[tuple[Float64Array, Float64Array]]:
    """Return distances (N,) to both ends and to the slant side, each with its outward normals (N, 3)."""
    relative = position - cone.base
    along = relative @ cone.axis
    outward, across = _directions(relative - along[:, None] * cone.axis)
    slope = (cone.radius_top - cone.radius_bottom) / cone.height
    slant = np.hypot(1.0, slope)
    axis = np.broadcast_to(cone.axis, position.shape)
    return [
        (along, -axis),
        (cone.height - along, axis),
        ((cone.radius_bottom + slope * along - across) / slant, (outward - slope * axis) / slant),
    ]


def _mesh_contacts(
    surface: Surface, position: Float64Array, reach: Float64Array
) -> tuple[Int64Array, Float64Array, Float64Array]:
    """Return the contacts with triangles; of triangles in about the same direction the nearest counts."""
    corners = np.concatenate([surface.vertices[surface.faces], lid_corners(surface)])
    limit = float(reach.max(initial=0.0))
    points, away, normals = [], [], []
    if len(position):
        centre, size, triangle = pieces(corners, 2.0 * limit)
        tree = cKDTree(position, balanced_tree=False, compact_nodes=False)
        for point, face in candidates(tree, centre, size + limit * (1.0 + 1e-9), triangle):
            normal, distance = _directions(_closest(position[point], corners[face]) - position[point])
            near = distance <= reach[point]
            points.append(point[near])
            away.append(distance[near])
            normals.append(normal[near])
    if not points:
        return np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0)
    point, distance, normal = np.concatenate(points), np.concatenate(away), np.concatenate(normals)
    order = np.lexsort((distance, point))
    point, normal, distance = point[order], normal[order], distance[order]
    start = np.searchsorted(point, point)  # each sphere's nearest contact
    kept = np.zeros(len(point), dtype=bool)
    for place in range(len(point)):
        nearer = slice(start[place], place)
        kept[place] = not (kept[nearer] & (normal[nearer] @ normal[place] > SAME_WALL)).any()
    return point[kept], normal[kept], distance[kept]


def _closest(point: Float64Array, corners: Float64Array) -> Float64Array:
    """Return the point of each triangle (K, 3, 3) that is nearest to a point (K, 3), shape (K, 3)."""
    normal, area = _directions(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    height = np.einsum("ij,ij->i", point - corners[:, 0], normal)
    best = point - height[:, None] * normal
    inside = area > 0.0
    nearest = np.full(len(point), np.inf)
    on_edge = np.empty_like(point)
    for corner in range(3):
        start, edge = corners[:, corner], corners[:, (corner + 1) % 3] - corners[:, corner]
        relative = point - start
        squared = np.einsum("ij,ij->i", edge, edge)
        share = np.einsum("ij,ij->i", relative, edge) / np.where(squared > 0.0, squared, 1.0)
        foot = start + np.clip(share, 0.0, 1.0)[:, None] * edge
        distance = np.linalg.norm(point - foot, axis=1)
        nearer = distance < nearest
        nearest[nearer], on_edge[nearer] = distance[nearer], foot[nearer]
        inside &= np.einsum("ij,ij->i", np.cross(edge, relative), normal) >= 0.0
    return np.where(inside[:, None], best, on_edge)
