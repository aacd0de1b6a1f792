from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from packgen.programmes.forces import FIXED, balance, least_friction
from tests.programmes.balance import weight_shares_carried
from tests.programmes.structures import make_structure, pyramid, turned, wedge

DOWN = (0, 0, -1)


def test_a_sphere_on_a_floor_stands_without_friction():
    structure = make_structure(1, [(0, FIXED, DOWN)])
    assert balance(structure, 0.0).share < 1e-5
    assert least_friction(structure, 0.001) == 0.0


def test_a_sphere_without_contacts_falls_freely():
    found = balance(make_structure(2, [(0, FIXED, DOWN)]))
    assert found.share == pytest.approx(0.5)
    assert found.left[1] == pytest.approx([0, 0, -1])


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_contact_above_does_not_pull(friction):
    found = balance(make_structure(1, [(0, FIXED, (0, 0, 1))]), friction)
    assert found.share == pytest.approx(1.0)
    assert not found.force.any()


def test_a_sphere_on_one_slope_slides_by_the_tangent_and_rolls_at_any_friction():
    angle = 0.4
    slope = make_structure(1, [(0, FIXED, (np.sin(angle), 0, -np.cos(angle)))])
    assert balance(slope, 0.0).share == pytest.approx(np.sin(angle), abs=1e-3)
    # A solid sphere that rolls has 5/7 of that acceleration.
    assert balance(slope, 2.0).share == pytest.approx(5 / 7 * np.sin(angle), abs=1e-3)


@pytest.mark.parametrize("legs", [2, 3])
def test_a_pyramid_stands_from_the_tangent_of_half_its_legs_angle_on(legs):
    structure, least = pyramid(legs)
    assert least_friction(structure, 1e-3) == pytest.approx(least, rel=0.06)
    assert balance(structure, least + 0.01).share < 1e-3
    assert balance(structure, least - 0.02).share > 1e-3


def test_a_wedged_sphere_is_held_from_the_tangent_of_the_walls_lean_on():
    assert least_friction(wedge(0.3), 1e-3) == pytest.approx(np.tan(0.3), rel=0.06)


def test_a_tower_of_two_stands_and_a_leaning_one_does_not():
    upright = make_structure(2, [(0, FIXED, DOWN), (1, 0, DOWN)])
    assert least_friction(upright, 1e-3) == 0.0
    leaning = make_structure(2, [(0, FIXED, DOWN), (1, 0, (0.2, 0, -1))])
    assert least_friction(leaning, 1e-3) is None


def test_each_contact_has_its_own_friction():
    structure, least = pyramid(3)
    smooth = structure.friction.copy()
    smooth[:3] = 0.5 * least  # the floor: a quarter would do
    smooth[3:] = least + 0.01
    object.__setattr__(structure, "friction", smooth)
    assert balance(structure).share < 1e-3
    smooth[:3] = 0.2 * least
    assert balance(structure).share > 1e-3


@pytest.mark.parametrize("friction", [0.0, 0.2, 0.31, 0.33, 0.6])
def test_linear_programmes_find_the_same_to_stand(friction):
    for structure in (pyramid(3)[0], pyramid(2)[0], wedge(0.25)):
        lost = 1.0 - weight_shares_carried(structure, friction).mean()
        assert (lost < 1e-6) == (balance(structure, friction).share < 2e-3)


def test_shares_do_not_depend_on_axes_or_units():
    structure, least = pyramid(3)
    rotation = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    here, there = balance(structure, 0.5 * least), balance(turned(structure, rotation), 0.5 * least)
    assert here.share == pytest.approx(there.share, rel=1e-6)
    assert here.left @ rotation.T == pytest.approx(there.left, abs=1e-6)
    scaled = make_structure(4, [], (0, 0, -1.0))
    object.__setattr__(structure, "weight", 1e-9 * scaled.weight)
    object.__setattr__(structure, "mass", 1e-10 * scaled.mass)
    assert balance(structure, 0.5 * least).share == pytest.approx(here.share, rel=1e-6)


def test_forces_obey_the_cones_and_leave_what_is_said():
    structure, _ = pyramid(3)
    found = balance(structure, 0.2)
    along = np.einsum("ij,ij->i", found.force, structure.normal)
    across = np.linalg.norm(found.force - along[:, None] * structure.normal, axis=1)
    assert (across <= 0.2 * along + 1e-12).all()
    left = structure.weight.copy()
    for contact, (one, other) in enumerate(zip(structure.first, structure.second, strict=True)):
        left[one] -= found.force[contact]
        if other != FIXED:
            left[other] += found.force[contact]
    assert left == pytest.approx(found.left, abs=1e-12)


def test_nothing_at_all_is_no_question():
    empty = make_structure(0, [])
    assert balance(empty).share == 0.0
    assert least_friction(empty, 0.01) == 0.0
