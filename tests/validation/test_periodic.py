"""Periodic boxes in the solvers: overlaps across the seams are seen, beds without any stay whole."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from exporters import lammps, liggghts
from packgen.check import check_bed
from packgen.filling.pack import pack
from packgen.validation import Limits, predicted_forces, validate
from tests.beds import box_container, make_bed
from tests.scenes import box, constant, read_scene, uniform

pytestmark = [
    pytest.mark.solver,
    pytest.mark.skipif(
        shutil.which("liggghts") is None or shutil.which("lmp") is None, reason="a solver is not installed"
    ),
]
DECKS = {"liggghts": liggghts, "lammps": lammps}
AXES = ["x", "xy", "xyz", "z"]


def judge(solver, bed, folder, limits):
    folder.mkdir()
    DECKS[solver].write(bed, folder, DECKS[solver].Options())
    return validate(bed, folder, solver=solver, limits=limits)


@pytest.mark.parametrize("solver", DECKS)
@pytest.mark.parametrize("axes", AXES)
def test_an_overlap_across_each_seam_is_seen_by_solver_check_and_prediction(tmp_path, solver, axes):
    wraps = [axis in axes for axis in "xyz"]
    along = np.array(wraps, float)
    # One pair across every seam at once, a corner where there are three, and one far from any seam.
    step = 1.98 / np.sqrt(along.sum()) * along
    corner = np.where(wraps, 0.1, 4.0)
    position = [corner, np.where(wraps, 8.1, 4.0) - step, [3.0, 2.0, 2.0], [4.995, 2.0, 2.0]]
    bed = make_bed(position, 1.0, box_container((0, 0, 0), (8, 8, 8), tuple(wraps)))
    zero = judge(solver, bed, tmp_path / "deck", Limits(free_fall_times=0.01)).step_zero
    predicted = predicted_forces(bed)
    assert zero.pair_count == predicted.pair_count == check_bed(bed).overlap_count == 2
    assert check_bed(bed).overlap_max == pytest.approx(0.02)
    assert zero.pair_overlap_max == pytest.approx(0.02, rel=1e-9)
    assert set(zero.worst_pair) == set(predicted.worst_pair) == {0, 1}
    assert zero.pair_force_max == pytest.approx(predicted.pair_force_max, rel=1e-9)
    assert zero.law_error < 1e-9
    assert zero.wall_count == predicted.wall_count == 0


@pytest.mark.slow
@pytest.mark.parametrize("sizes", [constant(0.05), uniform(0.03, 0.1)], ids=["constant", "wide"])
@pytest.mark.parametrize("axes", AXES)
def test_a_periodic_bed_stands_in_both_solvers_and_loses_nothing(tmp_path, axes, sizes):
    container = box((0, 0, 0), (0.6, 0.6, 0.8)) | {"periodic": list(axes)}
    bed = pack(*read_scene(tmp_path, container, sizes)).bed
    for solver in DECKS:
        report = judge(solver, bed, tmp_path / solver, Limits(free_fall_times=10.0))
        assert report.step_zero.force_max == 0.0
        run = report.gravity_run
        assert run.lost == ()
        # 20 seeds in LIGGGHTS: 0.085 to 0.163 of equal spheres, 0.069 to 0.357 of the wide sizes.
        assert run.displacement_mean < 0.5
        if bed.endless:
            assert run.displacement_max == 0.0, "without gravity nothing moves that does not overlap"
        else:
            assert run.displacement_max > 0.0
