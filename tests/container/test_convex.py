"""The planes of convex vessels, held against QHULL's own volume and against their triangles."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection

from packgen.container.convex import EXACT_MAX, convex_hull, enclosed_volume, is_convex
from packgen.errors import GeometryError
from packgen.geometry import Mesh, Surface


def points_of(seed, count=60):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(count, 3)) * [1.0, 2.0, 0.5] + rng.uniform(-5, 5, 3)


@pytest.mark.parametrize("seed", range(4))
def test_the_planes_bound_what_qhull_says(seed):
    points = points_of(seed)
    found = convex_hull(points, "here")
    hull, volume = found.shape(), found.volume
    assert volume == pytest.approx(ConvexHull(points).volume, rel=1e-12)
    assert np.linalg.norm(hull.normal, axis=1) == pytest.approx(1.0)
    assert (points @ hull.normal.T <= hull.offset + 1e-5 * np.ptp(points)).all()
    halfspaces = np.column_stack([hull.normal, -hull.offset])
    inner = HalfspaceIntersection(halfspaces, points.mean(axis=0))
    assert ConvexHull(inner.intersections).volume == pytest.approx(volume, rel=1e-4)
    assert enclosed_volume(hull.surface.vertices, hull.surface.faces) == pytest.approx(volume)


def nearest(corner, point):
    """The distance of a point from a triangle: by the plane and, outside its prism, by the three edges."""
    normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
    normal /= np.linalg.norm(normal)
    foot = point - ((point - corner[0]) @ normal) * normal
    sides = [np.cross(corner[(k + 1) % 3] - corner[k], foot - corner[k]) @ normal for k in range(3)]
    if min(sides) >= 0.0:
        return abs((point - corner[0]) @ normal)
    best = np.inf
    for k in range(3):
        start, edge = corner[k], corner[(k + 1) % 3] - corner[k]
        share = np.clip((point - start) @ edge / (edge @ edge), 0.0, 1.0)
        best = min(best, float(np.linalg.norm(point - start - share * edge)))
    return best


@settings(max_examples=15, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**6), rounding=st.sampled_from([0.0, 3e-8, 1e-7]))
def test_a_sphere_within_the_planes_never_cuts_a_triangle(seed, rounding):
    """Of a mesh with flats in many facets, its corners rounded as a file of float32 rounds them."""
    rng = np.random.default_rng(seed)
    mesh = trimesh.convex.convex_hull(points_of(seed, 20)).subdivide()
    vertices = mesh.vertices + rng.uniform(-1, 1, mesh.vertices.shape) * rounding * np.ptp(mesh.vertices)
    hull = convex_hull(vertices, "here").shape()
    for _ in range(6):
        point = vertices[rng.integers(len(vertices), size=4)].mean(axis=0)
        room = float((hull.offset - hull.normal @ point).min())
        distance = min(nearest(vertices[face], point) for face in mesh.faces)
        assert room <= distance + 1e-12 * np.ptp(vertices)
        assert room >= distance - 1e-5 * np.ptp(vertices)


def test_the_hulls_largest_ball_is_that_of_linear_programming():
    """Chebyshev's centre (Boyd and Vandenberghe, Convex Optimization, section 8.5.1) of a cut cube.

    It lies on the diagonal at (t, t, t), where 1 - t = (3 t - 1) / sqrt(3): the radius is 1 - 1 / sqrt(3).
    """
    cube = np.array(np.meshgrid([0, 1.0], [0, 1.0], [0, 1.0])).reshape(3, -1).T
    hull = convex_hull(cube[1:], "here").shape()  # one corner cut off: by the plane x + y + z >= 1
    found = linprog(
        [0, 0, 0, -1], A_ub=np.column_stack([hull.normal, np.ones(len(hull.normal))]), b_ub=hull.offset,
        bounds=[(None, None)] * 4,
    )  # fmt: skip
    assert found.x[3] == pytest.approx(1.0 - 1.0 / np.sqrt(3.0), rel=1e-5)


@pytest.mark.parametrize("count", [4, 3000])
def test_coplanar_points_span_no_volume(count):
    points = np.random.default_rng(0).uniform(-1, 1, (count, 3)) * [1.0, 1.0, 0.0] + 7.0
    with pytest.raises(GeometryError, match=r"here: .*flat"):
        convex_hull(points, "here")


@pytest.mark.parametrize("shift", [0.0, 1e6])
def test_flat_sides_of_many_facets_are_one_plane_each(shift):
    mesh = trimesh.creation.box([1.0, 2.0, 3.0])
    for _ in range(5):
        mesh = mesh.subdivide()
    assert len(mesh.vertices) > EXACT_MAX
    found = convex_hull(mesh.vertices + shift, "here")
    hull, volume = found.shape(), found.volume
    assert volume == pytest.approx(6.0, rel=1e-6)
    assert len(hull.normal) == 6
    assert np.abs(hull.normal).max(axis=1) == pytest.approx(1.0, abs=1e-8)
    assert hull.offset - shift * hull.normal.sum(axis=1) == pytest.approx(
        np.abs(hull.normal) @ [0.5, 1.0, 1.5], abs=1e-5
    )


def test_a_finely_curved_hull_keeps_its_triangles():
    mesh = trimesh.creation.icosphere(subdivisions=4)
    found = convex_hull(mesh.vertices, "here")
    hull, volume = found.shape(), found.volume
    assert isinstance(hull, Mesh)
    assert volume == pytest.approx(mesh.volume, rel=1e-8)
    assert enclosed_volume(hull.surface.vertices, hull.surface.faces) == pytest.approx(volume)


def test_a_polygon_of_thousands_of_corners_does_not_take_qhull_minutes():
    mesh = trimesh.creation.cylinder(radius=0.5, height=2.0, sections=6000)
    volume = convex_hull(mesh.vertices, "here").volume
    assert volume == pytest.approx(mesh.volume, rel=1e-6)


def test_a_dent_makes_a_mesh_not_convex():
    mesh = trimesh.creation.icosphere(subdivisions=2)
    whole = Surface(mesh.vertices, mesh.faces)
    hull_volume = convex_hull(whole.vertices, "here").volume
    assert is_convex(whole, hull_volume, enclosed_volume(whole.vertices, whole.faces))
    vertices = mesh.vertices.copy()
    vertices[0] *= 0.9
    hull_volume = convex_hull(vertices, "here").volume
    assert not is_convex(Surface(vertices, mesh.faces), hull_volume, enclosed_volume(vertices, mesh.faces))
