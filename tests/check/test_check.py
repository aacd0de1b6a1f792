from __future__ import annotations

import numpy as np
import pytest

from packgen.bed import EarlierBed
from packgen.check import check_bed, wall_clearance
from packgen.geometry import Ball, Cone, Mesh, Polyhedron
from tests.beds import (
    box_container,
    box_surface,
    cubic_lattice,
    make_bed,
    make_container,
    revolved_surface,
)


def lattice_bed(**changes):
    container = box_container([0, 0, 0], [0.8, 0.8, 0.8])
    return make_bed(cubic_lattice(4, 0.1), 0.1, container, **changes)


def test_a_lattice_of_touching_spheres_is_within_tolerance():
    check = check_bed(lattice_bed())
    assert check.within_tolerance
    assert check.faults() == ()
    assert check.overlap_max < 1e-12
    assert check.wall_overlap_max < 1e-12


def test_a_planted_overlap_is_measured_and_named():
    position = cubic_lattice(4, 0.1)
    position[21] += [0.0, 0.0, 0.004]
    check = check_bed(make_bed(position, 0.1, box_container([0, 0, 0], [0.8, 0.8, 0.8])))
    assert check.overlap_max == pytest.approx(0.04)
    assert sorted(check.worst_pair) == [21, 22]
    assert not check.within_tolerance
    assert check.excess_count == 1
    assert "21" in check.faults()[0]
    assert "0.04" in check.faults()[0]


def test_one_fault_is_told_in_the_singular_and_more_in_the_plural():
    box = box_container([0, 0, 0], [8, 2, 2])
    two, four = ([[x, 1, 1] for x in places] for places in ((1, 2), (1, 2, 4, 5)))
    assert check_bed(make_bed(two, 0.6, box)).faults()[0].startswith("1 pair overlaps by more than")
    assert check_bed(make_bed(four, 0.6, box)).faults()[0].startswith("2 pairs overlap by more than")
    outside = [[1, 1, 1], [9, 1, 1], [12, 1, 1]]
    assert check_bed(make_bed(outside[:2], 0.5, box)).faults()[0] == "sphere 1 lies outside the container"
    assert (
        check_bed(make_bed(outside, 0.5, box)).faults()[0].startswith("2 spheres lie outside the container")
    )
    lost = [[np.nan, 1, 1], [np.inf, 1, 1]]
    assert check_bed(make_bed(lost[:1], 0.5, box)).faults()[0].startswith("1 sphere has a position")
    assert check_bed(make_bed(lost, 0.5, box)).faults()[0].startswith("2 spheres have a position")


def test_overlap_counts_as_a_fraction_of_the_smaller_radius():
    container = box_container([-10, -10, -10], [10, 10, 10])
    check = check_bed(make_bed([[0, 0, 0], [0, 0, 1.09]], [1.0, 0.1], container))
    assert check.overlap_max == pytest.approx(0.1)
    assert check.overlap_mean == pytest.approx(0.1)
    assert check.overlap_count == 1


def test_a_sphere_in_the_wall_is_measured_and_named():
    position = cubic_lattice(4, 0.1)
    position[0] -= [0.003, 0.0, 0.0]
    check = check_bed(make_bed(position, 0.1, box_container([0, 0, 0], [0.8, 0.8, 0.8])))
    assert check.wall_overlap_max == pytest.approx(0.03)
    assert check.worst_wall_sphere == 0
    assert not check.within_tolerance


def test_a_sphere_outside_is_counted():
    check = check_bed(make_bed([[0.5, 0.5, 1.7]], 0.1, box_container([0, 0, 0], [1, 1, 1])))
    assert check.outside_count == 1
    assert not check.within_tolerance


def test_without_a_tolerance_overlaps_are_left_but_lost_spheres_are_not():
    container = box_container([0, 0, 0], [1, 1, 1])
    overlapping = make_bed([[0.5, 0.5, 0.5], [0.5, 0.5, 0.6]], 0.1, container, tolerance=None)
    assert check_bed(overlapping).within_tolerance
    assert not check_bed(make_bed([[2, 0.5, 0.5]], 0.1, container, tolerance=None)).within_tolerance


