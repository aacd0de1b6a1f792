from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from packgen.measure import box_fraction, container_fraction, shell_fraction, slab_fraction
from packgen.measure.volumes import sphere_volume
from tests.beds import box_container, cubic_lattice, fcc_lattice, make_bed

Z = np.array([0.0, 0.0, 1.0])
FCC = np.pi / np.sqrt(18.0)


def fcc_bed(count=5, periodic=True):
    edge = count * 2 * np.sqrt(2) * 0.1
    return make_bed(fcc_lattice(count, 0.1), 0.1, box_container([0] * 3, [edge] * 3, (periodic,) * 3))


def random_bed():
    rng = np.random.default_rng(1)
    return make_bed(
        rng.uniform(0.1, 0.9, (200, 3)), rng.uniform(0.01, 0.1, 200), box_container([0] * 3, [1] * 3)
    )


def test_a_periodic_fcc_bed_has_its_fraction_in_cells_slabs_and_as_a_whole():
    bed, edge = fcc_bed(), 2 * np.sqrt(2) * 0.1
    assert container_fraction(bed) == pytest.approx(FCC)
    assert box_fraction(bed, [0, 0, 0], [5 * edge] * 3) == pytest.approx(FCC)
    assert box_fraction(bed, [0.3 * edge] * 3, [1.3 * edge, 2.3 * edge, 3.3 * edge]) == pytest.approx(FCC)
    for axis in np.eye(3):
        assert slab_fraction(bed, axis, 0.0, edge) == pytest.approx(FCC)
        assert slab_fraction(bed, axis, 0.37 * edge, 2.37 * edge) == pytest.approx(FCC)


def test_a_slab_of_a_simple_cubic_bed_has_pi_sixths():
    bed = make_bed(cubic_lattice(5, 0.1), 0.1, box_container([0] * 3, [1] * 3))
    assert slab_fraction(bed, 3 * Z, 0.2, 0.8) == pytest.approx(np.pi / 6)


def test_an_askew_slab_through_a_periodic_bed_is_refused():
    with pytest.raises(ValueError, match="askew"):
        slab_fraction(fcc_bed(), np.array([1.0, 0, 1]), 0.1, 0.5)


def test_shells_and_slabs_together_hold_every_sphere():
    bed = random_bed()
    solid = sphere_volume(bed.radius).sum()
    middle, edges = np.array([0.4, 0.5, 0.0]), [0.0, 0.2, 0.31, 1.2]
    total = 0.0
    for low, high in ((-0.1, 0.45), (0.45, 1.1)):
        for radii in pairwise(edges):
            room = np.pi * (radii[1] ** 2 - radii[0] ** 2) * (high - low)
            total += room * shell_fraction(bed, middle, Z, radii, (low, high))
    assert total == pytest.approx(solid, rel=1e-7)


def test_a_shell_around_one_sphere_is_the_rest_of_its_napkin_ring():
    bed = make_bed([[0.5, 0.5, 0.5]], 0.4, box_container([0] * 3, [1] * 3))
    ring = 4 / 3 * np.pi * (0.4**2 - 0.3**2) ** 1.5
    found = shell_fraction(bed, [0.5, 0.5, 0.0], Z, (0.3, 0.45), (0.0, 1.0))
    assert found == pytest.approx(ring / (np.pi * (0.45**2 - 0.3**2)), rel=1e-9)


@pytest.mark.parametrize(
    "call",
    [
        lambda bed: box_fraction(bed, [0, 0, 0], [1, 1, 0]),
        lambda bed: slab_fraction(bed, Z, 5, 6),
        lambda bed: shell_fraction(bed, [0, 0, 0], Z, (0.2, 0.1), (0, 1)),
    ],
)
def test_a_region_without_volume_is_refused(call):
    with pytest.raises(ValueError, match="volume"):
        call(random_bed())
