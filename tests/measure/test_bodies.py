"""Beds with clumps: a clump counts, weighs and touches as one, and its overlaps fill space once."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from packgen.bodies import SINGLE, Bodies
from packgen.check import wall_clearance
from packgen.measure import (
    box_fraction,
    container_fraction,
    height_profile,
    pair_correlation,
    slab_fraction,
    solid_fraction,
)
from packgen.measure.bodies import body_contacts, body_measures
from packgen.measure.hertz import mean_radius, mean_weight, sphere_mass
from packgen.measure.particles import as_particles, in_grains
from packgen.report import build_report
from tests.beds import box_container
from tests.clump_beds import bed_of, bent, lattice_of_clumps, pair

BED = lattice_of_clumps((4, 4, 4), singles=True)


def in_union(bed, points):
    """Which points are inside some sphere."""
    inside = np.zeros(len(points), bool)
    for place, radius in zip(bed.position, bed.radius, strict=True):
        inside |= ((points - place) ** 2).sum(axis=1) < radius**2
    return inside


def test_space_is_counted_once_as_points_in_the_union_have_it():
    low, high = np.array([0.005, 0.01, 0.0]), np.array([0.06, 0.09, 0.07])
    points = low + np.random.default_rng(1).random((200_000, 3)) * (high - low)
    share = in_union(BED, points).mean()
    assert box_fraction(BED, low, high) == pytest.approx(share, abs=4 * np.sqrt(share / len(points)) + 0.002)
    whole = BED.bodies.volume.sum() / BED.container.volume
    assert container_fraction(BED) == pytest.approx(whole)
    assert slab_fraction(BED, np.array([0.0, 0, 1]), 0.0, 0.104) == pytest.approx(whole)


def test_grains_have_each_bodys_volume_and_centre():
    grains = in_grains(BED)
    assert (4 / 3 * np.pi * grains.radius**3).sum() == pytest.approx(BED.bodies.volume.sum())
    weight = grains.radius**3
    expected = BED.bodies.volume @ BED.bodies.position / BED.bodies.volume.sum()
    assert np.abs(weight @ grains.position / weight.sum() - expected).max() < 1e-15


def test_the_profile_has_all_the_solid_volume():
    profile = height_profile(BED)
    step = np.diff(profile.height) * 0.104**2
    assert step @ np.array(profile.solid_fraction) == pytest.approx(BED.bodies.volume.sum())


def test_weights_and_sizes_are_those_of_particles():
    mass = 2500 * BED.bodies.volume
    assert sphere_mass(BED).sum() == pytest.approx(mass.sum())
    assert mean_weight(BED) == pytest.approx(9.81 * mass.mean())
    assert mean_radius(BED) == pytest.approx(BED.bodies.equivalent_radius.mean())
    assert as_particles(BED).count == 64


def test_two_bodies_have_one_contact_however_many_of_their_spheres_touch():
    # Two pairs side by side touch by two spheres each, and stand on the floor; a third stands apart.
    place = [[0.01, 0.005, 0.005], [0.01, 0.015, 0.005], [0.01, 0.035, 0.006]]
    flat = Bodies(
        (pair(),), np.zeros(3, np.int32), np.ones(3), np.array(place), np.tile([1.0, 0, 0, 0], (3, 1))
    )
    bed = bed_of(flat, box_container([0, 0, 0], [0.02, 0.05, 0.05]))
    clearance = wall_clearance(bed.container, bed.position, 2 * bed.radius)
    found, gaps = body_contacts(bed, clearance, (0.001, 0.05))
    assert [each.mean for each in found] == [pytest.approx(2 / 3)] * 2
    assert found[0].spread == (1, 2)
    assert found[0].wall_mean == pytest.approx(2 / 3)
    assert found[0].none == pytest.approx(1 / 3)
    assert sum(gaps.count) == 1


def test_orientations_are_told_by_the_axis_unlike_the_others():
    lying = Bodies(
        (pair(), bent()),
        np.zeros(50, np.int32),
        np.ones(50),
        np.zeros((50, 3)),
        np.tile([1.0, 0, 0, 0], (50, 1)),
    )
    bed = bed_of(lying, box_container([0, 0, 0], [0.02, 0.05, 0.05]))
    shape = body_measures(bed).shapes[0]
    assert (shape.axis, shape.count, shape.spheres) == ("longest", 50, 2)
    assert shape.order == pytest.approx(1.0)
    assert shape.director == pytest.approx((1.0, 0.0, 0.0))
    assert shape.angle_to_gravity == pytest.approx(90.0)
    assert shape.mass == pytest.approx(2500 * bed.bodies.volume.sum())
    turned = body_measures(lattice_of_clumps((8, 8, 8))).shapes
    assert [each.name for each in turned] == ["pair", "bent"]
    for each in turned:  # of 256 random axes
        assert each.order < 4 / np.sqrt(256)
        assert each.angle_to_gravity == pytest.approx(57.3, abs=5 * 21.6 / np.sqrt(256))


def test_the_report_counts_particles_and_spheres():
    report = build_report(BED)
    rows = dict(report.rows())
    clumps = int((BED.bodies.template_index != SINGLE).sum())
    assert rows["particles"] == f"64: {clumps} clumps, {64 - clumps} single spheres"
    assert rows["spheres of all"] == str(BED.count)
    assert "contacts a particle at gaps of 0% / 0.1% / 1% / 5%" in rows
    assert report.sets[0].mass == pytest.approx(2500 * BED.bodies.volume.sum())
    assert report.sets[0].count == 64
    assert report.coordination is None
    assert report.close_packing is None
    assert report.overlap.bodies.clump_count == clumps
    assert build_report(replace(BED, bodies=None, body_index=None)).bodies is None


def test_measures_of_centres_are_those_of_particles():
    solid = solid_fraction(BED)
    assert 0.0 < solid.filled < 0.2
    assert pair_correlation(BED, None) is None
