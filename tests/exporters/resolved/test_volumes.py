from __future__ import annotations

import numpy as np
import pytest

from exporters.resolved import volumes

RNG = np.random.default_rng(11)


def cloud(low, high, count=400_000):
    """Points of a box, and the volume that each stands for."""
    low, high = np.asarray(low, float), np.asarray(high, float)
    return RNG.uniform(low, high, (count, 3)), float(np.prod(high - low)) / count


def test_a_cap_is_nothing_half_or_all_of_a_ball():
    radius = np.array([2.0, 2.0, 2.0, 2.0])
    volume = volumes.cap(radius, np.array([2.5, 2.0, 0.0, -3.0]))
    assert np.allclose(volume, volumes.ball(radius) * [0, 0, 0.5, 1])


@pytest.mark.parametrize(
    ("first", "second", "distance", "share"),
    [(1.0, 1.0, 1.0, 5 / 16), (1.0, 0.5, 0.2, 0.125), (0.5, 1.0, 0.0, 0.125), (1.0, 1.0, 2.0, 0.0)],
)
def test_a_lens_is_what_two_balls_share(first, second, distance, share):
    volume = volumes.lens(np.array([first]), np.array([second]), np.array([distance]))
    assert volume[0] == pytest.approx(share * 4 / 3 * np.pi, abs=1e-12)


def test_a_bridge_to_a_hollow_wall_is_what_points_count():
    ball, rod, wall, curvature = 1.0, 0.4, 1.1, 3.0
    point, each = cloud((-rod, -rod, 0.5), (rod, rod, wall))
    from_axis = np.hypot(point[:, 0], curvature - wall + point[:, 2])
    inside = (np.hypot(point[:, 0], point[:, 1]) < rod) & (from_axis < curvature)
    inside &= np.linalg.norm(point, axis=1) > ball
    volume = volumes.cylinder_beyond(np.array([ball]), np.array([rod]), np.array([wall]))
    volume += volumes.behind_flat(np.array([rod]), curvature)
    assert volume[0] == pytest.approx(inside.sum() * each, abs=5 * each * np.sqrt(inside.sum()))
    assert volumes.behind_flat(np.array([rod]), np.inf)[0] == 0.0


def test_the_quadrature_of_a_ball_that_is_cut_agrees_with_the_closed_form():
    normal = np.array([[0.0, 0.6, 0.8], [0.0, 0.6, -0.8]])
    plane = np.array([0.9, 0.95])
    exact = volumes.ball(np.ones(1)) - volumes.cap(np.ones(2), plane).sum()
    assert volumes.cut_ball(1.0, normal, plane) == pytest.approx(exact[0], rel=volumes.DIRECTIONS_ERROR)
    # Two planes at right angles through the middle of the ball, nearly.
    quarter = volumes.cut_ball(1.0, np.eye(3)[:2], np.full(2, 1e-9))
    assert quarter == pytest.approx(np.pi / 3, rel=2e-3)
