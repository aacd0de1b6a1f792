"""Gaps between spheres and wall features against independent formulas."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from packgen.arrange.space.feature_kernels import BALL, CENTER_PLANE, CONE, PLANE, TRIANGLE, wall_gap

QUICK = settings(max_examples=60, deadline=None, derandomize=True)


def gap_of(kind, numbers, point, radius):
    row = np.zeros(12)
    row[: len(numbers)] = numbers
    gap, *push = wall_gap(kind, row, *point, radius)
    return gap, np.array(push)


POINTS = st.tuples(*[st.floats(-2.0, 2.0)] * 3).map(np.array)
RADII = st.floats(0.01, 1.0)


@QUICK
@given(point=POINTS, normal=POINTS, radius=RADII)
def test_plane_gaps_are_projections(point, normal, radius):
    normal = normal / np.linalg.norm(normal) if np.linalg.norm(normal) > 0.1 else np.array([0.0, 0, 1])
    for kind, size in ((PLANE, radius), (CENTER_PLANE, 0.0)):
        gap, push = gap_of(kind, [*normal, 0.3], point, radius)
        foot = point - push * gap
        assert normal @ foot == pytest.approx(0.3 - size, abs=1e-12)
        assert push == pytest.approx(-normal)


@QUICK
@given(
    point=POINTS,
    bottom=st.floats(0.0, 2.0),
    top=st.floats(0.1, 2.0),
    height=st.floats(0.5, 3.0),
    radius=RADII,
)
def test_cone_gaps_are_distances_to_the_nearest_generator(point, bottom, top, height, radius):
    slope = top - bottom
    length = np.hypot(height, slope)
    row = [0.1, -0.2, 0.3, 0, 0, 1, bottom, height / length, slope / length]
    gap, push = gap_of(CONE, row, point, radius)
    # In the meridian plane through the point the generator is a line; its distance by the cross product.
    away = point - np.array([0.1, -0.2, 0.3])
    meridian = np.array([np.hypot(away[0], away[1]) - bottom, away[2]])
    generator = np.array([slope, height]) / length
    assert gap == pytest.approx(generator[0] * meridian[1] - generator[1] * meridian[0] - radius, abs=1e-12)
    if np.hypot(away[0], away[1]) > 1e-6:
        assert np.linalg.norm(push) == pytest.approx(1.0)
        moved, _ = gap_of(CONE, row, point + 1e-7 * push, radius)
        assert moved - gap == pytest.approx(1e-7, rel=1e-3)


@QUICK
@given(point=POINTS, radius=RADII)
def test_ball_gaps_are_what_is_left_to_the_shell(point, radius):
    center = np.array([0.3, 0.1, -0.4])
    gap, push = gap_of(BALL, [*center, 3.0], point, radius)
    assert np.linalg.norm(point - center) + radius + gap == pytest.approx(3.0)
    if np.linalg.norm(point - center) > 1e-9:
        assert push == pytest.approx((center - point) / np.linalg.norm(center - point))


def closest_by_minimiser(corner, point):
    """The point of a triangle nearest to another, by minimising over its two barycentric coordinates."""
    a, b, c = corner

    def square(weight):
        return np.sum((a + weight[0] * (b - a) + weight[1] * (c - a) - point) ** 2)

    inside = {"type": "ineq", "fun": lambda weight: 1.0 - weight[0] - weight[1]}
    starts = [(1 / 3, 1 / 3), (0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]
    found = [
        minimize(square, start, bounds=[(0, 1)] * 2, constraints=[inside], tol=1e-14) for start in starts
    ]
    return np.sqrt(min(each.fun for each in found))


def test_triangle_gaps_are_those_of_a_minimiser():
    rng = np.random.default_rng(5)
    for _ in range(40):
        corner, point = rng.uniform(-1, 1, (3, 3)), rng.uniform(-2, 2, 3)
        gap, push = gap_of(TRIANGLE, [*corner.ravel(), 0, 0, 1], point, 0.25)
        distance = closest_by_minimiser(corner, point)
        assert gap + 0.25 == pytest.approx(distance, abs=1e-6)
        assert np.linalg.norm(push) == pytest.approx(1.0)
        # Against the push lies the triangle: its plane or an edge is met at that distance.
        assert closest_by_minimiser(corner, point - push * (gap + 0.25)) == pytest.approx(0.0, abs=2e-6)


def test_a_centre_on_a_triangle_is_pushed_to_its_inner_side():
    gap, push = gap_of(TRIANGLE, [0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, -1], [0.2, 0.2, 0.0], 0.25)
    assert gap == -0.25
    assert push == pytest.approx([0, 0, -1])
