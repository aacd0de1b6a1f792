"""Claims on the largest spheres of voids, against closed forms and random points."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from packgen.arrange.space.seams import Seams
from packgen.arrange.void_filling.hollow import Hollow
from packgen.arrays import Float64Array
from packgen.distributions import UNIT_VOLUME
from packgen.geometry import Ball, Box, Cone
from tests.arrange.void_filling.shapes import (
    UNIT_CUBE,
    ell,
    farthest_left,
    hollow,
    least_gap,
    tetrahedron,
)

DOWN = np.array([0.0, 0.0, -1.0])
CORNER = (math.sqrt(3.0) - 1.0) / (2.0 * (math.sqrt(3.0) + 1.0))


def edge_radius() -> float:
    """Radius of a sphere in a cube's edge, between the middle sphere and a corner's."""

    def excess(radius: float) -> float:
        to_corner = math.sqrt(6.0 * CORNER * radius - radius**2 - CORNER**2)
        to_middle = math.sqrt(3.0 * radius - radius**2 - 0.25)
        return CORNER + to_corner + to_middle - 0.5

    return float(brentq(excess, 0.09, 0.1, xtol=1e-15))


def solid(ball: Float64Array) -> float:
    return float(UNIT_VOLUME * (ball[:, 3] ** 3).sum())


def test_a_cube_takes_one_sphere_then_eight_in_corners_then_24_along_its_edges() -> None:
    found = hollow(UNIT_CUBE)
    assert found.fill(1e-3, 33, math.inf)
    np.testing.assert_allclose(found.ball[:1], [[0.5, 0.5, 0.5, 0.5]], atol=1e-12)
    np.testing.assert_allclose(found.ball[1:9, 3], CORNER, rtol=1e-12)
    np.testing.assert_allclose(found.ball[9:, 3], edge_radius(), rtol=1e-11)
    assert solid(found.ball[:9]) == pytest.approx(0.604182246, rel=1e-9)
    # The middles of the edges are narrower: they have room for (sqrt 2 - 1) / (2 (sqrt 2 + 1)) alone.
    assert edge_radius() > (math.sqrt(2.0) - 1.0) / (2.0 * (math.sqrt(2.0) + 1.0))
    assert least_gap(found.ball) >= 0.0


def test_a_regular_tetrahedron_takes_one_sphere_and_four_of_half_its_radius() -> None:
    found = hollow(tetrahedron())
    assert found.fill(1e-3, 5, math.inf)
    first = 1.0 / math.sqrt(3.0)
    np.testing.assert_allclose(found.ball[:, 3], [first] + [0.5 * first] * 4, rtol=1e-12)
    assert solid(found.ball[:1]) / (8.0 / 3.0) == pytest.approx(math.pi * math.sqrt(3.0) / 18.0, rel=1e-12)
    assert solid(found.ball) / (8.0 / 3.0) == pytest.approx(math.pi * math.sqrt(3.0) / 12.0, rel=1e-12)


def test_a_sphere_is_filled_by_one() -> None:
    found = hollow(Ball(np.array([1.0, 2.0, 3.0]), 0.7))
    assert found.fill(1e-3, 1, math.inf)
    np.testing.assert_allclose(found.ball, [[1.0, 2.0, 3.0, 0.7]], rtol=1e-12)
    assert not found.fill(1e-3, 1, math.inf)


def test_a_cylinder_and_a_cone_take_their_inscribed_spheres() -> None:
    up = np.array([0.0, 0.0, 1.0])
    found = hollow(Cone(np.zeros(3), up, 3.0, 0.5, 0.5))
    assert found.fill(0.4, 1, math.inf)
    np.testing.assert_allclose(found.ball[:, 3], 0.5, rtol=1e-12)
    found = hollow(Cone(np.zeros(3), up, 2.0, 1.5, 0.0))
    assert found.fill(0.1, 1, math.inf)
    np.testing.assert_allclose(found.ball, [[0.0, 0.0, 0.75, 0.75]], atol=1e-11)


def test_fcc_has_octahedral_and_tetrahedral_voids() -> None:
    cell = np.array([[0, 0, 0], [0, 1, 1], [1, 0, 1], [1, 1, 0]]) / 2.0
    grid = np.array([[i, j, k] for i in range(2) for j in range(2) for k in range(2)])
    centre = (cell[None] + grid[:, None]).reshape(-1, 3)
    radius = math.sqrt(2.0) / 4.0
    bounds = np.array([[0.0] * 3, [2.0] * 3])
    seams = Seams(np.zeros(3), np.full(3, 2.0))
    ball = np.column_stack([centre, np.full(32, radius)])
    found = Hollow([Box(*bounds)], bounds, seams, ball)
    assert found.fill(0.05, 32 + 64, math.inf)
    np.testing.assert_allclose(found.ball[:32, 3], (math.sqrt(2.0) - 1.0) * radius, rtol=1e-11)
    np.testing.assert_allclose(found.ball[32:, 3], (math.sqrt(1.5) - 1.0) * radius, rtol=1e-11)


def test_each_sphere_is_the_largest_that_fits_where_walls_are_not_convex() -> None:
    found, bounds = hollow(ell()), np.array([[0.0] * 3, [2.0, 2.0, 1.0]])
    for count in (3, 20, 100):
        assert found.fill(1e-3, count, math.inf)
        last = found.ball[-1, 3]
        assert farthest_left(found, bounds, 50_000) <= last * (1.0 + 1e-9)
    assert np.diff(found.ball[:, 3]).max() <= 1e-12
    assert least_gap(found.ball) >= 0.0


def test_drawn_spheres_touch_three_things_and_overlap_nothing() -> None:
    found = hollow(ell())
    radii = np.sort(np.random.default_rng(0).uniform(0.05, 0.15, 150))[::-1].copy()
    placed = found.place(radii, math.inf, DOWN)
    ball = found.ball.copy()
    np.testing.assert_array_equal(ball[:, 3], radii[placed])
    assert placed.sum() > 100
    assert least_gap(ball) >= 0.0
    walls = hollow(ell()).distance(ball[:, :3]) - ball[:, 3]
    assert walls.min() >= 0.0


def test_a_drawn_sphere_goes_into_the_smallest_void_that_takes_it() -> None:
    found = hollow(UNIT_CUBE, np.array([[0.5, 0.5, 0.5, 0.49]]))
    radius = 0.99 * CORNER
    assert found.place(np.array([radius]), math.inf, DOWN).all()
    # A corner takes it, and in it the lowest place that three things hold.
    assert found.distance(found.ball[:, :3])[0] == pytest.approx(-radius)
    gap = np.sort(np.concatenate([found.ball[0, :3], 1.0 - found.ball[0, :3]]))[:3] - radius
    assert gap.max() < 0.05


def test_what_fits_nowhere_is_left_out_and_smaller_ones_are_still_tried() -> None:
    found = hollow(UNIT_CUBE)
    placed = found.place(np.array([0.6, 0.5 - 1e-9, 0.3, 0.1]), math.inf, DOWN)
    assert placed.tolist() == [False, True, False, True]


def test_the_same_space_is_filled_alike_each_time() -> None:
    balls = []
    for _ in range(2):
        found = hollow(ell())
        found.fill(1e-3, 50, math.inf)
        balls.append(found.ball.copy())
    np.testing.assert_array_equal(balls[0], balls[1])
