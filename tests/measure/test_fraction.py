from __future__ import annotations

import numpy as np
import pytest

from packgen.geometry import Cone, Mesh
from packgen.measure import find_core, height_profile, solid_fraction, solid_volume
from packgen.measure.core import Core
from tests.beds import box_container, cubic_lattice, make_bed, make_container, revolved_surface

UP = np.array([0.0, 0.0, 1.0])


def full_lattice(count=10, radius=0.1):
    side = 2 * radius * count
    return make_bed(cubic_lattice(count, radius), radius, box_container([0, 0, 0], [side] * 3))


def cells(low, high):
    """A core box between two corners, axis-parallel."""
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    return Core((low + high) / 2, np.eye(3), (high - low) / 2, "test")


def test_solid_fraction_of_a_simple_cubic_lattice_is_pi_over_six():
    # A box of whole unit cells, its faces through the spheres' centres.
    box = cells([0.3, 0.3, 0.3], [1.5, 1.3, 1.7])
    bed = full_lattice()
    assert solid_volume(bed.position, bed.radius, box) / box.volume == pytest.approx(np.pi / 6, rel=1e-12)


def test_solid_volume_does_not_depend_on_place_or_unit():
    bed = full_lattice(6)
    reference = solid_volume(bed.position, bed.radius, cells([0.23, 0.31, 0.18], [0.9, 0.8, 1.1]))
    scale, shift = 1e-6, 1e3
    box = cells(np.array([0.23, 0.31, 0.18]) * scale, np.array([0.9, 0.8, 1.1]) * scale)
    small = solid_volume(bed.position * scale, bed.radius * scale, box)
    assert small == pytest.approx(reference * scale**3, rel=1e-12)
    far = solid_volume(
        bed.position + shift,
        bed.radius,
        cells(np.add([0.23, 0.31, 0.18], shift), np.add([0.9, 0.8, 1.1], shift)),
    )
    assert far == pytest.approx(reference, rel=1e-9)


def test_a_turned_core_holds_as_much_as_a_turned_bed():
    bed = full_lattice(6)
    box = cells([0.23, 0.31, 0.18], [0.9, 0.8, 1.1])
    angle = 0.7
    turn = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    turned = Core(turn @ box.center, box.axes @ turn.T, box.half, "test")
    expected = solid_volume(bed.position, bed.radius, box)
    assert solid_volume(bed.position @ turn.T, bed.radius, turned) == pytest.approx(expected, rel=1e-12)


def test_core_of_the_papers_box_is_its_inner_box():
    core = find_core(full_lattice(), UP, 1.9)
    np.testing.assert_allclose(core.center, [1, 1, 1])
    np.testing.assert_allclose(core.half, [2 / 3] * 3)


def test_core_of_a_box_that_is_half_full_ends_below_the_beds_top():
    core = find_core(full_lattice(), UP, 1.2)
    np.testing.assert_allclose(core.center, [1, 1, 0.6])
    np.testing.assert_allclose(core.half, [2 / 3, 2 / 3, 0.4])


def test_core_follows_gravity_that_points_up():
    bed = make_bed([[1, 1, 1]], 0.1, box_container([0, 0, 0], [2, 2, 2]), gravity=np.array([0.0, 0, 9.81]))
    core = find_core(bed, -UP, -0.8)
    np.testing.assert_allclose(core.center, [1, 1, 1.4])


@pytest.mark.parametrize("kind", ["cone", "mesh"])
def test_core_of_a_silo_keeps_its_distance_from_the_walls(kind):
    surface = revolved_surface([(0, 1.0), (4, 1.0)], 48)
    shape = Cone(np.zeros(3), UP, 4.0, 1.0, 1.0) if kind == "cone" else Mesh(surface)
    position = np.random.default_rng(2).uniform([-0.6, -0.6, 0.1], [0.6, 0.6, 3.0], (400, 3))
    bed = make_bed(position, 0.05, make_container(shape, surface, 4 * np.pi))
    core = find_core(bed, UP, 3.0)
    corner = np.hypot(*core.half[:2])
    assert corner <= 0.8 + 1e-9
    assert core.center[2] + core.half[2] <= 2.8 + 1e-9
    assert core.center[2] - core.half[2] >= 0.2 - 1e-9
    if kind == "cone":
        assert core.volume == pytest.approx(2 * 0.8**2 * 2.6, rel=1e-6)


def test_a_single_sphere_has_no_core_outside_a_box():
    surface = revolved_surface([(0, 1.0), (4, 1.0)], 48)
    bed = make_bed([[0, 0, 0.5]], 0.5, make_container(Cone(np.zeros(3), UP, 4.0, 1.0, 1.0), surface, 12.6))
    assert solid_fraction(bed).core is None


def test_filled_fraction_of_a_lattice_ends_at_the_layer_that_holds_95_percent():
    fraction = solid_fraction(full_lattice())
    # Nine layers and the lower half of the tenth, under a box cut at the tenth layer's centres.
    assert fraction.top == pytest.approx(1.9)
    assert fraction.filled == pytest.approx(np.pi / 6)


def test_a_stray_sphere_high_up_does_not_move_the_top():
    lattice = full_lattice()
    container = box_container([0, 0, 0], [2, 2, 50])
    strayed = make_bed(np.vstack([lattice.position, [1, 1, 49]]), 0.1, container)
    assert solid_fraction(strayed).top == pytest.approx(1.9)


def test_an_empty_bed_has_no_solid():
    fraction = solid_fraction(make_bed(np.empty((0, 3)), 0.1, box_container([0, 0, 0], [1, 1, 1])))
    assert fraction.filled == 0.0
    assert fraction.core is None


def test_a_bed_without_gravity_fills_all_of_its_container():
    container = box_container([0, 0, 0], [2, 2, 2])
    bed = make_bed([[1, 1, 0.5], [0.5, 1, 1.2]], 0.4, container, gravity=np.zeros(3))
    found = solid_fraction(bed)
    assert (found.top, found.filled_volume) == (2.0, 8.0)
    assert found.filled == pytest.approx(2 * 4 / 3 * np.pi * 0.4**3 / 8)
    profile = height_profile(bed)
    assert (profile.height[0], profile.height[-1]) == (0.0, 2.0)
