from __future__ import annotations

import shutil
from dataclasses import replace

import numpy as np
import pytest

from exporters import liggghts
from packgen.bed import Material
from packgen.validation import Limits, validate
from packgen.validation.elastic import elastic_sinking
from packgen.validation.lammps_family import SPHERES_LEAST
from tests.beds import box_container, make_bed
from tests.exporters.beds import RADIUS, lattice

COUNT = 12


def column_sinking(count: int, gravity: float, youngs_modulus: float) -> np.ndarray:
    """How far each sphere of a column goes down: contact k carries all above it, by Hertz' law."""
    weight = 2500 * 4 / 3 * np.pi * RADIUS**3 * gravity
    modulus = youngs_modulus / (2 * (1 - 0.3**2))
    radius = np.full(count, RADIUS / 2)
    radius[0] = RADIUS  # at the floor
    overlap = (weight * (count - np.arange(count)) / (4 / 3 * modulus * np.sqrt(radius))) ** (2 / 3)
    return np.cumsum(overlap)


def column(sinking, **changes):
    bed = lattice((1, 1, COUNT), **changes)
    position = bed.position.copy()
    position[:, 2] -= sinking
    return make_bed(position, RADIUS, bed.container, materials=bed.materials)


def test_a_column_has_sunk_by_the_sum_of_its_overlaps():
    sinking = column_sinking(COUNT, 981.0, 5e6)
    assert sinking[-1] > 0.2 * RADIUS  # no small matter
    bed = column(sinking)
    assert np.allclose(elastic_sinking(bed, bed.position, np.arange(COUNT)), sinking, rtol=1e-9)


def test_the_order_of_spheres_and_the_direction_of_gravity_do_not_matter():
    sinking = column_sinking(COUNT, 981.0, 5e6)
    bed = column(sinking)
    order = np.random.default_rng(1).permutation(COUNT)
    turned = bed.position[order][:, [2, 0, 1]]
    size = bed.container.bounds[1][[2, 0, 1]]
    other = make_bed(turned, RADIUS, box_container((0, 0, 0), size), gravity=np.array([-9.81, 0.0, 0.0]))
    assert np.allclose(elastic_sinking(other, turned, np.arange(COUNT)), sinking[order], rtol=1e-9)


def test_columns_side_by_side_sink_as_one():
    bed = lattice((3, 4, 6))
    sinking = column_sinking(6, 981.0, 5e6)
    position = bed.position.copy()
    position[:, 2] -= sinking[np.rint(position[:, 2] / RADIUS / 2 - 0.5).astype(int)]
    found = elastic_sinking(make_bed(position, RADIUS, bed.container), position, np.arange(bed.count))
    assert np.allclose(found.reshape(3, 4, 6), sinking, rtol=1e-9)


def test_a_lean_contact_takes_its_share_of_the_height_only():
    # Three spheres that lean against each other in a wide vessel: one path down, overlaps 0.01 r along it.
    step = 1.99 * RADIUS * np.array([0.6, 0.0, 0.8])
    position = np.array([5 * RADIUS, 5 * RADIUS, RADIUS]) + np.arange(3)[:, None] * step
    bed = make_bed(position, RADIUS, box_container((0, 0, 0), (1, 1, 1)))
    found = elastic_sinking(bed, position, np.arange(3))
    assert np.allclose(found, 0.01 * RADIUS * 0.8 * np.arange(3), rtol=1e-6, atol=1e-12)


def test_a_bed_without_contacts_has_not_sunk():
    bed = make_bed([[0.5, 0.5, 0.5], [0.5, 0.5, 0.8]], 0.1, box_container((0, 0, 0), (1, 1, 1)))
    assert elastic_sinking(bed, bed.position, np.arange(2)).tolist() == [0, 0]


@pytest.mark.solver
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_in_liggghts_all_that_a_soft_column_sinks_is_elastic(tmp_path):
    material = Material("ore", youngs_modulus=5e6)
    bed = lattice((1, 1, COUNT), materials=(material,), gravity=np.array([0.0, 0.0, -981.0]))
    liggghts.write(bed, tmp_path, liggghts.Options())
    report = validate(bed, tmp_path, limits=Limits(free_fall_times=200))
    run = report.gravity_run
    expected = column_sinking(COUNT, 981.0, 5e6).mean() / (COUNT * RADIUS)
    assert run.sinking == pytest.approx(expected, rel=0.02)
    assert run.sinking > 0.01
    assert run.sinking_elastic == pytest.approx(run.sinking, rel=1e-3)
    assert abs(run.sinking_rest) < 1e-4
    assert run.displacement_rest_mean < 0.01 * run.displacement_mean
    assert report.missed == ()
    rows = {row.quantity: row for row in report.rows()}
    assert rows["centre of mass sinks by"].limit == ""
    assert rows["centre of mass sinks, not elastic"].limit == "1.5 %"
    assert rows["centre of mass sinks, elastic part"].value == rows["centre of mass sinks by"].value.replace(
        " of its height", ""
    )
    json = report.as_dict()["gravity_run"]
    assert json["sinking_rest"] == run.sinking - run.sinking_elastic


@pytest.mark.solver
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_a_run_that_the_budget_cut_short_is_not_judged_and_no_run_at_all_is_missed(tmp_path):
    bed = lattice((2, 2, 2))
    liggghts.write(bed, tmp_path, liggghts.Options())
    moved = ("mean displacement, not elastic", "centre of mass sinks, not elastic")
    for budget, verdict, passed in (
        (50 * SPHERES_LEAST, "not judged", True),
        (SPHERES_LEAST - 1, "MISSED", False),
    ):
        report = validate(bed, tmp_path, limits=Limits(work_budget=budget))
        rows = {row.quantity: row for row in report.rows()}
        assert [rows[name].verdict for name in moved] == [verdict] * 2
        assert report.passed is passed
        assert "work budget reached" in rows["steps of the gravity run"].value
        assert report.as_dict()["gravity_run"]["judged"] is not passed
    enough = replace(report, gravity_run=replace(report.gravity_run, steps=25, steps_wanted=100))
    assert [row.verdict for row in enough.rows() if row.quantity in moved] == ["", ""]


def test_an_overlap_within_a_body_is_no_sinking():
    position = np.array([[0.5, 0.5, 0.1], [0.5, 0.5, 0.2], [0.5, 0.5, 0.399]])
    bed = make_bed(position, 0.1, box_container((0, 0, 0), (1, 1, 1)), body_index=[0, 0, 1])
    assert elastic_sinking(bed, position, np.arange(3)) == pytest.approx([0, 0, 0.001])
    # Of the spheres that are left the bodies are told by their rows in the bed.
    left = elastic_sinking(bed, position[1:], np.array([1, 2]))
    assert left == pytest.approx([0, 0.001])
