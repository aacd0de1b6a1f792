from __future__ import annotations

import numpy as np
import pytest

from exporters.shared import contact
from packgen.bed import Material
from packgen.measure import hertz as law
from packgen.validation import predicted_forces
from tests.beds import box_container, make_bed, make_container, revolved_surface
from tests.exporters.beds import RADIUS, lattice


def test_hertz_force_is_that_of_a_measured_contact():
    # r = 2.5 mm, E = 5 MPa, nu = 0.3, overlap 1 % of r: what LIGGGHTS gave for a pair and a wall [N].
    modulus = np.array([law.effective_modulus(*[Material("m", youngs_modulus=5e6)] * 2)])
    overlap = np.array([1e-2 * RADIUS])
    pair_radius = law.effective_radius(np.array([RADIUS]), np.array([RADIUS]))
    assert law.hertz_force(modulus, pair_radius, overlap)[0] == pytest.approx(0.0161883, rel=1e-5)
    assert law.hertz_force(modulus, np.array([RADIUS]), overlap)[0] == pytest.approx(0.0228937, rel=1e-5)


def test_hertz_overlap_undoes_hertz_force():
    modulus, radius, overlap = np.array([1e7, 2e8]), np.array([1e-3, 0.2]), np.array([1e-6, 3e-4])
    assert np.allclose(law.hertz_overlap(modulus, radius, law.hertz_force(modulus, radius, overlap)), overlap)


def test_rayleigh_time_is_the_one_that_the_deck_uses():
    bed = lattice()
    assert law.rayleigh_time(bed) == pytest.approx(contact.smallest_rayleigh_time(bed), rel=1e-12)


def test_predicted_forces_are_those_of_the_planted_overlap():
    bed = lattice(overlap=0.01)
    weight = 2500 * 4 / 3 * np.pi * RADIUS**3 * 9.81
    modulus = 1e8 / (2 * (1 - 0.3**2))
    delta = 0.01 * RADIUS
    forces = predicted_forces(bed)
    assert forces.pair_force_max == pytest.approx(4 / 3 * modulus * np.sqrt(RADIUS / 2) * delta**1.5 / weight)
    assert forces.wall_force_max == pytest.approx(4 / 3 * modulus * np.sqrt(RADIUS) * delta**1.5 / weight)
    assert forces.pair_count == 3 * 4 * 4 * 5 - 4 * 4 - 2 * 4 * 5
    assert forces.outside == 0


def test_predicted_forces_see_a_pair_across_a_periodic_seam():
    container = box_container((0, 0, 0), (8, 4, 4), periodic=(True, False, False))
    forces = predicted_forces(make_bed([[0.5, 2, 2], [7.0, 2, 2]], 1.0, container))
    assert forces.worst_pair is not None
    assert set(forces.worst_pair) == {0, 1}
    assert forces.wall_count == 0


def test_a_centre_outside_is_counted():
    from packgen.geometry import Mesh

    surface = revolved_surface([(0, 2), (4, 2)], 24)
    container = make_container(Mesh(surface), surface, 1.0)
    forces = predicted_forces(make_bed([[0, 0, 2], [2.5, 0, 2]], 1.0, container))
    assert forces.outside == 1
    assert forces.worst_wall_sphere == 1


def test_an_empty_bed_has_no_forces():
    assert predicted_forces(make_bed([], 1.0, box_container((0, 0, 0), (1, 1, 1)))).force_max == 0


def test_spheres_of_one_body_do_not_press_on_each_other():
    container = box_container((0, 0, 0), (20, 5, 5))
    row = [[4, 2, 2], [5, 2, 2], [6.99, 2, 2]]
    forces = predicted_forces(make_bed(row, 1.0, container, body_index=[0, 0, 1]))
    assert forces.pair_count == 1
    assert sorted(forces.worst_pair) == [1, 2]
    assert predicted_forces(make_bed(row, 1.0, container)).pair_count == 2
