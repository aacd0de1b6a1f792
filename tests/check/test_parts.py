"""Faults in walls, and walls in measures, know the named parts of walls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from packgen.bed import EarlierBed, pair_coefficient
from packgen.check import check_bed, wall_clearance
from packgen.check.naming import named_faults
from packgen.check.parts import nearest_part, nearest_part_name
from packgen.measure.forces import predicted_forces
from packgen.measure.structure import structure_of
from packgen.validation.contacts import Contacts, listed_error
from tests.beds import make_bed
from tests.exporters.walls.test_parts import MATERIALS, gated

RADIUS = 0.01


def bed_at(x, **keys):
    return make_bed([[x, 0.05, 0.05]], RADIUS, gated(**keys), materials=MATERIALS)


def test_the_part_nearest_to_a_point_is_found_within_reach():
    container = gated()
    points = np.array([[0.105, 0.05, 0.1], [0.39, 0.05, 0.1], [0.2, 0.05, 0.1], [0.1, 0.05, 0.01]])
    reach = np.array([0.01, 0.02, 0.01, 0.05])
    assert nearest_part(container, points, reach).tolist() == [0, -1, -1, 0]
    assert nearest_part_name(container, points[0], 0.01) == "gate.1"
    assert nearest_part_name(container, points[1], 0.02) is None
    assert nearest_part(replace(container, parts=()), points, reach).tolist() == [-1] * 4


def test_a_sphere_in_a_part_is_told_with_the_parts_name():
    bed = bed_at(0.109)
    check = check_bed(bed)
    assert check.worst_wall_part == "gate.1"
    assert check.faults() == ("sphere 0 is in the wall gate.1 by 0.1 of its radius, tolerance 1e-06",)
    clearance = wall_clearance(bed.container, bed.position, bed.radius)
    (line,) = named_faults(bed, clearance)
    assert line.endswith("is in the wall gate.1 by 0.1 of its radius")


def test_new_and_earlier_spheres_in_a_part_are_told_with_the_parts_name():
    beside = make_bed(
        [[0.109, 0.05, 0.05], [0.106, 0.05, 0.12]], RADIUS, gated(), zone_index=np.array([0, 1], np.int32),
        earlier=EarlierBed(1, 0.2),
    )  # fmt: skip
    assert check_bed(beside).new.worst_wall_part == "gate.1"
    assert check_bed(beside).faults() == (
        "sphere 0 is in the wall gate.1 by 0.1 of its radius, tolerance 1e-06",
        "sphere 1, which was there before, is in the wall gate.1 by 0.4 of its radius, limit 0.2",
    )


def test_a_sphere_in_the_rest_of_the_walls_is_told_as_ever():
    check = check_bed(bed_at(0.391))
    assert check.worst_wall_part is None
    assert check.faults() == ("sphere 0 is in the wall by 0.1 of its radius, tolerance 1e-06",)


def test_forces_at_a_part_are_those_of_its_material():
    like = predicted_forces(bed_at(0.109)).wall_force_max
    soft = predicted_forces(bed_at(0.109, material="rubber")).wall_force_max
    assert soft / like == pytest.approx(2 / (1 + 1e8 / 2e7))
    assert predicted_forces(bed_at(0.391, material="rubber")).wall_force_max == pytest.approx(like)


def test_friction_at_a_part_is_that_of_its_material():
    for x, friction in ((0.11, pair_coefficient(0.5, 0.9)), (0.39, 0.5)):
        bed = bed_at(x, material="rubber")
        assert structure_of(bed, 1e-3).friction.tolist() == [pytest.approx(friction)]


def test_contacts_that_a_solver_lists_at_a_part_follow_its_material():
    bed = bed_at(0.109, material="rubber")
    modulus = 1 / (0.91 / 1e8 + 0.91 / 2e7)
    force = 4 / 3 * modulus * np.sqrt(RADIUS) * 0.001**1.5
    for part, right in ((0, True), (-1, False)):
        walls = Contacts(np.array([0]), None, np.array([force]), np.array([0.001]), np.array([part]))
        assert (listed_error(bed, walls) < 1e-9) is right
