"""Claims on the best arrangements: radii known to ten digits, choices, bounds that hold, and containers."""

from __future__ import annotations

import math
import time

import numpy as np
import pytest
import trimesh

from packgen.arrange.optimal import proof
from packgen.arrange.optimal.bounds import inner_radius, pair_factor, possible_sets, scale_bound
from packgen.arrange.optimal.chain import chain, start
from packgen.arrange.optimal.choose import search, volume_bound
from packgen.arrange.optimal.descend import descend, largest_factor
from packgen.arrange.optimal.press_kernels import push
from packgen.arrange.optimal.room import Room
from packgen.geometry import Ball, Cone, Polyhedron, Surface
from tests.beds import box_container, make_container

CUBE = {1: 0.5, 2: 0.3169872981, 3: 0.2928932188, 4: 0.2928932188, 5: 0.2639320225, 6: 0.2573593129, 8: 0.25}
CUBE_SLOW = {7: 0.2501361539, 9: 0.2320508076, 10: 0.2142857143, 13: 0.2071067812}
SPHERE = {
    1: 1.0, 2: 0.5, 3: 2.0 * math.sqrt(3.0) - 3.0, 4: math.sqrt(6.0) - 2.0, 5: math.sqrt(2.0) - 1.0,
    6: math.sqrt(2.0) - 1.0,
}  # fmt: skip
SPHERE_SLOW = {7: 0.3859135574, 8: 0.3780248448, 9: (math.sqrt(3.0) - 1.0) / 2.0, 11: 0.3445765168}
LATER = 1.0e6


def unit_cube() -> Room:
    return Room.of(box_container([0, 0, 0], [1, 1, 1]))


def unit_sphere() -> Room:
    ball = Ball(np.zeros(3), 1.0)
    mesh = trimesh.creation.icosphere()
    surface = Surface(mesh.vertices, mesh.faces)
    return Room.of(make_container(ball, surface, 4.0 / 3.0 * math.pi))


def tetrahedron() -> Room:
    mesh = trimesh.Trimesh([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]).convex_hull
    normal = np.array([[-1, -1, -1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]]) / math.sqrt(3.0)
    shape = Polyhedron(
        np.concatenate([normal, normal]),  # a facet twice is one wall
        np.full(8, 1.0 / math.sqrt(3.0)),
        Surface(mesh.vertices, mesh.faces),
    )
    return Room.of(make_container(shape, shape.surface, 8.0 / 3.0))


def best_factor(room, radius, starts, seed=0):
    until = time.time() + LATER
    seeds = np.random.SeedSequence(seed).spawn(starts)
    return max(chain(room, radius, k, each, until).placed.factor for k, each in enumerate(seeds))


@pytest.mark.parametrize("count", CUBE)
def test_equal_spheres_in_a_cube_have_the_radius_known(count):
    # 17 of 20 starts of four spheres lead there, and all of 20 of other numbers.
    found = 0.1 * best_factor(unit_cube(), np.full(count, 0.1), 4 if count == 4 else 2)
    assert found == pytest.approx(CUBE[count], abs=1e-9)


