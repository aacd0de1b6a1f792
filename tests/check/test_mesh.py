from __future__ import annotations

import numpy as np
import pytest
import trimesh

from packgen.check.inside import ray_winding, solid_angle_winding
from packgen.check.mesh import MeshWalls
from packgen.geometry import Surface
from tests.beds import box_surface, revolved_surface

HOURGLASS = [(0.0, 1.0), (1.0, 0.4), (2.0, 1.0)]


def hourglass_radius(height):
    return np.interp(height, [z for z, _ in HOURGLASS], [r for _, r in HOURGLASS])


def points_in(low, high, count=3000, seed=5):
    return np.random.default_rng(seed).uniform(low, high, (count, 3))


def test_distance_to_a_mesh_equals_that_of_trimesh():
    surface = revolved_surface(HOURGLASS, 24)
    points = points_in([-1.1, -1.1, -0.1], [1.1, 1.1, 2.1], count=300)
    _, expected, _ = trimesh.proximity.closest_point_naive(
        trimesh.Trimesh(surface.vertices, surface.faces, process=False), points
    )
    distance = MeshWalls(surface).distance(points, np.full(len(points), 0.3))
    np.testing.assert_allclose(distance, np.minimum(expected, 0.3), rtol=0, atol=1e-12)


def test_points_of_an_hourglass_are_told_inside_from_outside():
    facets = 24
    points = points_in([-1.1, -1.1, -0.1], [1.1, 1.1, 2.1])
    across = np.hypot(points[:, 0], points[:, 1])
    # Between the inscribed and the circumscribed circle only the facets know.
    surely_in = across < hourglass_radius(points[:, 2]) * np.cos(np.pi / facets)
    surely_out = across > hourglass_radius(points[:, 2])
    between = (points[:, 2] > 0.0) & (points[:, 2] < 2.0)
    inside = MeshWalls(revolved_surface(HOURGLASS, facets)).contains(points)
    assert inside[surely_in & between].all()
    assert not inside[surely_out | ~between].any()


@pytest.mark.parametrize("kept", [slice(0, 10), slice(2, 12)])
def test_an_open_side_is_closed_by_a_lid(kept):
    whole = box_surface([0, 0, 0], [1, 2, 3])
    # Loose triangles, as an STL file gives them, without two sides of the box or one.
    faces = whole.faces[[0, 1, 4, 5, 6, 7, 8, 9, 10, 11]] if kept.start == 0 else whole.faces[kept]
    loose = Surface(whole.vertices[faces].reshape(-1, 3), np.arange(3 * len(faces)).reshape(-1, 3))
    points = points_in([-0.5, -0.5, -0.5], [1.5, 2.5, 3.5])
    expected = ((points > 0.0) & (points < [1, 2, 3])).all(axis=1)
    walls = MeshWalls(loose)
    np.testing.assert_array_equal(walls.contains(points), expected)
    centre = np.array([[0.5, 1.0, 2.9], [0.5, 1.0, 0.2]])
    np.testing.assert_allclose(walls.distance(centre, np.full(2, 0.4)), [0.1, 0.2], atol=1e-12)


def test_ray_and_solid_angles_agree():
    surface = revolved_surface(HOURGLASS, 7)
    corners = surface.vertices[surface.faces]
    points = points_in([-1.1, -1.1, -0.1], [1.1, 1.1, 2.1], count=500)
    np.testing.assert_allclose(ray_winding(corners, points), solid_angle_winding(corners, points), atol=1e-9)
