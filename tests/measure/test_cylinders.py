from __future__ import annotations

import numpy as np
import pytest

from packgen.measure import volume_in_cylinder, volume_in_cylinder_between
from packgen.measure.cylinders import circles_overlap
from packgen.measure.volumes import sphere_volume, volume_below

FAR = (-99.0, 99.0)


def many(count=2000):
    """Spheres and cylinders in all positions, with those at which the closed form has a limit."""
    rng = np.random.default_rng(4)
    distance, height = rng.uniform(0, 3, count), rng.uniform(-1, 1, count)
    radius, cylinder = rng.uniform(0.2, 1.5, count), rng.uniform(0.01, 3, count)
    distance[:20] = 0.0
    distance[20:40] = cylinder[20:40]
    cylinder[40:60] = distance[40:60] * (1 + 1e-7)
    cylinder[60:80] = distance[60:80] + radius[60:80]
    radius[80:100] = distance[80:100] + cylinder[80:100]
    cylinder[100:110] = 0.0
    return distance, height, radius, cylinder


def test_a_sphere_on_the_axis_leaves_a_napkin_ring():
    radius, cylinder = np.full(3, 2.0), np.array([0.3, 1.0, 1.9])
    ring = 4 / 3 * np.pi * (radius**2 - cylinder**2) ** 1.5
    found = volume_in_cylinder(np.zeros(3), radius, cylinder)
    assert found == pytest.approx(sphere_volume(radius) - ring, rel=1e-9)


def test_a_wide_cylinder_through_the_middle_halves_a_sphere():
    found = volume_in_cylinder(np.array([1e4]), np.array([1.0]), np.array([1e4]))
    assert found[0] == pytest.approx(2 / 3 * np.pi, rel=1e-3)


def test_spheres_inside_count_whole_and_those_outside_not_at_all():
    found = volume_in_cylinder(np.array([0.5, 3.0]), np.array([0.4, 0.4]), np.array([1.0, 1.0]))
    assert found == pytest.approx([4 / 3 * np.pi * 0.4**3, 0.0])


def test_closed_form_and_integral_agree_everywhere():
    distance, height, radius, cylinder = many()
    closed = volume_in_cylinder(distance, radius, cylinder)
    # A plane through each sphere makes both of its parts go through the integral.
    height[:] = 0.1
    low = volume_in_cylinder_between(distance, height, radius, cylinder, (-99.0, 0.0))
    high = volume_in_cylinder_between(distance, height, radius, cylinder, (0.0, 99.0))
    assert np.abs((low + high - closed) / sphere_volume(radius)).max() < 1e-7
    assert np.isfinite(closed).all()


def test_between_planes_a_wide_cylinder_leaves_caps():
    distance, height, radius, _ = many()
    wide = np.full(len(radius), 99.0)
    found = volume_in_cylinder_between(distance, height, radius, wide, (-99.0, 0.1))
    np.testing.assert_allclose(found, volume_below(height, radius, 0.1), atol=1e-9)
    whole = volume_in_cylinder_between(distance, height, radius, wide, FAR)
    np.testing.assert_allclose(whole, sphere_volume(radius))


@pytest.mark.parametrize(
    ("distance", "expected"),
    [(3.5, 0.0), (0.5, np.pi), (2.0, None)],
)
def test_circles_share_what_geometry_says(distance, expected):
    found = float(circles_overlap(np.array(1.0), np.array(2.0), np.array(distance)))
    if expected is None:  # the lens of two circles, by a fine sum over strips
        x = np.linspace(-1, 1, 200_001)
        half = np.minimum(np.sqrt(1 - x**2), 9.0)
        inner = np.maximum(np.sqrt(np.maximum(4 - x**2, 0)) - distance + half, 0)
        expected = np.trapezoid(np.minimum(inner, 2 * half), x)
    assert found == pytest.approx(expected, rel=1e-4)
