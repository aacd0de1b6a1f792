"""When a run of a solver ends since nothing moves any more, and what it costs at most."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

import exporters
from packgen.validation import Limits, validate
from packgen.validation.lammps_family import SPHERES_LEAST
from packgen.validation.measure import steps_wanted
from packgen.validation.process import SOLVERS
from packgen.validation.still import (
    CALM_LINE,
    Look,
    Looks,
    free_fall_time,
    look_of,
    looks_of,
    loop_input,
    speed_unit,
    was_still,
)
from tests.beds import box_container, make_bed
from tests.exporters.beds import RADIUS, lattice
from tests.scenes import box, constant, run_scene

SOLVER = [
    pytest.param(
        name, marks=[pytest.mark.solver, pytest.mark.skipif(not shutil.which(program), reason=f"no {name}")]
    )
    for name, (program, _) in SOLVERS.items()
]


def judge(bed, folder, solver, **limits):
    exporter = exporters.get(solver)
    exporter.write(bed, folder, exporter.Options())
    return validate(bed, folder, solver=solver, limits=Limits(**limits))


@pytest.mark.parametrize(("steps", "every"), [(2000, 10), (2007, 10), (9, 10), (0, 0), (19, 10)])
def test_the_parts_of_a_run_are_all_of_its_steps(steps, every):
    looks = looks_of(lattice(), timestep=1e-5, steps=steps, every=every, share=1e-3)
    assert looks.first + (looks.parts - 1) * looks.every == steps
    assert looks.first >= 0


def test_a_bed_has_to_be_still_for_a_free_fall_time():
    bed = lattice()
    looks = looks_of(bed, timestep=free_fall_time(bed) / 400, steps=10_000, every=100, share=1e-3)
    assert looks.calm == 4
    assert looks.speed == 1e-3 * speed_unit(bed) == pytest.approx(1e-3 * np.sqrt(9.81 * RADIUS))
    assert f"{CALM_LINE} ${{packgen_calm}}" in loop_input(looks)


def test_a_long_run_is_looked_at_as_often_as_tells_whether_it_is_still():
    bed = lattice()
    timestep = free_fall_time(bed) / 400
    looks = looks_of(bed, timestep=timestep, steps=10**6, every=10**4, share=1e-3)
    assert (looks.every, looks.calm) == (100, 4)


def test_rows_of_the_table_are_told_from_other_lines():
    assert look_of("  200  80  1e-06  2e-06  0.25") == Look(200, 80, 3e-6, 0.25)
    assert look_of("200 80 nan nan nan") is not None
    for line in ("Step Atoms KinEng c_a c_b", "200 80 1e-06 2e-06", "Loop time of 2 on 1", "200 80 a b c"):
        assert look_of(line) is None


@pytest.mark.parametrize(
    ("said", "found"), [(["packgen calm 4"], True), (["packgen calm 3"], False), ([], False)]
)
def test_the_solver_says_whether_the_bed_was_still(said, found):
    assert was_still(["packgen timestep 1", *said, ""], Looks(100, 10, 4, 1e-3)) is found


def test_a_bed_of_few_spheres_has_a_bound_of_steps_however_small_they_are():
    for radius in (2e-3, 2e-6, 2e-9):
        bed = make_bed(np.full((100, 3), radius), radius, box_container((0, 0, 0), (1, 1, 1)))
        timestep = 2.7e-3 * radius  # goes with the radius, the time of free fall with its root
        _, steps = steps_wanted(bed, Limits(), timestep, least=SPHERES_LEAST)
        assert steps <= Limits().work_budget / SPHERES_LEAST < 1.5e6


@pytest.mark.slow
@pytest.mark.parametrize("solver", SOLVER)
def test_a_run_ends_once_nothing_moves_and_is_judged(tmp_path, solver):
    report = judge(lattice((2, 2, 3)), tmp_path, solver, free_fall_times=400)
    run = report.gravity_run
    assert run.still
    assert run.judged
    assert 1 <= run.free_fall_times < 100
    assert run.energy_end < 1e-6
    assert report.missed == ()
    assert "nothing moves any more" in next(row.value for row in report.rows() if "steps" in row.quantity)


@pytest.mark.slow
@pytest.mark.parametrize("solver", SOLVER)
def test_a_run_goes_on_where_it_is_to_and_while_spheres_fall(tmp_path, solver):
    run = judge(lattice((1, 1, 2)), tmp_path, solver, free_fall_times=6, still_speed=0.0).gravity_run
    assert not run.still
    assert run.steps == pytest.approx(run.steps_wanted, abs=1)
    high = make_bed([[1.5 * RADIUS] * 2 + [40 * RADIUS]], RADIUS, box_container((0, 0, 0), [45 * RADIUS] * 3))
    (tmp_path / "high").mkdir()
    run = judge(high, tmp_path / "high", solver, free_fall_times=5).gravity_run
    assert not run.still
    assert run.displacement_mean > 20


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_a_powder_of_a_hundred_spheres_is_judged_within_a_million_steps(tmp_path):
    container = box((0, 0, 0), (20e-6, 20e-6, 60e-6))
    bed = run_scene(tmp_path, container, constant(2e-6), zones=[{"n_particles": 100}]).bed
    report = judge(bed, tmp_path, "liggghts")
    assert report.gravity_run.still
    assert report.gravity_run.steps < 1e6 < report.gravity_run.steps_wanted
    assert report.missed == ()
    assert report.unjudged == ""