def test_numbers_that_are_not_finite_are_counted_not_ignored():
    check = check_bed(
        make_bed([[0.5, 0.5, np.nan], [0.5, 0.5, 0.5]], 0.1, box_container([0, 0, 0], [1, 1, 1]))
    )
    assert check.invalid_count == 1
    assert not check.within_tolerance


def test_overlap_across_a_seam_is_found_once():
    container = box_container([0, 0, 0], [1, 1, 1], (True, False, False))
    check = check_bed(make_bed([[0.05, 0.5, 0.5], [0.96, 0.5, 0.5]], 0.05, container))
    assert check.overlap_max == pytest.approx(0.2)
    assert check.overlap_count == 1
    assert check.wall_overlap_max == 0.0


def test_an_empty_bed_is_within_tolerance():
    assert check_bed(make_bed(np.empty((0, 3)), 0.1, box_container([0, 0, 0], [1, 1, 1]))).within_tolerance


UNIT = box_surface([0, 0, 0], [1, 1, 1])
BOX_PLANES = (np.concatenate([-np.eye(3), np.eye(3)]), np.array([0.0, 0, 0, 1, 1, 1]))
SHAPES = {
    # A sphere of radius 0.1 that touches, and the direction that leads into the wall.
    "ball": (Ball(np.zeros(3), 1.0), [0.54, 0.72, 0.0], [0.6, 0.8, 0.0]),
    "cylinder side": (Cone(np.zeros(3), np.array([0, 0, 1.0]), 2.0, 1.0, 1.0), [0.9, 0, 1.0], [1, 0, 0]),
    "cylinder top": (Cone(np.zeros(3), np.array([0, 0, 1.0]), 2.0, 1.0, 1.0), [0, 0.2, 1.9], [0, 0, 1]),
    # The side of a cone with slope 3/4 has the normal (4, 0, -3) / 5; at half height it is at 1.75.
    "cone": (
        Cone(np.zeros(3), np.array([0, 0, 1.0]), 2.0, 1.0, 2.5),
        [1.75 - 0.08, 0, 1.06],
        [0.8, 0, -0.6],
    ),
    "polyhedron": (Polyhedron(*BOX_PLANES, UNIT), [0.5, 0.9, 0.5], [0, 1, 0]),
    "mesh": (Mesh(UNIT), [0.5, 0.9, 0.5], [0, 1, 0]),
}


@pytest.mark.parametrize("name", SHAPES)
def test_depth_in_the_wall_of_each_shape_is_exact(name):
    shape, touching, outward = SHAPES[name]
    container = make_container(shape, UNIT, 1.0)
    touching, outward = np.array(touching), np.array(outward, dtype=float)
    assert check_bed(make_bed([touching], 0.1, container)).wall_overlap_max < 1e-12
    deep = check_bed(make_bed([touching + 0.002 * outward], 0.1, container))
    assert deep.wall_overlap_max == pytest.approx(0.02, rel=1e-9)
    outside = check_bed(make_bed([touching + 0.5 * outward], 0.1, container))
    assert outside.outside_count == 1


