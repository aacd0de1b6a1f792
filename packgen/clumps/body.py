"""The body that spheres are to fill: a closed mesh in a frame of its own, with all that is asked of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array, read_only
from packgen.bodies import MassProperties
from packgen.clumps.points import VolumePoints, corner_points, inward, surface_points, volume_points
from packgen.clumps.properties import mesh_properties
from packgen.clumps.tree import TriangleTree, triangle_tree
from packgen.errors import GeometryError
from packgen.geometry import Surface

SIDES_MAX = 0.1  # of the volume: how far the points inside may disagree with the tetrahedra
SIDES_POINTS = 20_000


@dataclass(frozen=True, eq=False, slots=True)
class Body:
    """A closed mesh, moved so that its centre of mass is the origin.

    Attributes:
        surface: The mesh as given [m].
        properties: Volume, centre and inertia of the mesh as given.
        axes: Principal axes as columns, shape (3, 3), float64.
        corners: Triangles in the frame of the principal axes, in equivalent diameters, shape (F, 3, 3),
            float64.
        tree: The same, for distances.
    """

    surface: Surface
    properties: MassProperties
    axes: Float64Array
    corners: Float64Array
    tree: TriangleTree

    def __post_init__(self) -> None:
        object.__setattr__(self, "axes", read_only(self.axes, np.float64, (3, 3), "axes"))
        object.__setattr__(self, "corners", read_only(self.corners, np.float64, (None, 3, 3), "corners"))

    @property
    def unit(self) -> float:
        """Equivalent diameter [m], the unit of length of `corners`."""
        return self.properties.equivalent_diameter

    @property
    def volume(self) -> float:
        """Volume in cubed equivalent diameters."""
        return np.pi / 6.0

    def points(self, count: int, margin: float = 0.0, shift: float = 0.0) -> VolumePoints:
        """Return points in the body and round it, as `volume_points` does, in equivalent diameters."""
        return volume_points(self.corners, self.volume, count, margin, shift)

    def touching_balls(self, count: int) -> Float64Array:
        """Return inscribed balls that touch the surface, spread evenly over it and near its corners.

        Args:
            count: About how many.

        Returns:
            Centres and radii, in equivalent diameters, shape (K, 4), float64.
        """
        point, into = self.feet(count)
        ball = self.tree.touching_balls(point, into)
        return ball[ball[:, 3] > 0.0]

    def feet(self, count: int) -> tuple[Float64Array, Float64Array]:
        """Return points of the surface and unit vectors into the body, both of shape (N, 3), float64."""
        spread, near = surface_points(self.corners, count), corner_points(self.corners)
        triangle: Int64Array = np.concatenate([spread[1], near[1]])
        return np.concatenate([spread[0], near[0]]), inward(self.corners)[triangle]

    def to_mesh_axes(self, spheres: Float64Array) -> Float64Array:
        """Return spheres (N, 4) of this frame along the mesh's axes [m], the centre of mass at the origin."""
        return self.unit * np.column_stack([spheres[:, :3] @ self.axes.T, spheres[:, 3]])

    def from_mesh_axes(self, spheres: Float64Array) -> Float64Array:
        """Return the spheres of this frame; the inverse of `to_mesh_axes`."""
        return np.column_stack([spheres[:, :3] @ self.axes, spheres[:, 3]]) / self.unit


def body_of(surface: Surface, place: str = "mesh") -> Body:
    """Return a closed surface as a body.

    Args:
        surface: Closed; seen from outside its facets are counter-clockwise [m].
        place: What messages call it.

    Raises:
        GeometryError: It bounds no volume, or its parts disagree about which side is inside.
    """
    corners = surface.vertices[surface.faces]
    extent = float(np.ptp(surface.vertices, axis=0).max())
    properties = mesh_properties(corners)
    if properties.volume < 0.0:
        corners, surface = corners[:, ::-1], Surface(surface.vertices, surface.faces[:, ::-1])
        properties = mesh_properties(corners)
    if not properties.volume > 1e-12 * extent**3:
        raise GeometryError(
            f"{place}: found a mesh that bounds no volume, expected the closed surface of a body; is it flat?"
        )
    axes = properties.principal()[1]
    unit = properties.equivalent_diameter
    near = np.ascontiguousarray((corners - properties.centre) @ axes / unit)
    body = Body(surface, properties, axes, near, triangle_tree(near))
    within = body.points(SIDES_POINTS)
    share = len(within.inside) * within.cell / body.volume
    if abs(share - 1.0) > SIDES_MAX:
        raise GeometryError(
            f"{place}: found parts that cut each other or face different ways (its facets sum up to "
            f"{properties.volume:.4g} m3, points inside to {share * properties.volume:.4g} m3), expected one "
            "closed surface; unite them in a mesh editor"
        )
    return body
