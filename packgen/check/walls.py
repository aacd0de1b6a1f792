"""How far each sphere's centre is inside the walls, by closed forms of numpy: no code of the core's."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array
from packgen.check.mesh import MeshWalls
from packgen.geometry import Ball, Box, Cone, Container, Mesh, Polyhedron, Shape, Slice

BLOCK_SIZE = 50_000  # sphere-plane distances held at a time: they stay in the cache


def wall_clearance(container: Container, position: Float64Array, radius: Float64Array) -> Float64Array:
    """Return the distance from each centre to the nearest wall.

    Args:
        container: The vessel.
        position: Sphere centres [m], shape (N, 3), float64.
        radius: Sphere radii [m], shape (N,), float64; a mesh is searched no further around each centre.

    Returns:
        Signed distance [m], positive inside, shape (N,), float64; infinite where no wall bounds the bed. Of a
        mesh: exact within a radius of the wall and at least the radius beyond. Outside, near an edge of the
        walls, it is the distance to the farthest plane passed.
    """
    if container.cell is not None:
        return np.full(len(position), np.inf)
    if isinstance(container.shape, Box):
        return _box_clearance(container.shape, container.periodic, position)
    return shape_clearance(container.shape, position, radius)


def shape_clearance(shape: Shape | Slice, position: Float64Array, radius: Float64Array) -> Float64Array:
    """Return the distance from each centre to the nearest border of a shape, as ``wall_clearance`` does."""
    if isinstance(shape, Box):
        return _box_clearance(shape, (False, False, False), position)
    if isinstance(shape, Slice):
        along = position @ shape.axis
        return np.asarray(np.minimum(along - shape.low, shape.high - along))
    if isinstance(shape, Cone):
        return _cone_clearance(shape, position)
    if isinstance(shape, Ball):
        clearance: Float64Array = shape.radius - np.linalg.norm(position - shape.center, axis=1)
        return clearance
    if isinstance(shape, Polyhedron):
        return _polyhedron_clearance(shape, position)
    return _mesh_clearance(shape, position, radius)


def _box_clearance(box: Box, periodic: tuple[bool, bool, bool], position: Float64Array) -> Float64Array:
    clearance = np.full(len(position), np.inf)
    for axis in range(3):
        if not periodic[axis]:
            np.minimum(clearance, position[:, axis] - box.min[axis], out=clearance)
            np.minimum(clearance, box.max[axis] - position[:, axis], out=clearance)
    return clearance


def _cone_clearance(cone: Cone, position: Float64Array) -> Float64Array:
    """Distance to ends and slant side; inside, the foot of the perpendicular lies on a generator."""
    relative = position - cone.base
    along = relative @ cone.axis
    across = np.linalg.norm(relative - along[:, None] * cone.axis, axis=1)
    slope = (cone.radius_top - cone.radius_bottom) / cone.height
    side = (cone.radius_bottom + slope * along - across) / np.hypot(1.0, slope)
    clearance: Float64Array = np.minimum(side, np.minimum(along, cone.height - along))
    return clearance


def _polyhedron_clearance(polyhedron: Polyhedron, position: Float64Array) -> Float64Array:
    clearance = np.empty(len(position))
    step = max(1, BLOCK_SIZE // max(1, len(polyhedron.offset)))
    # Offsets from a corner, not from the origin: a container 1e6 m away keeps its digits.
    corner = polyhedron.surface.vertices[0]
    offset = polyhedron.offset - np.einsum("ij,j->i", polyhedron.normal, corner)
    for start in range(0, len(position), step):
        depth = offset - (position[start : start + step] - corner) @ polyhedron.normal.T
        clearance[start : start + step] = depth.min(axis=1)
    return clearance


def _mesh_clearance(mesh: Mesh, position: Float64Array, radius: Float64Array) -> Float64Array:
    walls = MeshWalls(mesh.surface)
    clearance = np.full(len(position), np.nan)
    sound = np.isfinite(position).all(axis=1)
    position, radius = position[sound], radius[sound]
    distance = walls.distance(position, radius)
    clearance[sound] = np.where(walls.contains(position, distance), distance, -distance)
    return clearance
