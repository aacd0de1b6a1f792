"""How far listed pairs are off the law: told from the bed's own overlaps, with what a solver leaves out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from packgen.validation import predicted_forces
from packgen.validation.contacts import Contacts, pair_error
from tests.beds import box_container, make_bed
from tests.exporters.beds import lattice


def two_pairs(periodic=False):
    """Two pairs that overlap by a hundredth, one of them across the seam where the box wraps around."""
    container = box_container((0, 0, 0), (20, 5, 5), periodic=(periodic, False, False))
    position = [[4, 2, 2], [5.99, 2, 2], [0.5, 2, 2], [18.51, 2, 2]] if periodic else [
        [4, 2, 2], [5.99, 2, 2], [10, 2, 2], [11.99, 2, 2]
    ]  # fmt: skip
    return make_bed(position, 1.0, container)


def listed(bed):
    forces = predicted_forces(bed)
    force = forces.pair_force_max * forces.weight
    return Contacts(np.array([1, 2]), np.array([0, 3]), np.array([force, force]), np.array([0.01, 0.01]))


@pytest.mark.parametrize("periodic", [False, True])
def test_pairs_of_the_law_are_not_off_it(periodic):
    bed = two_pairs(periodic)
    assert pair_error(bed, listed(bed)) < 1e-12


def test_a_force_that_is_off_is_told_whatever_overlap_the_solver_gives():
    bed, pairs = two_pairs(), listed(two_pairs())
    # A solver that read the spheres half a millimetre off is consistent in itself.
    wrong = replace(pairs, force=pairs.force * [1.0, 1.05**1.5], overlap=pairs.overlap * [1.0, 1.05])
    assert pair_error(bed, wrong) == pytest.approx(1.05**1.5 - 1)


def test_a_pair_that_the_solver_does_not_list_is_a_difference():
    bed, pairs = two_pairs(), listed(two_pairs())
    one = Contacts(pairs.first[:1], pairs.second[:1], pairs.force[:1], pairs.overlap[:1])
    none = Contacts(*[each[:0] for each in (pairs.first, pairs.second, pairs.force, pairs.overlap)])
    assert pair_error(bed, one) == pair_error(bed, none) == pytest.approx(1.0)


def test_a_pair_that_the_bed_does_not_have_is_a_difference():
    bed = lattice((2, 2, 2))
    assert pair_error(bed, Contacts(np.array([0]), np.array([7]), np.array([1.0]), np.array([1e-4]))) > 1


def test_a_force_that_is_no_number_is_passed_on():
    bed, pairs = two_pairs(), listed(two_pairs())
    assert np.isnan(pair_error(bed, replace(pairs, force=np.array([np.nan, 1.0]))))
