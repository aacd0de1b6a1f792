"""Which side of a mesh a point is on: grid, winding number and sight against rays and formulas."""

import numpy as np
import pytest

from packgen.arrange.space.feature_kernels import closest_on_triangle
from packgen.arrange.space.map_kernels import Grid, map_triangles
from packgen.arrange.space.side_kernels import crosses
from packgen.arrange.space.sides import InsideMap
from packgen.arrange.space.walls import wall_table
from packgen.check.mesh import MeshWalls
from packgen.container.shells import sorted_vessel
from packgen.geometry import Mesh, Surface
from packgen.geometry.winding import winding_numbers
from tests import container_meshes as meshes

UP = np.array([0.0, 0.0, 1.0])


def closed_surface(mesh):
    vessel = sorted_vessel(Surface(mesh.vertices, mesh.faces), UP)
    assert vessel is not None
    return vessel.closed


def inside_of(surface, points, radius):
    bounds = np.stack([surface.vertices.min(axis=0), surface.vertices.max(axis=0)])
    walls = wall_table([Mesh(surface)], bounds, radius)
    return InsideMap.over([surface], bounds, radius).inside(points, walls)


def random_points(surface, count, seed=0):
    low, high = surface.vertices.min(axis=0), surface.vertices.max(axis=0)
    return np.random.default_rng(seed).uniform(low - 0.1, high + 0.1, (count, 3))


@pytest.mark.parametrize("radius", [0.05, 0.2])
@pytest.mark.parametrize(
    "mesh",
    [
        meshes.torus(),
        meshes.u_bend(open_top=True),
        meshes.hopper(open_top=False),
        meshes.l_box(open_top=True),
    ],
    ids=["torus", "u_bend", "hopper", "l_box"],
)
def test_points_are_on_the_side_that_rays_say(mesh, radius):
    surface = closed_surface(mesh)
    points = random_points(surface, 3000)
    walls = MeshWalls(surface)
    expected = walls.contains(points)
    found = inside_of(surface, points, radius)
    assert not (found & ~expected).any()
    # a point that hugs a wall may go unseen, but no centre of a sphere does
    away = walls.distance(points, np.full(len(points), radius)) >= 0.5 * radius
    np.testing.assert_array_equal(found[away], expected[away])
    assert found.sum() > 100


def test_both_sides_of_a_sheet_are_inside():
    surface = closed_surface(meshes.tank(open_top=True, baffles=1))
    points = np.array([[0.9, 0.05, 1.0], [0.9, -0.05, 1.0], [0.9, 0.005, 1.0], [1.1, 0.05, 1.0]])
    assert inside_of(surface, points, 0.05).tolist() == [True, True, True, False]


def test_the_inside_of_a_body_in_a_vessel_is_outside():
    surface = closed_surface(meshes.hopper(open_top=True))
    points = np.array([[0.0, 0.0, 1.3], [0.0, 0.0, 0.5], [0.5, 0.0, 1.3], [0.0, 0.0, 2.0], [0.9, 0.0, 0.2]])
    assert inside_of(surface, points, 0.05).tolist() == [False, True, True, True, False]


def test_winding_numbers_of_a_tetrahedron_are_whole():
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    triangles = corners[[[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]].reshape(-1, 9)
    points = np.array([[0.2, 0.2, 0.2], [0.5, 0.5, 0.5], [-0.1, 0.2, 0.2]])
    np.testing.assert_allclose(winding_numbers(triangles, points), [1.0, 0.0, 0.0], atol=1e-12)


def test_segments_cross_a_triangle_where_the_plane_formula_says():
    rng = np.random.default_rng(3)
    for _ in range(500):
        a, b, c, p, q = rng.normal(size=(5, 3))
        # p + t (q - p) = a + u (b - a) + v (c - a)
        t, u, v = np.linalg.solve(np.column_stack([p - q, b - a, c - a]), p - a)
        expected = 0.0 <= t <= 1.0 and u >= 0.0 and v >= 0.0 and u + v <= 1.0
        assert crosses(*p, *q, np.concatenate([a, b, c])) == expected


def test_a_segment_through_an_edge_does_not_slip_between_two_triangles():
    low, high = np.array([0, 0, 0, 1, 0, 0, 0, 1, 0.0]), np.array([1, 1, 0, 1, 0, 0, 0, 1, 0.0])
    for share in np.linspace(0.01, 0.99, 33):
        x, y = share, 1.0 - share
        assert crosses(x, y, 0.3, x, y, -0.7, low) or crosses(x, y, 0.3, x, y, -0.7, high)


def test_the_map_lists_every_triangle_in_reach_once():
    surface = closed_surface(meshes.hopper(open_top=True))
    corner = surface.vertices[surface.faces].reshape(-1, 9)
    origin, size, cells, reach = np.array([-1.0, -1.0, 0.0]), 0.1, np.array([20, 20, 23]), 0.15
    start, item = map_triangles(corner, Grid(origin, size, cells), reach)
    for point in random_points(surface, 100):
        cell = np.floor((point - origin) / size).astype(int)
        if (cell < 0).any() or (cell >= cells).any():
            continue
        flat = (cell[2] * cells[1] + cell[1]) * cells[0] + cell[0]
        listed = item[start[flat] : start[flat + 1]]
        assert len(set(listed.tolist())) == len(listed)
        distance = np.array([np.linalg.norm(point - closest_on_triangle(*point, row)) for row in corner])
        assert set(np.flatnonzero(distance < reach)) <= set(listed.tolist())
