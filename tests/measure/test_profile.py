from __future__ import annotations

import numpy as np
import pytest

from packgen.measure import contacts_and_gaps, height_profile, solid_fraction
from packgen.measure.volumes import sphere_volume
from tests.beds import box_container, cubic_lattice, make_bed


def test_the_slabs_of_a_simple_cubic_bed_have_pi_sixths():
    profile = height_profile(make_bed(cubic_lattice(10, 0.05), 0.05, box_container([0, 0, 0], [1, 1, 1])))
    assert profile.height == pytest.approx(np.linspace(0.0, 1.0, 11))
    assert profile.solid_fraction == pytest.approx([np.pi / 6] * 10)


def test_the_slabs_together_hold_every_sphere():
    rng = np.random.default_rng(1)
    radius = rng.uniform(0.01, 0.1, 200)
    position = rng.uniform(0.1, 0.9, (200, 3))
    profile = height_profile(make_bed(position, radius, box_container([0, 0, 0], [1, 1, 1])))
    solid = sum(
        part * thick for part, thick in zip(profile.solid_fraction, np.diff(profile.height), strict=True)
    )
    assert solid == pytest.approx(sphere_volume(radius).sum())


def test_gaps_and_contacts_count_the_same_pairs():
    rng = np.random.default_rng(2)
    bed = make_bed(rng.uniform(0.1, 0.9, (300, 3)), 0.05, box_container([0, 0, 0], [1, 1, 1]))
    found, gaps = contacts_and_gaps(bed)
    for entry in found:
        pairs = sum(number for edge, number in zip(gaps.edge, gaps.count, strict=True) if edge <= entry.gap)
        assert entry.mean == pytest.approx(2 * pairs / bed.count)
        assert sum(entry.spread) == bed.count
        assert sum(number * spheres for number, spheres in enumerate(entry.spread)) == 2 * pairs


def test_the_profile_of_an_endless_bed_holds_all_its_spheres_and_has_no_surface():
    rng = np.random.default_rng(0)
    radius = rng.uniform(0.1, 0.5, 40)
    container = box_container((-1, 2, -3), (2, 5, 1), (True, False, True))
    bed = make_bed([-1, 2, -3] + rng.random((40, 3)) * [3, 3, 4], radius, container)
    solid = 4.0 / 3.0 * np.pi * float((radius**3).sum())
    profile = height_profile(bed)
    assert (profile.height[0], profile.height[-1]) == (-3.0, 1.0)
    parts = np.array(profile.solid_fraction) * np.diff(profile.height) * 9.0
    assert parts.sum() == pytest.approx(solid, rel=1e-12)
    found = solid_fraction(bed)
    assert found.top == 1.0
    assert found.filled == pytest.approx(solid / container.volume, rel=1e-12)


@pytest.mark.parametrize("tilt", [1e-13, 1e-9, 1e-7, 1.1e-6, 1e-5, 1e-3, 0.1, 1.0])
@pytest.mark.parametrize("periodic", [(True, False, True), (True, True, True), (False, True, True)])
def test_gravity_slightly_askew_to_periodic_axes_gives_a_profile_or_none(periodic, tilt):
    container = box_container((0, 0, 0), (2, 2, 2), periodic)
    for gravity in ([tilt, 0, -1], [0, tilt, -1], [tilt, tilt, -1]):
        bed = make_bed([[1, 1, 0.5]], 0.4, container, gravity=9.81 * np.array(gravity))
        profile = height_profile(bed)
        assert len(profile.height) in (0, len(profile.solid_fraction) + 1)
