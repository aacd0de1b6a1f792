"""The worst faults of a bed are named with their spheres and places."""

from __future__ import annotations

import numpy as np

from packgen.bed import EarlierBed
from packgen.check import wall_clearance
from packgen.check.naming import named_faults
from tests.beds import box_container, make_bed


def faults(position, ids=None, **changes):
    bed = make_bed(position, 0.5, box_container((0, 0, 0), (9, 9, 9)), **changes)
    return named_faults(bed, wall_clearance(bed.container, bed.position, bed.radius), ids)


def test_spheres_in_walls_outside_and_in_each_other_are_named_the_deepest_first():
    position = [[4, 4, 4], [4, 4, 4.75], [0.25, 2, 2], [6, 4, 4], [6, 4.9, 4], [-1, 5, 5]]
    assert faults(position) == (
        "sphere 5 at (-1, 5, 5) is outside the container",
        "sphere 2 at (0.25, 2, 2) is in the wall by 0.5 of its radius",
        "sphere 0 at (4, 4, 4) and sphere 1 at (4, 4, 4.75) overlap by 0.5 of the smaller radius",
        "sphere 3 at (6, 4, 4) and sphere 4 at (6, 4.9, 4) overlap by 0.2 of the smaller radius",
    )


def test_ids_of_a_file_stand_beside_the_places():
    assert faults([[4, 4, 4], [4, 4, 4.75]], np.array([17, 4]))[0].startswith(
        "sphere 0 (id 17) at (4, 4, 4) and"
    )


def test_no_more_than_the_tolerance_is_no_fault():
    assert faults([[4, 4, 4], [4, 4, 4.75]], tolerance=0.6) == ()
    assert faults([[4, 4, 4], [4, 4, 4.75]], tolerance=None) == ()


def test_of_very_many_twenty_are_named_and_the_rest_counted():
    rows = np.stack([np.linspace(1, 8, 40), np.full(40, 4.0), np.full(40, 4.0)], axis=1)
    lines = faults(rows)
    assert len(lines) == 21
    count = sum(7 / 39 * (j - i) < 1 for i in range(40) for j in range(i + 1, 40))
    assert lines[-1] == f"and {count - 20} more of these"


def test_spheres_that_were_there_before_are_named_beyond_their_own_limit_only():
    position = [[4, 4, 4], [4, 4, 4.95], [0.45, 2, 2], [6, 4, 4], [6, 4.95, 4], [4, 4, 5.9]]
    zones = np.array([1, 1, 1, 0, 0, 0], np.int32)
    assert sorted(faults(position, zone_index=zones, earlier=EarlierBed(1, 0.2))) == [
        "sphere 1 at (4, 4, 4.95) and sphere 5 at (4, 4, 5.9) overlap by 0.1 of the smaller radius",
        "sphere 3 at (6, 4, 4) and sphere 4 at (6, 4.95, 4) overlap by 0.1 of the smaller radius",
    ]
    assert len(faults(position, zone_index=zones, earlier=EarlierBed(1, 0.05))) == 4
