"""Beds of rigid clumps: what a scene asks for is what the bed has."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.bodies import SINGLE, members_of
from packgen.check import check_bed
from packgen.filling.pack import PackResult, pack

BOX = {"box": {"min": [0, 0, 0], "max": [0.1, 0.1, 0.2]}}
DIMER = {
    "name": "dimer",
    "radius_distribution": "uniform",
    "radius_min": 0.009,
    "radius_max": 0.011,
    "shape": {"dumbbell": {"radius": 0.5, "distance": 0.9}},
}
TRIMER = {
    "name": "trimer",
    "radius_distribution": "constant",
    "radius": 0.01,
    "shape": {"ring": {"radius": 1}, "spheres": 3},
}
SPHERE = {"name": "sphere", "radius_distribution": "constant", "radius": 0.01}


def packed(sets: list, count: int, container: dict = BOX, **keys: object) -> PackResult:
    zones = [{"n_particles": count}]
    return pack({"container": container, "particle_sets": sets, "zones": zones} | keys)


@pytest.fixture(scope="module")
def mixture() -> PackResult:
    return packed([DIMER, TRIMER, SPHERE], 60)


def assert_whole(result: PackResult) -> None:
    """Hold a bed of bodies against the check, and its spheres against their bodies."""
    bed = result.bed
    assert check_bed(bed).within_tolerance
    assert bed.bodies is not None
    position, radius, owner = members_of(bed.bodies)
    apart = position - bed.position
    for axis, period in enumerate(bed.container.period):
        if period is not None:
            apart[:, axis] -= period * np.rint(apart[:, axis] / period)
    assert np.abs(apart).max() < 1e-12
    assert np.array_equal(owner, bed.body_index)
    assert np.abs(radius - bed.radius).max() < 1e-15
    assert np.abs(np.linalg.norm(bed.bodies.orientation, axis=1) - 1.0).max() < 1e-15


def test_clumps_and_spheres_come_to_rest_without_overlap_as_rigid_bodies(mixture):
    assert_whole(mixture)
    assert [(zone.asked, zone.placed) for zone in mixture.zones] == [(60, 60)]
    assert np.bincount(mixture.bed.bodies.template_index + 1).tolist() == [20, 20, 20]


def test_the_law_draws_the_radius_of_the_sphere_of_a_clumps_volume(mixture):
    bodies = mixture.bed.bodies
    size, kind = bodies.equivalent_radius, bodies.template_index
    assert np.allclose(size[kind == 1], 0.01, rtol=1e-12)
    assert np.allclose(size[kind == SINGLE], 0.01, rtol=1e-12)
    assert size[kind == 0].min() >= 0.009
    assert size[kind == 0].max() <= 0.011
    assert np.ptp(size[kind == 0]) > 0.0015
