"""All solvers load the same bed and find the same forces between its spheres."""

from __future__ import annotations

import json
import re
import shutil

import numpy as np
import pytest

import exporters
from packgen.validation import Limits, comparison, predicted_forces, validate, validation_dict
from packgen.validation.process import SOLVERS
from tests.beds import box_container, make_bed
from tests.exporters.beds import RADIUS
from tests.validation.beds import bed_in, mixed

pytestmark = [
    pytest.mark.solver,
    pytest.mark.skipif(
        not all(shutil.which(program) for program, _ in SOLVERS.values()),
        reason=f"not all of {', '.join(SOLVERS)} are installed",
    ),
]


def crowded_box():
    """Spheres of unlike sizes and materials on a lattice, shaken so that some overlap, some deeply."""
    rng = np.random.default_rng(4)
    grid = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) + 0.5
    position = 1.95 * grid + rng.uniform(-0.03, 0.03, grid.shape)
    return mixed(position, rng.uniform(0.9, 1.0, len(grid)), box_container((0, 0, 0), [4 * 1.95] * 3))


@pytest.mark.parametrize("make", [crowded_box, lambda: bed_in("hopper")], ids=["box", "hopper"])
def test_solvers_and_the_law_agree_on_the_forces_of_planted_overlaps(tmp_path, make):
    bed, reports = make(), {}
    for solver in SOLVERS:
        folder = tmp_path / solver
        folder.mkdir()
        exporter = exporters.get(solver)
        exporter.write(bed, folder, exporter.Options())
        reports[solver] = validate(bed, folder, solver=solver, limits=Limits(free_fall_times=0.02))
    predicted = predicted_forces(bed)
    assert predicted.pair_force_max > 0
    for report in reports.values():
        zero = report.step_zero
        assert zero.pair_count == predicted.pair_count
        assert zero.pair_force_max == pytest.approx(predicted.pair_force_max, rel=1e-6)
        assert zero.worst_pair is not None
        assert set(zero.worst_pair) == set(predicted.worst_pair)
        assert zero.law_error < 1e-6
        assert report.gravity_run.lost == ()
    content = json.loads(json.dumps(validation_dict(reports), allow_nan=False))
    assert list(content["solvers"]) == list(SOLVERS)
    keys = [set(each["gravity_run"]) | set(each["step_zero"]) for each in content["solvers"].values()]
    assert keys[0] == keys[1] == keys[2]
    rows = comparison(list(reports.values()))
    assert {len(row) for row in rows} == {5}
    assert [text.split()[0] for text in rows[0][1:4]] == ["LIGGGHTS-PUBLIC", "LAMMPS", "Yade"]


def planted(fault):
    """Nine spheres on the floor, apart from each other, and one of them with a fault."""
    grid = np.stack(np.meshgrid(np.arange(3), np.arange(3), indexing="ij"), axis=-1).reshape(-1, 2)
    position = np.column_stack((2.5 * RADIUS * (grid + 0.5), np.full(9, RADIUS)))
    if fault == "overlap":
        position[4] = position[3] + [0, (2 - 0.01) * RADIUS, 0]
    elif fault == "wall":
        position[6, 2] = 0.99 * RADIUS
    elif fault == "outside":
        position[8] = [-1.5 * RADIUS, RADIUS, RADIUS]
    return make_bed(position, RADIUS, box_container((0, 0, 0), [7.5 * RADIUS] * 3))


FAULTS = {
    "none": None,
    "overlap": r"largest step-0 force: .* \(spheres (3 and 4|4 and 3)\)",
    "wall": r"largest step-0 force: .* \(sphere 6 and the wall\)",
    "outside": r"centres outside the container: 1, expected at most 0 \(sphere 8\)",
}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("solver", SOLVERS)
def test_a_planted_fault_fails_and_the_sphere_is_named(tmp_path, solver, fault):
    bed, exporter = planted(fault), exporters.get(solver)
    exporter.write(bed, tmp_path, exporter.Options())
    report = validate(bed, tmp_path, solver=solver, limits=Limits(free_fall_times=0.2))
    if fault == "none":
        assert report.missed == ()
        return
    assert not report.passed
    assert re.search(FAULTS[fault], "\n".join(report.missed))
    if fault == "outside":
        assert report.gravity_run.lost == (8,)