@pytest.mark.parametrize("count", SPHERE)
def test_equal_spheres_in_a_sphere_have_the_radius_of_the_closed_form(count):
    # To 1e-8 do 16 of 20 starts of one sphere and all of 20 of more.
    found = 0.1 * best_factor(unit_sphere(), np.full(count, 0.1), 5 if count == 1 else 2)
    assert found == pytest.approx(SPHERE[count], abs=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("count", CUBE_SLOW)
def test_more_spheres_in_a_cube_have_the_radius_known(count):
    assert 0.1 * best_factor(unit_cube(), np.full(count, 0.1), 6) == pytest.approx(CUBE_SLOW[count], abs=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("count", SPHERE_SLOW)
def test_more_spheres_in_a_sphere_have_the_radius_known(count):
    found = 0.1 * best_factor(unit_sphere(), np.full(count, 0.1), 6)
    assert found == pytest.approx(SPHERE_SLOW[count], abs=1e-9)


def test_four_spheres_in_a_tetrahedron_lie_at_its_corners():
    room = tetrahedron()
    assert len(room.offset) == 4
    # Edge L = 2 sqrt(2): centres make a tetrahedron of edge 2 r around which the walls are r away.
    radius = 2.0 * math.sqrt(2.0) / (2.0 + 2.0 * math.sqrt(6.0))
    assert 0.1 * best_factor(room, np.full(4, 0.1), 2) == pytest.approx(radius, abs=1e-9)
    assert inner_radius(room) == pytest.approx(1.0 / math.sqrt(3.0), abs=1e-9)


def test_only_boxes_balls_and_convex_polyhedra_are_rooms():
    cone = Cone(np.zeros(3), np.array([0.0, 0, 1]), 1.0, 0.5, 0.5)
    mesh = trimesh.creation.cylinder(0.5, 1.0)
    assert Room.of(make_container(cone, Surface(mesh.vertices, mesh.faces), 0.785)) is None
    assert Room.of(box_container([0, 0, 0], [1, 1, 1], periodic=(True, False, False))) is None


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_every_start_is_inside_and_leads_to_spheres_that_do_not_overlap(kind):
    for room in (unit_cube(), unit_sphere(), tetrahedron()):
        radius = np.array([0.2, 0.15, 0.15, 0.1, 0.1, 0.1])
        center = start(room, radius, kind, np.random.default_rng(0))
        assert (room.distances(center) > 0.0).all()
        found = descend(room, radius, center)
        assert found.factor == largest_factor(room, radius, found.center) > 1.0


def test_the_forces_of_soft_spheres_are_the_slope_of_their_energy():
    rng = np.random.default_rng(1)
    for room in (unit_cube(), unit_sphere()):
        center, half = room.points(6, rng), np.array([0.3, 0.25, 0.4, 0.35, 0.3, 0.3])
        walls = np.ascontiguousarray(room.normal), room.offset, room.center, room.radius
        force, nothing = np.zeros((6, 3)), np.zeros((6, 3))
        push(center, half, *walls, force)
        for sphere, axis in ((0, 0), (2, 1), (5, 2)):
            slope = 0.0
            for sign in (1.0, -1.0):
                moved = center.copy()
                moved[sphere, axis] += sign * 1e-6
                slope += sign * push(moved, half, *walls, nothing) / 2e-6
            assert force[sphere, axis] == pytest.approx(-slope, rel=1e-5, abs=1e-7)


def test_bounds_hold_and_are_reached_where_they_are_exact():
    cube, sphere = unit_cube(), unit_sphere()
    assert scale_bound(cube, np.ones(1), is_box=True).value == pytest.approx(0.5)
    assert scale_bound(cube, np.ones(2), is_box=True).value == pytest.approx(CUBE[2], abs=1e-9)
    assert scale_bound(sphere, np.ones(2), is_box=False).value == pytest.approx(0.5)
    assert pair_factor(sphere, 0.6, 0.5) == pytest.approx(1.0 / 1.1)
    for count, radius in CUBE.items():
        assert scale_bound(cube, np.ones(count), is_box=True).value > radius - 1e-9
    for count, radius in SPHERE.items():
        assert scale_bound(sphere, np.ones(count), is_box=False).value > radius - 1e-9


def test_sets_that_cannot_fit_are_left_out():
    size, number = np.array([0.6, 0.4, 0.3]), np.array([1, 2, 1])
    sets = possible_sets(unit_cube(), size, number).tolist()
    # The first is too large, two of the second are too large together, and one of each of the others fits.
    assert sets[0] == [0, 1, 0]
    assert [0, 0, 1] in sets
    assert all(each[0] == 0 and each[1] < 2 for each in sets)
    assert volume_bound(unit_cube(), size, number).value == pytest.approx(4.0 / 3.0 * math.pi * 0.4**3)


CHOICES = [
    ([0.35, 0.25, 0.25, 0.2, 0.2, 0.2], 0.411025, 6),
    ([0.4, 0.2, 0.2, 0.15, 0.15, 0.15, 0.15], 0.391652, 7),
    ([0.3, 0.3, 0.25, 0.25, 0.2], 0.277507, 4),
    ([0.3, 0.29, 0.28, 0.27, 0.26, 0.25], 0.361120, 4),
]


@pytest.mark.slow
@pytest.mark.parametrize(("radii", "volume", "count"), CHOICES)
def test_the_best_choice_among_unequal_spheres_is_found(radii, volume, count):
    size, number = np.unique(-np.array(radii), return_counts=True)
    size = -size
    for best in search(
        unit_cube(), size, number, np.random.SeedSequence(0), time.time() + LATER, 10, lambda _: None
    ):
        found = float(4.0 / 3.0 * math.pi * best.numbers @ size**3)
        if found > volume - 1e-6:
            break
    assert found == pytest.approx(volume, abs=1e-6)
    assert best.numbers.sum() == count
    chosen = np.repeat(size, best.numbers)
    assert largest_factor(unit_cube(), chosen, best.placed.center) >= 1.0 - 1e-12


@pytest.mark.slow
def test_a_branch_and_bound_proves_what_is_best():
    pytest.importorskip("pyscipopt", reason="the optional package of proofs")
    told = proof.prove_scale(unit_cube(), np.full(3, 0.1), 2.928932, 4.0, 300.0, is_box=True)
    assert told.finished
    assert told.bound == pytest.approx(10.0 * CUBE[3], rel=1e-5)
    radii = np.array(CHOICES[0][0])
    told = proof.prove_volume(unit_cube(), radii, 0.0, 300.0, is_box=True)
    assert told.finished
    assert told.bound == pytest.approx(float((radii**3).sum()), rel=1e-5)
