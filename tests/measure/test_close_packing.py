"""A bed beside the random close packing of its sizes, and what its walls are expected to cost it."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.geometry import Cone
from packgen.measure import close_packing, solid_fraction
from packgen.measure.volumes import wall_area_below
from packgen.supply.close_packing import EQUAL_SPHERES, close_packing_fraction, wall_loss
from tests.beds import box_container, cubic_lattice, make_bed, make_container, revolved_surface

UP = np.array([0.0, 0.0, 1.0])


def packing_of(bed):
    return close_packing(bed, solid_fraction(bed))


def test_equal_spheres_are_compared_with_random_close_packing_of_equal_spheres():
    bed = make_bed(cubic_lattice(5, 0.1), 0.1, box_container([0, 0, 0], [1, 1, 1]))
    packing = packing_of(bed)
    assert packing.fraction == EQUAL_SPHERES
    assert packing.of == "core"
    assert packing.reached == pytest.approx(solid_fraction(bed).core / EQUAL_SPHERES)


def test_a_bed_is_compared_with_its_own_radii_and_by_its_filled_volume_where_it_has_no_core():
    tube = make_container(
        Cone(np.zeros(3), UP, 4.0, 1.0, 1.0), revolved_surface([(0, 1.0), (4, 1.0)], 48), 4.0 * np.pi
    )
    bed = make_bed([[0, 0, 0.9], [0, 0, 2.3]], np.array([0.9, 0.5]), tube)
    packing, solid = packing_of(bed), solid_fraction(bed)
    assert solid.core is None
    assert packing.of == "filled"
    assert packing.fraction == close_packing_fraction(bed.radius)
    assert packing.reached == pytest.approx(solid.filled / packing.fraction)


def test_a_bed_without_spheres_has_none():
    assert packing_of(make_bed(np.empty((0, 3)), 0.1, box_container([0, 0, 0], [1, 1, 1]))) is None


def test_walls_count_up_to_the_level_and_periodic_sides_not_at_all():
    low, high = [0.0, 0.0, 0.0], [2.0, 3.0, 4.0]
    assert wall_area_below(box_container(low, high), UP, 1.0) == pytest.approx(6.0 + 10.0)
    assert wall_area_below(box_container(low, high), UP, 4.0) == pytest.approx(12.0 + 40.0)
    along_x = box_container(low, high, periodic=(True, False, False))
    assert wall_area_below(along_x, UP, 1.0) == pytest.approx(6.0 + 4.0)
    endless = box_container(low, high, periodic=(True, True, True))
    assert wall_area_below(endless, UP, 4.0) == 0.0


def test_the_walls_loss_is_proportional_to_their_area_until_they_put_spheres_in_order():
    assert wall_loss(0.0, 1.0, 0.1) == 0.0
    assert wall_loss(2.0, 1.0, 0.1) == pytest.approx(2.0 * wall_loss(1.0, 1.0, 0.1))
    assert wall_loss(2.0, 2.0, 0.1) == pytest.approx(wall_loss(1.0, 1.0, 0.1))
    assert wall_loss(1e3, 1.0, 1.0) == wall_loss(1e6, 1.0, 1.0) < 0.5
