from __future__ import annotations

import numpy as np
import pytest

from packgen.geometry import Cone, Mesh
from packgen.measure import de_klerk_porosity, mueller_porosity, radial_profile, round_part
from tests.beds import box_container, make_bed, make_container, revolved_surface

UP = np.array([0.0, 0.0, 1.0])


def tube(radius=3.0, height=20.0):
    surface = revolved_surface([(0, radius), (height, radius)], 96)
    cone = Cone(np.zeros(3), UP, height, radius, radius)
    return make_container(cone, surface, np.pi * radius**2 * height)


def test_a_column_on_the_axis_has_the_profile_of_its_napkin_rings():
    bed = make_bed([[0, 0, 0.5 + k] for k in range(12)], 0.5, tube())
    found = radial_profile(bed)
    # Measured from 2 d to 2 d below the top sphere's centre: seven spheres and a half.
    assert (found.low, found.high) == (2.0, 9.5)
    radius = 3.0 - np.array(found.wall_distance)
    inside = 4 / 3 * np.pi * (0.125 - np.maximum(0.25 - radius**2, 0.0) ** 1.5)
    porosity = 1 + np.diff(7.5 * inside) / (-np.diff(radius**2) * np.pi * 7.5)
    assert porosity.min() < 0.3
    np.testing.assert_allclose(found.porosity, 1 - (1 - porosity), atol=1e-7)
    assert found.wall_distance[-1] == 3.0


def test_the_shells_together_hold_the_mean_porosity():
    rng = np.random.default_rng(0)
    bed = make_bed(rng.uniform([-2, -2, 0.5], [2, 2, 15], (500, 3)), 0.4, tube())
    found = radial_profile(bed)
    area = -np.diff((found.radius - np.array(found.wall_distance) * found.diameter) ** 2)
    assert found.bulk == pytest.approx((area * found.porosity).sum() / area.sum())  # no shell is 5 d deep


def test_a_facetted_tube_is_round_in_its_straight_part_only():
    surface = revolved_surface([(0, 1.0), (4, 2.0), (9, 2.0), (12, 0.5)], 48)
    part = round_part(make_container(Mesh(surface), surface, 1.0), UP)
    assert part.radius == pytest.approx(2.0, rel=3e-3)
    assert 4.0 <= part.low < 4.2
    assert 8.8 < part.high <= 9.0


@pytest.mark.parametrize("gravity", [[0, 0, 9.81], [9.81, 0, 0]])
def test_a_cylinder_is_round_about_gravity_only(gravity):
    bed = make_bed(np.tile([[0, 0, 10.0]], (3, 1)), 0.5, tube(), gravity=np.array(gravity, dtype=float))
    up = -np.array(gravity) / 9.81
    assert (round_part(bed.container, up) is None) == (gravity[0] > 0)


def test_a_box_and_a_cone_are_nowhere_round():
    assert round_part(box_container([0] * 3, [1] * 3), UP) is None
    surface = revolved_surface([(0, 0.5), (4, 2.0)], 48)
    assert round_part(make_container(Cone(np.zeros(3), UP, 4.0, 0.5, 2.0), surface, 1.0), UP) is None
    assert round_part(make_container(Mesh(surface), surface, 1.0), UP) is None


def test_published_curves_begin_at_one_and_end_at_their_bulk():
    x = np.array([0.0, 40.0])
    assert mueller_porosity(x, 10.0) == pytest.approx([1.0, 0.379 + 0.078 / 8.2], abs=1e-4)
    assert de_klerk_porosity(x, 0.4) == pytest.approx([1.0, 0.4])


@pytest.mark.parametrize(("ratio", "expected"), [(10.0, 0.174), (20.0, 0.175)])
def test_mueller_has_its_first_minimum_half_a_diameter_from_the_wall(ratio, expected):
    assert mueller_porosity(np.array(0.5), ratio) == pytest.approx(expected, abs=1e-3)
    assert de_klerk_porosity(np.array(0.5), 0.4) == pytest.approx(2.14 * 0.25 - 2.53 * 0.5 + 1)
