"""What LIGGGHTS measures of a deck in another unit of length is told in SI, and is the same physics."""

from __future__ import annotations

import shutil
from dataclasses import replace

import numpy as np
import pytest

from packgen.validation import Limits, predicted_forces
from packgen.validation.lammps_family import length_unit
from tests.exporters.test_lengths import shrunk
from tests.validation.beds import OVERLAP, bed_in
from tests.validation.test_liggghts import judge

pytestmark = [
    pytest.mark.solver,
    pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed"),
]


def test_the_unit_is_read_from_the_deck_and_is_the_metre_where_nothing_is_said():
    assert length_unit("units si\nvariable length_unit index 1e-6\n") == 1e-6
    assert length_unit("units si\n# variable length_unit index 1e-6\n") == 1.0


@pytest.mark.parametrize("factor", [1e-7, 1e-5, 1e9])
@pytest.mark.parametrize("kind", ["mesh", "drum", "ball"])
def test_step_0_and_the_gravity_run_are_those_of_a_similar_bed_in_metres(tmp_path, kind, factor):
    bed = bed_in(kind)
    small = shrunk(bed, factor)
    limits = Limits(free_fall_times=0.5, work_budget=1e6)
    there, here = judge(bed, tmp_path / "there", limits), judge(small, tmp_path / "here", limits)
    predicted = predicted_forces(small)
    assert here.step_zero.law_error < 1e-6
    assert here.step_zero.pair_overlap_max == pytest.approx(OVERLAP, rel=1e-6)
    assert here.step_zero.pair_force_max == pytest.approx(predicted.pair_force_max, rel=1e-6)
    assert here.step_zero.wall_force_max == pytest.approx(there.step_zero.wall_force_max, rel=1e-6)
    assert here.gravity_run.steps == there.gravity_run.steps
    assert here.gravity_run.timestep == pytest.approx(factor**0.5 * there.gravity_run.timestep)
    for name in ("free_fall_times", "timestep_rayleigh", "displacement_mean", "energy_peak", "sinking"):
        found, wanted = getattr(here.gravity_run, name), getattr(there.gravity_run, name)
        assert found == pytest.approx(wanted, rel=1e-4), name


def test_a_sphere_falls_as_far_as_galilei_says(tmp_path):
    bed = shrunk(bed_in("mesh"), 1e-6)
    free = replace(
        bed,
        position=np.array([[0.0, 0.0, 2.5e-6]]),
        radius=np.array([1e-6]),
        set_index=np.zeros(1, np.int32),
        zone_index=np.zeros(1, np.int32),
        batch_index=np.zeros(1, np.int32),
    )
    run = judge(free, tmp_path / "deck", Limits(free_fall_times=0.5)).gravity_run
    duration = run.steps * run.timestep
    fallen = run.displacement_mean * 1e-6
    assert fallen == pytest.approx(0.5 * 9.81 * duration**2, rel=1e-3)
