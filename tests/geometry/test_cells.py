"""Claims on periodic cells of any shape: frame, images, and what check and measures find in them."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.bed import with_images
from packgen.check import check_bed
from packgen.geometry.cells import cell_container, cell_images, into_cell, upright_cell
from packgen.measure import solid_fraction
from packgen.measure.contacts import contacts
from packgen.measure.order import local_order
from packgen.report import build_report
from tests.cells import SKEWED, all_gaps, close_packing, random_spheres


def test_a_turned_cell_is_that_lattice_and_hardly_tilted():
    vectors = np.array([[0.3, 1.0, -0.2], [5.0, 0.1, 0.4], [2.0, -3.0, 0.5]])
    upright, turn = upright_cell(vectors)
    assert turn @ turn.T == pytest.approx(np.eye(3))
    assert np.linalg.det(turn) == pytest.approx(1.0)
    steps = (vectors @ turn) @ np.linalg.inv(upright)
    assert steps == pytest.approx(np.round(steps))
    assert abs(np.linalg.det(steps)) == pytest.approx(1.0)
    assert (upright == np.tril(upright)).all()
    assert (np.diag(upright) > 0.0).all()
    (_, _, _), (xy, y, _), (xz, yz, _) = upright
    assert max(abs(xy), abs(xz)) <= 0.5 * upright[0, 0] + 1e-12
    assert abs(yz) <= 0.5 * y + 1e-12


def test_a_cell_is_a_container_without_walls():
    container = cell_container(SKEWED)
    assert container.volume == pytest.approx(np.linalg.det(SKEWED))
    assert container.bounds[0] == pytest.approx([-1.4, 0.0, 0.0])
    assert container.bounds[1] == pytest.approx([4.2, 3.9, 2.5])
    assert container.periodic == (True, True, True)
    assert container.period == (None, None, None)


def test_positions_come_into_the_cell_by_whole_vectors_and_keep_their_digits_inside():
    rng = np.random.default_rng(0)
    inside = rng.random((50, 3)) @ SKEWED
    assert (into_cell(inside, SKEWED) == inside).all()
    away = inside + rng.integers(-3, 4, (50, 3)) @ SKEWED
    assert into_cell(away, SKEWED) == pytest.approx(inside, abs=1e-12)


def test_images_are_all_that_come_within_reach():
    position = np.random.default_rng(1).random((20, 3)) @ SKEWED
    center, owner, steps = cell_images(position, SKEWED, 0.7)
    assert center == pytest.approx(position[owner] + steps @ SKEWED)
    shifts = np.stack(np.meshgrid(*[np.arange(-3, 4)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    everywhere = (position[:, None] + shifts @ SKEWED).reshape(-1, 3)
    share = everywhere @ np.linalg.inv(SKEWED)
    normal = np.linalg.inv(SKEWED)
    spacing = 1.0 / np.linalg.norm(normal, axis=0)
    within = ((share * spacing > -0.7) & ((share - 1.0) * spacing < 0.7)).all(axis=1).sum()
    assert len(center) == within - 20


def test_the_check_finds_every_overlap_across_seams_once():
    bed = random_spheres()
    check, gaps = check_bed(bed), all_gaps(bed)
    assert check.overlap_count == np.count_nonzero(gaps < 0.0) > 20
    assert check.overlap_max == pytest.approx(-gaps.min())
    assert check.overlap_mean == pytest.approx(-gaps[gaps < 0.0].mean())
    assert max(check.worst_pair) < bed.count
    assert check.wall_overlap_max == 0.0
    assert check.outside_count == 0


def test_a_sphere_that_overlaps_its_own_images_alone_is_found():
    check = check_bed(close_packing(0.51))
    assert check.overlap_count == 6
    assert check.overlap_max == pytest.approx(0.02 / 0.51)
    assert check.worst_pair == (0, 0)
    assert check_bed(close_packing()).overlap_max < 1e-14


def test_the_measures_of_a_close_packing_of_one_sphere_are_those_of_the_crystal():
    bed = close_packing(0.5 * (1.0 - 1e-9))
    assert solid_fraction(bed).filled == pytest.approx(np.pi / np.sqrt(18.0), rel=1e-8)
    near = contacts(bed, (0.001,))[0]
    assert near.mean == 12.0
    assert near.rattlers == 0.0
    assert local_order(bed, None).crystal == 1.0


def test_contacts_of_a_skewed_cell_are_all_of_them():
    bed = random_spheres()
    gaps = all_gaps(bed)
    for each in contacts(bed, (0.0, 0.05)):
        assert each.mean == pytest.approx(2.0 * np.count_nonzero(gaps <= each.gap) / bed.count)


def test_spheres_cut_by_faces_have_images_that_complete_them():
    bed = random_spheres(10)
    position, radius = with_images(bed)
    assert len(radius) > 10
    points = np.random.default_rng(2).random((4000, 3)) @ SKEWED
    inside = (np.linalg.norm(points[:, None] - position, axis=2) < radius).any(axis=1)
    shifts = np.stack(np.meshgrid(*[np.arange(-2, 3)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    every = (bed.position[:, None] + shifts @ SKEWED).reshape(-1, 3)
    exact = (np.linalg.norm(points[:, None] - every, axis=2) < np.repeat(bed.radius, len(shifts))).any(axis=1)
    assert (inside == exact).all()


def test_a_report_of_a_cell_needs_no_walls():
    report = build_report(close_packing())
    assert report.solid_fraction.core is None
    assert report.solid_fraction.core_rule == "the whole cell"
    assert report.profile.height == ()
    assert report.close_packing.wall_loss == 0.0
    assert report.coordination.plateau == pytest.approx(12.0)
    assert not report.missed
