from __future__ import annotations

import numpy as np
import trimesh

from exporters.resolved.triangles import distance_to_triangles, nearest_on_triangle, triangles_within


def soup(count=40):
    rng = np.random.default_rng(5)
    return rng.uniform(0, 1, (count, 3, 3)), rng.uniform(-0.3, 1.3, (count, 3))


def test_nearest_points_are_those_of_trimesh():
    corners, point = soup()
    assert np.allclose(nearest_on_triangle(point, corners), trimesh.triangles.closest_point(corners, point))


def test_the_nearest_of_many_triangles_decides():
    corners, point = soup()
    expected = [
        np.linalg.norm(trimesh.triangles.closest_point(corners, np.tile(each, (40, 1))) - each, axis=1)
        for each in point
    ]
    assert np.allclose(distance_to_triangles(point, corners), np.min(expected, axis=1))
    owner, place = triangles_within(point, np.full(40, 0.2), corners)
    assert [(owner == index).sum() for index in range(40)] == [(each <= 0.2).sum() for each in expected]
    assert (np.linalg.norm(place - point[owner], axis=1) <= 0.2).all()


def test_a_triangle_without_area_is_a_line():
    corners = np.array([[[0.0, 0, 0], [1, 0, 0], [2, 0, 0]]])
    assert np.allclose(nearest_on_triangle(np.array([[1.5, 1, 0]]), corners), [[1.5, 0, 0]])
