"""Convex polyhedra: whether a surface is one, and the planes that bound it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from packgen.arrays import Float64Array
from packgen.errors import GeometryError
from packgen.geometry import Mesh, Polyhedron, Surface
from packgen.portable import components, length, scalar_power

FLATNESS = 1.0e-6
"""Largest distance of a corner on a hull plane, as a fraction of the extent: float32 files round by 1e-7."""

PLANES_MAX = 1000
"""Most planes of a hull. A finer surface keeps its triangles: few of those are near a sphere, but many
planes."""

EXACT_MAX = 2000
"""Most points whose hull QHULL finds exactly. More are joggled by 1e-11 of their extent: the time for a flat
polygon of n corners grows with n squared."""

FLAT = 1.0e-9
"""Least volume of a hull that is not flat, as a fraction of the extent's cube: joggling alone makes 1e-11."""


def enclosed_volume(vertices: Float64Array, faces: np.ndarray) -> float:
    """Return the signed volume inside a closed surface [m3], by the divergence theorem."""
    corners = vertices[faces] - vertices.mean(axis=0)
    return float((corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])).sum() / 6.0)


@dataclass(frozen=True, eq=False, slots=True)
class Hull:
    """The convex hull of points.

    Attributes:
        points: The points [m], shape (V, 3).
        middle: The middle of their bounding box [m], shape (3,).
        found: QHULL's result for the points relative to their middle.
    """

    points: Float64Array
    middle: Float64Array
    found: ConvexHull

    @property
    def volume(self) -> float:
        """Its volume [m3]."""
        return float(self.found.volume)

    def shape(self) -> Polyhedron | Mesh:
        """Return its planes and triangles, or only the triangles where it is too finely curved."""
        used, faces = np.unique(self.found.simplices, return_inverse=True)
        surface = _outward(Surface(self.points[used], faces.reshape(-1, 3)))
        planes = _main_planes(self.found, self.points - self.middle)
        if planes is None:
            return Mesh(surface)
        normal, offset = planes
        return Polyhedron(normal, offset + components(normal, self.middle), surface)


def convex_hull(vertices: Float64Array, place: str) -> Hull:
    """Return the convex hull of points (the paper's container, section III-B).

    Args:
        vertices: Points [m], shape (V, 3).
        place: Where the scene names them, for messages.

    Raises:
        GeometryError: The points lie in a plane.
    """
    # About their middle: QHULL's tolerances go with the largest coordinate.
    middle = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0))
    centred = vertices - middle
    try:
        hull = ConvexHull(centred, qhull_options="Qt" if len(vertices) <= EXACT_MAX else "QJ")
        flat = hull.volume < FLAT * scalar_power(float(np.ptp(centred, axis=0).max()), 3)
    except QhullError:
        flat = True
    if flat:
        raise GeometryError(f"{place}: the mesh is flat: its corners span no volume")
    return Hull(vertices, middle, hull)


def _main_planes(hull: ConvexHull, vertices: Float64Array) -> tuple[Float64Array, Float64Array] | None:
    """Return the planes that bound a hull, large facets' first; None: they are too many.

    A facet whose corners all lie on the plane of a larger one needs no plane of its own. Each plane is moved
    in to the innermost of the points that lie on it: a sphere inside it cannot cut a triangle between them.

    Returns:
        (outward unit normals, shape (P, 3); offsets [m], shape (P,)).
    """
    slack = FLATNESS * float(np.ptp(vertices, axis=0).max())
    corners = vertices[hull.simplices]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    covered = np.zeros(len(area), bool)
    normals: list[Float64Array] = []
    offsets: list[float] = []
    for facet in np.argsort(-area, kind="stable"):
        if covered[facet]:
            continue
        if len(offsets) == PLANES_MAX:
            return None
        normal = hull.equations[facet, :3] / length(hull.equations[facet, :3])
        height = components(vertices, normal)
        top = float(height[hull.simplices[facet]].min())
        covered |= (height > top - 0.5 * slack)[hull.simplices].all(axis=1)
        covered[facet] = True
        normals.append(normal)
        offsets.append(float(height[height > top - slack].min()))
    return np.array(normals), np.array(offsets)


def _outward(surface: Surface) -> Surface:
    """Return the triangles of a convex surface with their corners counter-clockwise from outside."""
    corners = surface.vertices[surface.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    away = corners.mean(axis=1) - surface.vertices.mean(axis=0)
    flip = (normal * away).sum(axis=1) < 0.0
    faces = np.where(flip[:, None], surface.faces[:, ::-1], surface.faces)
    return Surface(surface.vertices, faces)


def is_convex(surface: Surface, hull_volume: float, volume: float) -> bool:
    """Tell whether a closed surface of this volume is the boundary of its own convex hull."""
    return abs(hull_volume - volume) <= 1.0e-5 * hull_volume and len(surface.faces) > 3
