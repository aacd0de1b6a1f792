from __future__ import annotations

import numpy as np
import pytest
import trimesh

from packgen.check import inside
from packgen.check.inside import RAYS, ray_winding, solid_angle_winding
from packgen.check.mesh import MeshWalls
from packgen.check.pieces import piece_count, pieces
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
    walls = MeshWalls(revolved_surface(HOURGLASS, facets))
    inside = walls.contains(points)
    assert inside[surely_in & between].all()
    assert not inside[surely_out | ~between].any()
    np.testing.assert_array_equal(walls.contains(points, walls.distance(points, np.full(3000, 0.2))), inside)


def test_a_point_in_a_walls_cell_is_on_the_side_of_the_region_it_sees(monkeypatch):
    left = []
    monkeypatch.setattr(inside, "_by_rays", lambda _, points: left.append(len(points)) or points[:, 0] > 9.0)
    walls = MeshWalls(revolved_surface(HOURGLASS, 24))
    points = points_in([-0.9, -0.9, 0.05], [0.9, 0.9, 1.95], count=20_000)
    distance = walls.distance(points, np.full(len(points), 0.2))
    far = distance > 0.1
    across = np.hypot(points[:, 0], points[:, 1])
    found = walls.contains(points[far], distance[far])
    np.testing.assert_array_equal(found, (across < hourglass_radius(points[:, 2]))[far])
    assert left == [0]


def test_the_least_distance_to_a_mesh_falls_short_by_no_more_than_allowed():
    walls = MeshWalls(revolved_surface(HOURGLASS, 24))
    points = points_in([-2, -2, -1], [2, 2, 3], count=500)
    exact = walls.distance(points, np.full(len(points), 9.0))
    short = exact - walls.distance_least(points, 0.1)
    assert (short >= 0.0).all()
    assert (short <= 0.1 + 1e-9).all()


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


@pytest.mark.parametrize("ray", RAYS)
def test_rays_and_solid_angles_agree(ray):
    surface = revolved_surface(HOURGLASS, 7)
    corners = surface.vertices[surface.faces]
    points = points_in([-1.1, -1.1, -0.1], [1.1, 1.1, 2.1], count=500)
    winding = ray_winding(corners, points, ray)
    np.testing.assert_allclose(winding, solid_angle_winding(corners, points), atol=1e-9)


def test_a_ray_through_an_edge_is_caught_by_the_other(monkeypatch):
    surface = box_surface([-1, -1, -1], [1, 1, 1])
    corners = surface.vertices[surface.faces]
    upward = np.array([0.0, 0.0, 1.0])
    points = np.linspace([-1.4, -1.4, 0.9], [1.4, 1.4, 0.9], 30)  # below the diagonal of a side
    expected = (np.abs(points) < 1.0).all(axis=1)
    assert (ray_winding(corners, points, upward) != expected).any()
    monkeypatch.setattr(inside, "RAYS", np.stack([upward, RAYS[1]]))
    monkeypatch.setattr(inside, "_regions", lambda _corners, points, *_: np.zeros(len(points), int))
    np.testing.assert_array_equal(MeshWalls(surface).contains(points), expected)


def needles(count=200):
    """A tube of 0.2 by 1 whose sides and ends are triangles a hundred times as long as wide."""
    return revolved_surface([(0.0, 0.2), (1.0, 0.2)], count)


@pytest.mark.parametrize("size", [0.03, 0.4, 5.0])
def test_balls_cover_their_triangles_and_nothing_far(size):
    surface = needles(40)
    flat = np.array([[[0, 0, 0], [1, 0, 0], [0.3, 0, 0]]])
    corners = np.concatenate([surface.vertices[surface.faces], flat])
    centre, radius, triangle = pieces(corners, size)
    assert (np.diff(triangle) >= 0).all()
    assert radius.max() <= 0.71 * size
    assert len(triangle) <= piece_count(corners, size)
    rng = np.random.default_rng(1)
    for index in range(0, len(corners), 7):
        share = rng.dirichlet([0.5] * 3, 200)
        points = np.concatenate([share @ corners[index], corners[index]])
        mine = triangle == index
        off = np.linalg.norm(points[:, None] - centre[mine], axis=2) - radius[mine]
        assert off.min(axis=1).max() <= 1e-12


def test_a_mesh_of_needles_is_as_any_other():
    surface = needles()
    points = points_in([-0.25, -0.25, -0.1], [0.25, 0.25, 1.1], count=2000)
    walls = MeshWalls(surface)
    across = np.hypot(points[:, 0], points[:, 1])
    clear = np.abs(across - 0.2) > 1e-3
    expected = (across < 0.2) & (points[:, 2] > 0.0) & (points[:, 2] < 1.0)
    np.testing.assert_array_equal(walls.contains(points)[clear], expected[clear])
    inside = expected & clear
    depth = np.minimum(0.2 - across, np.minimum(points[:, 2], 1.0 - points[:, 2]))[inside]
    distance = walls.distance(points[inside], np.full(inside.sum(), 0.05))
    np.testing.assert_allclose(distance, np.minimum(depth, 0.05), rtol=0, atol=2e-4)
