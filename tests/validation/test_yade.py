from __future__ import annotations

import shutil

import pytest

from exporters import yade
from packgen.validation import Limits, validate
from packgen.validation.yade import SPHERES_LEAST
from tests.exporters.beds import lattice
from tests.validation.beds import OVERLAP, bed_in

pytestmark = [
    pytest.mark.solver,
    pytest.mark.skipif(shutil.which("yade") is None, reason="yade is not installed"),
]


def judge(bed, folder, **limits):
    yade.write(bed, folder, yade.Options())
    return validate(bed, folder, solver="yade", limits=Limits(**limits))


@pytest.mark.parametrize(("kind", "wall_count"), [("box", 2), ("hopper", 2), ("mesh", 3)])
def test_forces_at_step_zero_are_those_of_the_law(tmp_path, kind, wall_count):
    zero = judge(bed_in(kind), tmp_path, free_fall_times=0.01).step_zero
    # The sphere at the mesh's side is above the edge of two facets, which YADE counts both.
    assert zero.pair_count == 1
    assert zero.wall_count in (wall_count, wall_count + 1)
    assert zero.worst_pair == (0, 2)
    assert zero.pair_overlap_max == pytest.approx(OVERLAP, rel=1e-9)
    assert zero.wall_overlap_max == pytest.approx(OVERLAP, rel=1e-9)
    assert zero.law_error < 1e-9


def test_touching_spheres_pass_and_the_run_is_within_a_fiftieth_of_the_budget(tmp_path):
    report = judge(lattice(), tmp_path, work_budget=50 * SPHERES_LEAST * 2000)
    assert report.step_zero.pair_overlap_max < 1e-12
    assert report.gravity_run.steps == 2000
    assert report.missed == ()
    assert report.gravity_run.sinking < 1e-3
    assert "2023" in report.version
