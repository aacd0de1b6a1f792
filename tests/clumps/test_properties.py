from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from packgen.clumps.properties import (
    mesh_properties,
    sum_of_spheres,
    union_area,
    union_properties,
    without_contained,
)

SHIFT = np.array([0.3, -0.2, 0.7])


def lens(big: float, small: float, apart: float) -> float:
    """Volume that two spheres share."""
    a, b, d = big, small, apart
    return (
        math.pi
        * (a + b - d) ** 2
        * (d * d + 2 * d * b - 3 * b * b + 2 * d * a + 6 * a * b - 3 * a * a)
        / (12 * d)
    )


def turned(spheres, seed):
    rotation = Rotation.random(rng=np.random.default_rng(seed))
    return np.column_stack([rotation.apply(spheres[:, :3]) + SHIFT, spheres[:, 3]]), rotation


def cluster(count, seed):
    rng = np.random.default_rng(seed)
    return np.column_stack([rng.normal(0.0, 1.0, (count, 3)), rng.uniform(0.3, 1.2, count)])


def test_one_sphere_has_its_closed_forms():
    found = union_properties(np.array([[1.0, -2.0, 3.0, 0.5]]))
    volume = 4 / 3 * math.pi * 0.5**3
    assert found.volume == pytest.approx(volume, rel=1e-13)
    np.testing.assert_allclose(found.centre, [1.0, -2.0, 3.0], atol=1e-13)
    np.testing.assert_allclose(found.inertia, 0.4 * volume * 0.25 * np.eye(3), atol=1e-13)
    assert found.equivalent_diameter == pytest.approx(1.0, rel=1e-13)


@pytest.mark.parametrize("axis", [[0, 0, 1], [1, 0, 0], [1, 2, -3], [1e-9, 0, 1]])
@pytest.mark.parametrize("apart", [0.5, 0.9, 1.3, 1.6999])
def test_two_spheres_share_a_lens(axis, apart):
    direction = np.asarray(axis, float) / np.linalg.norm(axis)
    pair = np.array([[0, 0, 0, 1.0], [*(apart * direction), 0.7]])
    shared = lens(1.0, 0.7, apart)
    assert union_properties(pair).volume == pytest.approx(sum_of_spheres(pair) - shared, rel=1e-9)
    high = (apart**2 + 1.0 - 0.49) / (2 * apart)  # plane of the circle in which they meet
    low = apart - high
    area = 2 * math.pi * (1.0 + high) + 2 * math.pi * 0.7 * (0.7 + low)
    assert union_area(pair) == pytest.approx(area, rel=1e-9)


def test_spheres_apart_add_up_and_parallel_axes_hold():
    pair = np.array([[-2.0, 0, 0, 1.0], [2.0, 0, 0, 1.0]])
    found = union_properties(pair)
    each = 4 / 3 * math.pi
    assert found.volume == pytest.approx(2 * each, rel=1e-13)
    np.testing.assert_allclose(np.diag(found.inertia), [0.8 * each, 8.8 * each, 8.8 * each], rtol=1e-12)


def test_spheres_within_others_and_twice_the_same_count_once():
    spheres = np.array([[0, 0, 0, 1.0], [0.2, 0.1, 0, 0.3], [0, 0, 0, 1.0], [0.5, 0, 0, 0.5]])
    assert len(without_contained(spheres)) == 1
    assert union_properties(spheres).volume == pytest.approx(4 / 3 * math.pi, rel=1e-13)


@pytest.mark.parametrize("count", [3, 12, 60])
def test_a_union_is_the_same_from_all_sides(count):
    spheres = cluster(count, count)
    one = union_properties(spheres)
    for seed in range(4):
        other, rotation = turned(spheres, seed)
        two = union_properties(other)
        assert two.volume == pytest.approx(one.volume, rel=1e-7)
        np.testing.assert_allclose(two.centre, rotation.apply(np.array(one.centre)) + SHIFT, atol=1e-7)
        matrix = rotation.as_matrix()
        np.testing.assert_allclose(
            two.inertia, matrix @ one.inertia @ matrix.T, atol=1e-7 * np.trace(one.inertia)
        )


def test_a_union_agrees_with_points_thrown_at_random():
    spheres = cluster(12, 1)
    rng = np.random.default_rng(0)
    low, high = (spheres[:, :3] - spheres[:, 3:]).min(axis=0), (spheres[:, :3] + spheres[:, 3:]).max(axis=0)
    point = rng.uniform(low, high, (400_000, 3))
    hit = np.zeros(len(point), bool)
    for x in spheres:
        hit |= ((point - x[:3]) ** 2).sum(axis=1) < x[3] ** 2
    share = hit.mean()
    box = float(np.prod(high - low))
    found = union_properties(spheres)
    assert found.volume == pytest.approx(
        box * share, abs=5 * box * math.sqrt(share * (1 - share) / len(point))
    )
    np.testing.assert_allclose(found.centre, point[hit].mean(axis=0), atol=0.02)
    near = point[hit] - point[hit].mean(axis=0)
    second = near.T @ near * box / len(point)
    np.testing.assert_allclose(found.inertia, np.trace(second) * np.eye(3) - second, rtol=0.02, atol=0.3)


def test_a_ring_of_equal_spheres_has_as_many_times_the_volume_of_one_link():
    # Each neighbour cuts a cap off; two spheres that are not neighbours do not meet.
    angle = 2 * np.pi * np.arange(12) / 12
    ring = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(12), np.full(12, 0.3)])
    apart = 2 * math.sin(math.pi / 12)
    volume = 12 * (4 / 3 * math.pi * 0.3**3 - lens(0.3, 0.3, apart))
    found = union_properties(ring)
    assert found.volume == pytest.approx(volume, rel=1e-9)
    np.testing.assert_allclose(found.centre, 0.0, atol=1e-12)
    assert found.inertia[0, 0] == pytest.approx(found.inertia[1, 1], rel=1e-9)


def test_mesh_properties_are_those_that_trimesh_finds():
    mesh = trimesh.creation.icosphere(2)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(0.3, [1, 2, 3]))
    mesh.vertices = mesh.vertices * [1.0, 0.7, 0.4] + [5.0, 1.0, -2.0]
    found = mesh_properties(np.asarray(mesh.triangles))
    assert found.volume == pytest.approx(mesh.volume, rel=1e-12)
    np.testing.assert_allclose(found.centre, mesh.center_mass, atol=1e-12)
    np.testing.assert_allclose(found.inertia, mesh.moment_inertia, atol=1e-12)
    moments, axes = found.principal()
    assert np.all(np.diff(moments) > 0.0)
    assert np.linalg.det(axes) == pytest.approx(1.0)
    np.testing.assert_allclose(axes @ np.diag(moments) @ axes.T, found.inertia, atol=1e-12)
