"""Which named part of the walls is nearest to a point."""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.check.mesh import point_triangle_distance
from packgen.check.pieces import candidates, pieces
from packgen.geometry import Container

NO_PART = -1
"""The index of walls without a name."""

PART_REACH = 2.0  # radii: how far from a sphere in a wall its part is looked for


def nearest_part(container: Container, position: Float64Array, reach: Float64Array) -> Int64Array:
    """Return the part of the walls that has the triangle nearest to each point.

    Args:
        container: The vessel.
        position: Points [m], shape (N, 3), float64.
        reach: How far to look from each point [m], shape (N,), float64.

    Returns:
        Index into the container's parts, `NO_PART` where the nearest triangle belongs to none, or none is as
        near, shape (N,), int64. Of triangles at one distance the first counts.
    """
    nearest = np.full(len(position), NO_PART, np.int64)
    if not container.parts or len(position) == 0:
        return nearest
    corners = container.surface.vertices[container.surface.faces]
    limit = float(reach.max())
    centre, size, triangle = pieces(corners, 2.0 * limit)
    tree = cKDTree(position, balanced_tree=False, compact_nodes=False)
    points, faces, away = [], [], []
    for point, face in candidates(tree, centre, size + limit * (1.0 + 1e-9), triangle):
        distance = point_triangle_distance(position[point], corners[face])
        near = distance <= reach[point]
        points.append(point[near])
        faces.append(face[near])
        away.append(distance[near])
    if not points:
        return nearest
    point, face, distance = np.concatenate(points), np.concatenate(faces), np.concatenate(away)
    order = np.lexsort((face, distance, point))
    point, face = point[order], face[order]
    first = np.ones(len(point), bool)
    first[1:] = point[1:] != point[:-1]
    nearest[point[first]] = container.part_index[face[first]]
    return nearest


def nearest_part_name(container: Container, position: Float64Array, reach: float) -> str | None:
    """Return the name of the part nearest to a point [m], shape (3,); None where that has no name."""
    index = int(nearest_part(container, position[None], np.array([reach]))[0])
    return None if index == NO_PART else container.parts[index].name


def part_name_beside(bed: Bed, place: int) -> str | None:
    """Return the name of the part nearest to the sphere of a bed at a place; None where that has no name."""
    return nearest_part_name(bed.container, bed.position[place], PART_REACH * float(bed.radius[place]))