def test_a_convex_mesh_and_its_planes_give_the_same_depths():
    surface = revolved_surface([(0, 1.2), (7, 3.25), (26, 3.25), (32, 1.0)], 24)
    corners = surface.vertices[surface.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    planes = Polyhedron(normal, np.einsum("ij,ij->i", normal, corners[:, 0]), surface)
    position = np.random.default_rng(1).uniform([-2.3, -2.3, 1.0], [2.3, 2.3, 31.0], (2000, 3))
    radius = np.full(len(position), 0.5)
    by_planes = wall_clearance(make_container(planes, surface, 1.0), position, radius)
    by_mesh = wall_clearance(make_container(Mesh(surface), surface, 1.0), position, radius)
    np.testing.assert_array_equal(by_planes < 0.0, by_mesh < 0.0)
    assert 0 < np.count_nonzero(by_planes < 0.0) < len(position)
    inside = by_planes > 0.0
    np.testing.assert_allclose(by_mesh[inside], np.minimum(by_planes[inside], 0.5), rtol=0, atol=1e-12)


def dimers(**changes):
    """Two bodies of two spheres deep in each other; a sphere of each overlaps one of the other by 0.04."""
    position = [[0.3, 0.5, 0.5], [0.4, 0.5, 0.5], [0.596, 0.5, 0.5], [0.7, 0.5, 0.5]]
    return make_bed(position, 0.1, box_container([0, 0, 0], [1, 1, 1]), **changes)


def test_overlaps_within_a_body_are_lawful_and_those_between_bodies_are_found():
    check = check_bed(dimers(body_index=[0, 0, 1, 1]))
    assert check.overlap_count == check.excess_count == 1
    assert check.overlap_max == check.overlap_mean == pytest.approx(0.04)
    assert sorted(check.worst_pair) == [1, 2]
    assert check_bed(dimers()).overlap_count == 3
    assert check_bed(dimers(body_index=[0, 1, 2, 3])) == check_bed(dimers())
    assert check_bed(dimers(body_index=[0] * 4)).within_tolerance


def test_a_sphere_that_is_no_number_shifts_no_body():
    bed = dimers(body_index=[0, 0, 1, 1])
    position = np.concatenate([[[np.nan, 0, 0]], bed.position])
    check = check_bed(make_bed(position, 0.1, bed.container, body_index=[5, 0, 0, 1, 1]))
    assert sorted(check.worst_pair) == [2, 3]
    assert (check.overlap_count, check.invalid_count) == (1, 1)


def test_a_body_in_the_wall_is_as_wrong_as_a_sphere():
    position = [[0.09, 0.5, 0.5], [0.15, 0.5, 0.5]]
    check = check_bed(make_bed(position, 0.1, box_container([0, 0, 0], [1, 1, 1]), body_index=[0, 0]))
    assert check.overlap_count == 0
    assert check.wall_overlap_max == pytest.approx(0.1)
    assert check.worst_wall_sphere == 0


def beside_earlier(position, tolerance=0.2):
    """Spheres of radius 0.1, the first two of which were there before."""
    zones = np.array([1, 1] + [0] * (len(position) - 2), np.int32)
    container = box_container([0, 0, 0], [1, 1, 1])
    return make_bed(position, 0.1, container, zone_index=zones, earlier=EarlierBed(1, tolerance))


def test_spheres_that_were_there_before_may_overlap_each_other_and_walls_as_solvers_leave_them():
    check = check_bed(beside_earlier([[0.095, 0.5, 0.5], [0.285, 0.5, 0.5], [0.7, 0.5, 0.5]]))
    assert check.within_tolerance
    assert (check.overlap_max, check.wall_overlap_max) == (pytest.approx(0.1), pytest.approx(0.05))
    assert (check.new.overlap_max, check.new.wall_overlap_max, check.new.excess_count) == (0.0, 0.0, 0)


def test_new_spheres_overlap_neither_those_that_were_there_before_nor_walls():
    pair = check_bed(beside_earlier([[0.3, 0.5, 0.5], [0.49, 0.5, 0.5], [0.685, 0.5, 0.5]]))
    assert pair.faults() == (
        "1 pair overlaps by more than the tolerance 1e-06, worst spheres 1 and 2, by 0.05 of the smaller "
        "radius",
    )
    wall = check_bed(beside_earlier([[0.3, 0.5, 0.5], [0.5, 0.5, 0.5], [0.5, 0.95, 0.5]]))
    assert wall.faults() == ("sphere 2 is in the wall by 0.5 of its radius, tolerance 1e-06",)


def test_spheres_that_were_there_before_have_a_limit_too():
    position = [[0.05, 0.5, 0.5], [0.18, 0.5, 0.5], [0.7, 0.5, 0.5]]
    assert check_bed(beside_earlier(position)).faults() == (
        "spheres 0 and 1, which were there before, overlap by 0.7 of the smaller radius, limit 0.2",
        "sphere 0, which was there before, is in the wall by 0.5 of its radius, limit 0.2",
    )
    assert check_bed(beside_earlier(position, None)).within_tolerance
