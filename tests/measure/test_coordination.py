from __future__ import annotations

import numpy as np
import pytest

from packgen.check import wall_clearance
from packgen.geometry import Mesh
from packgen.measure.coordination import GAPS_A_DECADE, coordination, plateau
from tests.beds import box_container, box_surface, cubic_lattice, fcc_lattice, make_bed, make_container

CLOSED = (True, True, True)


def measured(bed):
    return coordination(bed, wall_clearance(bed.container, bed.position, 2.0 * bed.radius))


def crystal(gap=1e-5, **changes):
    edge = 3 * 2.0 * np.sqrt(2.0) * 0.1
    container = box_container([0, 0, 0], [edge] * 3, CLOSED)
    radius = 0.1 * 2.0 / (2.0 + gap)
    return make_bed(fcc_lattice(3, 0.1), radius, container, gravity=np.zeros(3), **changes)


def test_a_crystals_plateau_begins_at_its_gap_and_ends_before_the_next_neighbours():
    found = measured(crystal())
    assert found.plateau == 12.0
    assert found.plateau_low == pytest.approx(10 ** (-5 + 1 / GAPS_A_DECADE), rel=0.35)
    assert found.plateau_high == pytest.approx(0.1)
    assert found.rattlers == 0.0
    assert found.plateau_held == 12.0
    assert found.mean[0] == 0.0
    assert found.gap[0] == pytest.approx(1e-8)


def test_spheres_that_overlap_touch_at_every_gap():
    found = measured(crystal(gap=-1e-3))
    assert set(found.mean) == {12.0}


def test_walls_are_counted_each():
    bed = make_bed(cubic_lattice(3, 0.1), 0.1 * (1 - 1e-7), box_container([0, 0, 0], [0.6] * 3))
    assert measured(bed).plateau == 6.0


def test_a_mesh_is_one_wall():
    surface = box_surface([0, 0, 0], [0.6] * 3)
    mesh = make_container(Mesh(surface), surface, 0.216)
    bed = make_bed(cubic_lattice(3, 0.1), 0.1 * (1 - 1e-7), mesh)
    assert measured(bed).plateau == pytest.approx((2 * 54 + 26) / 27)


def test_spheres_far_apart_have_no_plateau():
    bed = make_bed(cubic_lattice(4, 0.1), 0.08, box_container([0, 0, 0], [0.8] * 3, CLOSED))
    found = measured(bed)
    assert found.plateau is None
    assert found.rattlers is None
    assert found.plateau_held is None
    assert set(found.mean) == {0.0}


def test_contacts_that_grow_steadily_have_no_plateau_and_the_widest_one_counts():
    assert plateau(np.linspace(3.0, 12.0, 57)) is None
    steps = np.repeat([0.0, 3.5, 4.5, 6.0, 8.0], [10, 5, 20, 12, 10])
    assert plateau(steps) == (15, 34)
    assert plateau(np.repeat([0.0, 2.9, 5.0], [20, 34, 3])) is None


def test_rattlers_are_taken_out_one_after_the_other_under_gravity():
    # A crystal on its floor; on it a sphere that leans on one other, and one that leans on this one.
    bed = crystal()
    low, high = bed.container.bounds
    container = box_container(
        [low[0], low[1], 0.25 * high[2] / 3 - 0.1], [high[0], high[1], 9.0], (*CLOSED[:2], False)
    )
    top = bed.position[bed.position[:, 2].argmax()]
    lean = np.array([0.6, 0.0, 0.8]) * 0.2
    position = np.concatenate([bed.position, [top + lean, top + 2 * lean]])
    pile = make_bed(position, bed.radius[0], container)
    assert measured(pile).rattlers == pytest.approx(2 / 110)
    assert measured(make_bed(position[:-1], bed.radius[0], container)).rattlers == pytest.approx(1 / 109)


def test_without_gravity_four_contacts_are_needed():
    bed = crystal()
    middle = bed.container.bounds.mean(axis=0)
    place = int(np.linalg.norm(bed.position - middle, axis=1).argmin())
    neighbours = np.flatnonzero(np.linalg.norm(bed.position - bed.position[place], axis=1) < 0.21)
    gone = neighbours[neighbours != place][:9]  # three of twelve are left to the sphere in the middle
    kept = np.setdiff1d(np.arange(bed.count), gone)
    loose = make_bed(bed.position[kept], bed.radius[0], bed.container, gravity=np.zeros(3))
    assert measured(loose).rattlers == pytest.approx(1 / len(kept))


def test_an_empty_bed_has_none():
    assert measured(make_bed(np.empty((0, 3)), 0.1, box_container([0, 0, 0], [1, 1, 1]))) is None
