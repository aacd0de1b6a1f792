"""Convex polyhedra: whether a surface is one, and the planes that bound it."""

from __future__ import annotations

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from packgen.arrays import Float64Array
from packgen.errors import GeometryError
from packgen.geometry import Polyhedron, Surface

FLATNESS = 1.0e-6
"""Corners this close to a hull plane (as a fraction of the extent) lie on it: float32 files round by 1e-7."""


def enclosed_volume(vertices: Float64Array, faces: np.ndarray) -> float:
    """Return the signed volume inside a closed surface [m3], by the divergence theorem."""
    corners = vertices[faces] - vertices.mean(axis=0)
    return float(np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0)


def convex_hull(vertices: Float64Array, place: str) -> tuple[Polyhedron, float]:
    """Return the convex hull of points (the paper's container, section III-B) and its volume [m3].

    Args:
        vertices: Points [m], shape (V, 3).
        place: Where the scene names them, for messages.

    Returns:
        (the hull with outward planes and its own triangles, volume).

    Raises:
        GeometryError: The points lie in a plane.
    """
    try:
        hull = ConvexHull(vertices)
    except QhullError as error:
        raise GeometryError(f"{place}: the mesh is flat: its corners span no volume") from error
    equations = np.unique(np.round(hull.equations, 13), axis=0)
    normal = equations[:, :3] / np.linalg.norm(equations[:, :3], axis=1, keepdims=True)
    offset = _tightened(normal, -equations[:, 3], vertices)
    used, faces = np.unique(hull.simplices, return_inverse=True)
    surface = _outward(Surface(vertices[used], faces.reshape(-1, 3)))
    return Polyhedron(normal, offset, surface), float(hull.volume)


def _tightened(normal: Float64Array, offset: Float64Array, vertices: Float64Array) -> Float64Array:
    """Return offsets moved in to the innermost corner of each facet.

    A sphere inside such a plane cannot cut the facet's triangles: their corners lie on the plane or beyond.
    """
    slack = FLATNESS * float(np.ptp(vertices, axis=0).max())
    tight = offset.copy()
    for index in range(len(offset)):
        height = vertices @ normal[index]
        tight[index] = height[height > offset[index] - slack].min()
    return tight


def _outward(surface: Surface) -> Surface:
    """Return the triangles of a convex surface with their corners counter-clockwise from outside."""
    corners = surface.vertices[surface.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    away = corners.mean(axis=1) - surface.vertices.mean(axis=0)
    flip = np.einsum("ij,ij->i", normal, away) < 0
    faces = np.where(flip[:, None], surface.faces[:, ::-1], surface.faces)
    return Surface(surface.vertices, faces)


def is_convex(surface: Surface, hull_volume: float, volume: float) -> bool:
    """Tell whether a closed surface of this volume is the boundary of its own convex hull."""
    return abs(hull_volume - volume) <= 1.0e-5 * hull_volume and len(surface.faces) > 3
