"""The check of rigid bodies: spheres stand where their bodies have them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from packgen.check import check_bed
from tests.clump_beds import lattice_of_clumps


@pytest.mark.parametrize("periodic", [(False,) * 3, (True, False, True)], ids=["box", "seam"])
def test_bodies_made_whole_pass_and_their_overlaps_are_no_faults(periodic):
    found = check_bed(lattice_of_clumps(singles=True, periodic=periodic))
    assert found.within_tolerance
    assert (found.bodies.body_count, found.bodies.clump_count) == (27, 18)
    assert found.bodies.place_error_max < 1e-12
    assert found.bodies.misplaced_count == 0


def test_a_sphere_that_left_its_body_is_a_fault_that_names_the_body():
    bed = lattice_of_clumps()
    position = bed.position.copy()
    position[3] += 1e-7
    found = check_bed(replace(bed, position=position))
    assert found.bodies.misplaced_count == 1
    assert found.bodies.worst_body == bed.body_index[3]
    assert any("1 body has spheres that stand elsewhere, worst body 1" in line for line in found.faults())


@pytest.mark.parametrize("name", ["orientation", "scale"])
def test_a_body_that_turned_or_grew_without_its_spheres_is_a_fault(name):
    bed = lattice_of_clumps()
    values = np.array(getattr(bed.bodies, name))
    values[7] *= -1.0000001 if name == "orientation" else 1.0000001
    found = check_bed(replace(bed, bodies=replace(bed.bodies, **{name: values})))
    assert (found.bodies.misplaced_count, found.bodies.worst_body) == (1, 7)


def test_beds_without_bodies_have_no_such_check():
    bed = lattice_of_clumps()
    assert check_bed(replace(bed, bodies=None)).bodies is None
