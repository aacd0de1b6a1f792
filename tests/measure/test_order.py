from __future__ import annotations

import numpy as np
import pytest

from packgen.measure import contacts, core_of, crystal_bonds, local_order, pair_correlation
from packgen.measure.core import Core
from tests.beds import box_container, cubic_lattice, fcc_lattice, make_bed

EDGE = 2 * np.sqrt(2)  # of fcc's cell, in radii


def fcc_bed(count=8):
    side = count * EDGE
    return make_bed(fcc_lattice(count, 1.0), 1.0, box_container([0] * 3, [side] * 3, (True,) * 3))


def gas_bed(count=20_000):
    position = np.random.default_rng(3).uniform(0, 1, (count, 3))
    return make_bed(position, 0.005, box_container([0] * 3, [1] * 3))


def cube(middle, half):
    return Core(np.full(3, middle), np.eye(3), np.full(3, half), "test")


def test_shells_of_fcc_hold_twelve_six_twenty_four_and_twelve():
    half = 4 * EDGE
    found = pair_correlation(fcc_bed(), cube(half, half), reach=2.1, step=0.05)
    count = 4 * 8**3
    shell = 4 / 3 * np.pi * np.diff((np.append(0.025, np.array(found.distance) + 0.025) * 2.0) ** 3)
    neighbours = np.array(found.g) * shell * (count - 1) / (8 * EDGE) ** 3
    near = {round(each, 2): number for each, number in zip(found.distance, neighbours, strict=True) if number}
    assert list(near) == pytest.approx([1.0, 1.4, 1.75, 2.0])
    assert list(near.values()) == pytest.approx([12, 6, 24, 12], rel=2e-3)


def test_random_points_have_no_correlation_though_the_core_has_faces():
    found = pair_correlation(gas_bed(), cube(0.5, 0.25), reach=20.0, step=1.0)
    g = np.array(found.g)
    assert np.abs(g[5:] - 1.0).max() < 0.05
    assert np.average(g, weights=np.array(found.distance) ** 2) == pytest.approx(1.0, abs=0.02)


def test_without_a_core_there_is_no_correlation():
    assert pair_correlation(gas_bed(100), None) is None
    assert pair_correlation(gas_bed(100), cube(0.5, 0.006)) is None


def test_fcc_is_all_crystal_with_twelve_bonds_and_twelve_contacts():
    bed = fcc_bed(4)
    assert set(crystal_bonds(bed).tolist()) == {12}
    found = local_order(bed, cube(2 * EDGE, EDGE))
    assert (found.crystal, found.crystal_core, found.crystal_wall) == (1.0, 1.0, None)
    (touching,) = contacts(bed, [1e-6])
    assert (touching.mean, touching.rattlers) == (12.0, 0.0)


def test_a_crystal_is_one_however_it_is_turned():
    bed = fcc_bed(4)
    turn, _ = np.linalg.qr(np.random.default_rng(5).normal(size=(3, 3)))
    free = box_container([-99] * 3, [99] * 3)
    plain = crystal_bonds(make_bed(bed.position, 1.0, free))
    turned = crystal_bonds(make_bed(bed.position @ turn.T, 1.0, free))
    np.testing.assert_array_equal(plain, turned)
    assert plain.max() == 12


def test_spheres_in_one_place_bond_by_their_other_neighbours():
    centres = cubic_lattice(3, 0.1)
    bed = make_bed([*centres, centres[0]], 0.1, box_container([0, 0, 0], [0.6, 0.6, 0.6]))
    with np.errstate(all="raise"):
        bonds = crystal_bonds(bed)
    assert bonds[13] == crystal_bonds(make_bed(centres, 0.1, bed.container))[13]


def test_a_dense_gas_is_no_crystal():
    position = np.random.default_rng(6).uniform(0, 1, (3000, 3))
    found = local_order(make_bed(position, 0.05, box_container([0] * 3, [1] * 3)), cube(0.5, 0.3))
    assert found.crystal < 0.01
    assert found.crystal_wall is not None
    assert sum(found.bonds) == 3000


def test_a_crystal_along_a_wall_is_told_from_the_core():
    rng = np.random.default_rng(7)
    lattice = fcc_lattice(3, 0.05) * [1, 1, 1]
    side = 3 * EDGE * 0.05
    loose = rng.uniform([0, 0, side + 0.3], [side, side, 2.0], (100, 3))
    bed = make_bed(np.vstack([lattice, loose]), 0.05, box_container([0] * 3, [side, side, 2.1]))
    found = local_order(bed, Core(np.array([side / 2, side / 2, 1.4]), np.eye(3), np.full(3, 0.2), "test"))
    assert found.crystal_core < 0.05
    assert found.crystal > 0.15


def test_spheres_with_less_than_four_contacts_are_rattlers():
    lattice = make_bed(cubic_lattice(3, 0.1), 0.1, box_container([0] * 3, [0.6] * 3))
    # A corner sphere touches three others, and walls, which count as one: held.
    assert contacts(lattice, [1e-6])[0].rattlers == 0.0
    free = make_bed(cubic_lattice(3, 0.1), 0.1, box_container([-1] * 3, [2] * 3))
    assert contacts(free, [1e-6])[0].rattlers == pytest.approx(8 / 27)


def test_the_core_of_a_bed_is_the_one_of_its_solid_fraction():
    core = core_of(make_bed(cubic_lattice(10, 0.1), 0.1, box_container([0] * 3, [2] * 3)))
    np.testing.assert_allclose(core.half[:2], 2 / 3)
    assert core_of(make_bed(np.empty((0, 3)), 0.1, box_container([0] * 3, [1] * 3))) is None
