"""Tessellations of primitives for decks and pictures: facets on or just outside the true wall."""

from __future__ import annotations

import math

import numpy as np

from packgen.arrays import Float64Array
from packgen.geometry import Ball, Box, Cone, Shape, Surface

SEGMENTS = 96
"""Facets round a tessellated primitive: its corners lie 0.05 % of the radius outside the true wall."""


def perpendicular(axis: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return two unit vectors, each (3,), that make a right-handed system with ``axis`` as the third."""
    helper = np.eye(3)[int(np.argmin(np.abs(axis)))]
    first = np.cross(helper, axis)
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first)


def surface_of(shape: Shape) -> Surface:
    """Return a shape as triangles."""
    if isinstance(shape, Box):
        return box_surface(shape)
    if isinstance(shape, Cone):
        return cone_surface(shape)
    return ball_surface(shape) if isinstance(shape, Ball) else shape.surface


def box_surface(box: Box) -> Surface:
    """Return a box as twelve triangles."""
    corner = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)], float)
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    faces = [triangle for a, b, c, d in quads for triangle in ((a, b, c), (a, c, d))]
    return Surface(box.min + corner * (box.max - box.min), np.array(faces))


def cone_surface(cone: Cone, segments: int = SEGMENTS) -> Surface:
    """Return a (truncated) cone or cylinder whose facets touch the true wall from outside."""
    first, second = perpendicular(cone.axis)
    angle = np.arange(segments) * (2.0 * math.pi / segments)
    ring = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
    outside = 1.0 / math.cos(math.pi / segments)
    top_center = cone.base + cone.height * cone.axis
    vertices = np.vstack(
        [
            cone.base + cone.radius_bottom * outside * ring,
            top_center + cone.radius_top * outside * ring,
            cone.base[None],
            top_center[None],
        ]
    )
    faces = []
    for here in range(segments):
        there = (here + 1) % segments
        if cone.radius_bottom > 0.0:
            faces.append((here, there, segments + there))
            faces.append((2 * segments, there, here))
        if cone.radius_top > 0.0:
            faces.append((here, segments + there, segments + here))
            faces.append((2 * segments + 1, segments + here, segments + there))
    return _compact(vertices, np.array(faces))


def ball_surface(ball: Ball) -> Surface:
    """Return an icosphere whose facets touch the true wall from outside."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=4, radius=1.0)
    directions = np.asarray(mesh.vertices)
    corners = directions[np.asarray(mesh.faces)]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    inner = float(np.einsum("ij,ij->i", normal, corners[:, 0]).min())
    return Surface(ball.center + directions * (ball.radius / inner), np.asarray(mesh.faces, np.int64))


def _compact(vertices: Float64Array, faces: np.ndarray) -> Surface:
    if np.ptp(vertices[: len(vertices) // 2], axis=0).max() == 0.0 or len(faces) < 1:
        raise ValueError("a cone needs a radius")
    from packgen.container.meshfile import clean_surface

    return clean_surface(vertices, faces)[0]
