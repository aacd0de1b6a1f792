"""Claims on the loops of JAMMED: forces by brute force, lists by all pairs, a step of time that is stable."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from packgen.arrange.jammed.meetings import Meetings
from packgen.arrange.jammed.push_kernels import Soft, push, sorted_by_cell
from packgen.arrange.jammed.quench import SoftBed
from packgen.arrange.jammed.quench_kernels import STEP_MAX
from packgen.arrange.space.walls import WallTable
from packgen.compiled import loop
from tests.arrange.dispersed.rooms import room_of

PERIODS = {"walls": (), "x": (0,), "xy": (0, 1), "xyz": (0, 1, 2)}


def region_of(name):
    return room_of(tuple(axis in PERIODS[name] for axis in range(3)), radius=0.2).region


@loop
def forces_and_masses(center, radius, identity, walls: WallTable, grown):
    spheres = Soft(center, np.zeros_like(center), radius, identity)
    near = sorted_by_cell(spheres, grown, walls)
    force = np.empty_like(center)
    contacts, squares, pressure, worst = push(center, near, walls.features, force)
    return force, near.mass, (contacts, squares, pressure, worst)


def found(center, radius, region, grown):
    """Forces, masses and strain in the order given."""
    center, radius, identity = center.copy(), radius.copy(), np.arange(len(radius))
    force, mass, strain = forces_and_masses(center, radius, identity, region.walls, grown)
    back = np.argsort(identity)
    return force[back], mass[back], strain


def overlaps(center, half, wraps):
    """All overlaps by brute force: (sphere, other or -1, sum of radii, overlap)."""
    rows = []
    for shift in product(*((-1, 0, 1) if axis in wraps else (0,) for axis in range(3))):
        way = center[:, None] - center[None] - np.array(shift, float)
        overlap = half[:, None] + half - np.linalg.norm(way, axis=2)
        rows += [
            (i, j, half[i] + half[j], overlap[i, j])
            for i, j in zip(*np.nonzero(overlap > 0), strict=True)
            if i < j
        ]
    for axis in set(range(3)) - set(wraps):
        for gap in (center[:, axis], 1.0 - center[:, axis]):
            rows += [(i, -1, 2.0 * half[i], half[i] - gap[i]) for i in np.flatnonzero(gap < half)]
    return rows


def energy(center, half, wraps):
    return sum(0.5 * apart * overlap**2 for _, _, apart, overlap in overlaps(center, half, wraps))


def crowd(count=60, seed=0, ratio=3.0):
    rng = np.random.default_rng(seed)
    return rng.random((count, 3)), rng.uniform(0.05, 0.05 * ratio, count)


@pytest.mark.parametrize("name", PERIODS)
def test_forces_are_the_slope_of_the_energy(name):
    (center, radius), region, grown = crowd(), region_of(name), 1.1
    force, _, (contacts, squares, pressure, worst) = found(center, radius, region, grown)
    half, wraps, step = grown * radius, PERIODS[name], 1e-6
    for sphere, axis in product(range(0, 60, 7), range(3)):
        there, here = center.copy(), center.copy()
        there[sphere, axis] += step
        here[sphere, axis] -= step
        slope = (energy(there, half, wraps) - energy(here, half, wraps)) / (2.0 * step)
        assert force[sphere, axis] == pytest.approx(-slope, abs=1e-8)
    rows = overlaps(center, half, wraps)
    assert contacts == len(rows)
    assert squares == pytest.approx(sum((apart * each) ** 2 for _, _, apart, each in rows))
    assert pressure == pytest.approx(sum(each * (apart - each) / apart**2 for _, _, apart, each in rows))
    smaller = [min(half[i], half[j]) if j >= 0 else half[i] for i, j, _, _ in rows]
    assert worst == pytest.approx(max(row[3] / size for row, size in zip(rows, smaller, strict=True)))


def test_no_oscillation_is_too_fast_for_the_step_of_time():
    """The largest eigenvalue of springs over masses, of whatever sizes, is at most 2."""
    for seed in range(3):
        center, radius = crowd(seed=seed, ratio=10.0)
        half = 0.7 * radius
        _, mass, _ = found(center, radius, region_of("xyz"), 0.7)
        matrix = np.zeros((180, 180))
        for shift in product((-1, 0, 1), repeat=3):
            way = center[:, None] - center[None] - np.array(shift, float)
            distance = np.linalg.norm(way, axis=2)
            for i, j in zip(*np.nonzero(distance < half[:, None] + half), strict=True):
                if i < j:
                    unit = way[i, j] / distance[i, j]
                    block = (half[i] + half[j]) * np.outer(unit, unit)
                    for a, b, sign in ((i, i, 1), (j, j, 1), (i, j, -1), (j, i, -1)):
                        matrix[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] += sign * block
        scale = 1.0 / np.sqrt(np.repeat(mass, 3))
        fastest = np.linalg.eigvalsh(scale[:, None] * matrix * scale)[-1]
        assert fastest <= 2.0
        assert STEP_MAX * np.sqrt(fastest) < 2.0


def test_two_overlapping_spheres_part_until_they_do_not():
    center = np.array([[0.45, 0.5, 0.5], [0.55, 0.5, 0.52]])
    bed = SoftBed(region_of("walls"), center, np.full(2, 0.1))
    rest = bed.settle(1.0, 1e-3, 1e-6)
    assert rest.pressure == 0.0
    one, other = bed.center
    assert 0.2 * (1.0 - 1e-6) <= np.linalg.norm(one - other) < 0.22
    # Neither has a reason to go anywhere else.
    assert one + other == pytest.approx(center.sum(axis=0))


def test_coincident_spheres_do_not_make_the_bed_infinite():
    bed = SoftBed(region_of("xyz"), np.full((3, 3), 0.5), np.full(3, 0.1))
    bed.settle(1.0, 1e-2, 1e-4)
    assert np.isfinite(bed.center).all()


def test_spheres_keep_their_order_whatever_way_they_are_sorted():
    center, radius = crowd(40)
    bed = SoftBed(region_of("xyz"), center, 0.3 * radius)
    bed.settle(1.0, 1e-2, 1e-4)
    moved = np.abs(bed.center - center)
    assert np.minimum(moved, 1.0 - moved).max() < 0.2


@pytest.mark.parametrize("name", PERIODS)
def test_meetings_are_all_pairs_and_walls_within_a_distance(name):
    (center, radius), region = crowd(40, ratio=2.0), region_of(name)
    near = Meetings.around(center, radius, 0.8, region.walls, 0.05)
    pair, wall = near.gaps(center, 0.8)
    within = overlaps(center, 0.8 * radius + 0.025, PERIODS[name])
    pairs = [(i, j, apart - 0.05 - (apart - each)) for i, j, apart, each in within if j >= 0]
    assert sorted(
        zip(np.minimum(near.first, near.second), np.maximum(near.first, near.second), strict=True)
    ) == (sorted((i, j) for i, j, _ in pairs))
    least = min(
        [1.0 - (each - 0.05) / (apart - 0.05) for _, j, apart, each in within if j >= 0]
        + [
            gap / size / 0.8
            for axis in set(range(3)) - set(PERIODS[name])
            for side in (center[:, axis], 1.0 - center[:, axis])
            for gap, size in zip(side, radius, strict=True)
        ]
    )
    assert near.largest_factor(center) == pytest.approx(0.8 * least)
    assert len(wall) == len(near.sphere)
    assert (wall <= 0.05 / (0.8 * radius[near.sphere]) + 1e-12).all()
    assert (pair * 0.8 * np.minimum(radius[near.first], radius[near.second]) <= 0.05 + 1e-12).all()


@pytest.mark.parametrize("name", PERIODS)
def test_spheres_change_places_only_where_that_lowers_the_energy(name):
    (center, radius), region, grown = crowd(ratio=1.4), region_of(name), 1.2
    bed = SoftBed(region, center, radius)
    before = energy(center, grown * radius, PERIODS[name])
    rng = np.random.default_rng(1)
    changes = bed.exchange(grown**3, rng.random((200, 2)))
    assert changes > 5
    after = energy(bed.center, grown * radius, PERIODS[name])
    assert after < before
    # The places are the same; who is at each is not.
    assert sorted(map(tuple, bed.center)) == sorted(map(tuple, center))
    assert not (bed.center == center).all()


def test_equal_spheres_do_not_change_places():
    center, _ = crowd()
    bed = SoftBed(region_of("xyz"), center, np.full(60, 0.12))
    assert bed.exchange(1.0, np.random.default_rng(0).random((200, 2))) == 0


def test_centres_whole_periods_away_meet_the_same_spheres():
    (center, radius), region = crowd(40, ratio=2.0), region_of("xyz")
    away = center + np.random.default_rng(2).integers(-2, 3, center.shape)
    one, other = (Meetings.around(each, radius, 0.8, region.walls, 0.05) for each in (center, away))
    assert one.separations(center) == pytest.approx(other.separations(away), abs=1e-12)
    assert one.largest_factor(center) == pytest.approx(other.largest_factor(away))
