from __future__ import annotations

import numpy as np
import pytest

from packgen.measure import contacts
from tests.beds import box_container, cubic_lattice, make_bed


def test_spheres_of_a_periodic_lattice_have_six_contacts():
    container = box_container([0, 0, 0], [0.8] * 3, (True, True, True))
    narrow, *_, wide = contacts(make_bed(cubic_lattice(4, 0.1), 0.1 * (1 - 1e-9), container))
    assert narrow.mean == 0.0
    assert narrow.none == 1.0
    assert wide.mean == 6.0
    assert wide.wall_mean == 0.0


@pytest.mark.parametrize(
    ("gap", "expected"), [(0.0005, [0, 1, 1, 1]), (0.005, [0, 0, 1, 1]), (0.03, [0, 0, 0, 1])]
)
def test_a_gap_is_a_contact_up_to_its_class(gap, expected):
    container = box_container([-9, -9, -9], [9, 9, 9])
    bed = make_bed([[0, 0, 0], [0, 0, 3 + gap]], [1.0, 2.0], container)
    assert [entry.mean for entry in contacts(bed)] == expected


def test_walls_are_counted_apart():
    bed = make_bed(cubic_lattice(3, 0.1), 0.1, box_container([0, 0, 0], [0.6] * 3))
    assert contacts(bed)[2].wall_mean == pytest.approx(26 / 27)
    assert contacts(bed)[2].mean == pytest.approx(2 * 54 / 27)


def test_an_empty_bed_has_no_contacts():
    empty = make_bed(np.empty((0, 3)), 0.1, box_container([0, 0, 0], [1, 1, 1]))
    assert [entry.mean for entry in contacts(empty)] == [0, 0, 0, 0]


def test_spheres_of_one_body_are_not_in_contact_with_each_other():
    container = box_container([-9, -9, -9], [9, 9, 9])
    row = [[0, 0, 0], [0, 0, 1.5], [0, 0, 3.5]]
    touching = contacts(make_bed(row, 1.0, container, body_index=[0, 0, 1]))[0]
    assert touching.mean == pytest.approx(2 / 3)
    assert touching.spread == (1, 2)
    assert contacts(make_bed(row, 1.0, container))[0].mean == pytest.approx(4 / 3)
