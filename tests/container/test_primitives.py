"""Tessellations of primitives: closed, wound outward, and nowhere inside the true wall."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from packgen.container.primitives import ball_surface, box_surface, cone_surface, perpendicular
from packgen.geometry import Ball, Box, Cone

TILTED = np.array([2.0, -1.0, 2.0]) / 3.0
SHAPES = {
    "box": Box([-1, 0, 2], [1, 3, 2.5]),
    "cylinder": Cone([1, 2, 3], [0, 0, 1], 2.0, 0.5, 0.5),
    "tilted": Cone([1, 2, 3], TILTED, 2.0, 0.5, 1.5),
    "pointed below": Cone([0, 0, 0], [0, 0, 1], 2.0, 0.0, 1.0),
    "pointed above": Cone([0, 0, 0], [0, 1, 0], 2.0, 1.0, 0.0),
    "ball": Ball([1, 1, -1], 0.7),
}


def tessellated(shape):
    form = {Box: box_surface, Cone: cone_surface, Ball: ball_surface}[type(shape)]
    return form(shape)


def true_volume(shape):
    if isinstance(shape, Box):
        return float(np.prod(shape.max - shape.min))
    if isinstance(shape, Ball):
        return 4.0 / 3.0 * math.pi * shape.radius**3
    low, high = shape.radius_bottom, shape.radius_top
    return math.pi * shape.height / 3.0 * (low**2 + low * high + high**2)


def depth_inside(shape, point):
    """How far points are inside the true wall; negative outside."""
    if isinstance(shape, Box):
        return np.minimum(point - shape.min, shape.max - point).min(axis=1)
    if isinstance(shape, Ball):
        return shape.radius - np.linalg.norm(point - shape.center, axis=1)
    along = (point - shape.base) @ shape.axis
    off = np.linalg.norm(point - shape.base - along[:, None] * shape.axis, axis=1)
    radius = shape.radius_bottom + (shape.radius_top - shape.radius_bottom) * along / shape.height
    return np.minimum(np.minimum(along, shape.height - along), radius - off)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_facets_lie_on_or_just_outside_the_true_wall(shape):
    surface = tessellated(shape)
    mesh = trimesh.Trimesh(surface.vertices, surface.faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert true_volume(shape) * (1 - 1e-12) <= mesh.volume <= true_volume(shape) * 1.01
    points, _ = trimesh.sample.sample_surface(mesh, 4000, seed=0)
    size = float(np.ptp(surface.vertices))
    assert depth_inside(shape, points).max() <= 1e-9 * size
    assert depth_inside(shape, points).min() >= -0.01 * size


@pytest.mark.parametrize("axis", [[1, 0, 0], [0, 0, -1], TILTED])
def test_perpendicular_vectors_make_a_right_handed_system(axis):
    first, second = perpendicular(np.array(axis, float))
    assert np.linalg.det(np.stack([first, second, axis])) == pytest.approx(1.0)
