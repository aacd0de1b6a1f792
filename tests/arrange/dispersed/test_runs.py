"""Claims on whole runs of dispersed scenes: exit codes, what is said, and what solvers make of the decks."""

from __future__ import annotations

import json
import re
import shutil

import pytest

from packgen.cli import main

SCENE = """\
container: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
algorithm: DISPERSED
particle_sets: [{radius_distribution: constant, radius: 0.1}]
zones: [{%s}]
"""


def run(folder, zone, *options):
    (folder / "scene.yaml").write_text(SCENE % zone, encoding="utf-8")
    return main([str(folder / "scene.yaml"), "-o", str(folder / "out"), "--no-report", *options])


def test_what_finds_no_place_is_told_with_the_fraction_that_is_possible(tmp_path, capsys):
    assert run(tmp_path, "solid_fraction: 0.63", "--quiet") == 1
    last = capsys.readouterr().err.splitlines()[-1]
    found = re.search(
        r"(\d+) of 150 spheres placed, \d+ did not fit: a solid fraction of (0\.\d+) is poss", last
    )
    assert found
    # Twenty seeds: 0.519 +- 0.010, 0.507 to 0.540.
    assert 0.49 < float(found[2]) < 0.56
    zone = json.loads((tmp_path / "out" / "report.json").read_text())["zones"][0]
    assert zone["placed"] == int(found[1])
    assert zone["solid_fraction"] == pytest.approx(float(found[2]), abs=1e-4)
    assert zone["solid_fraction_asked"] == 0.63


def test_what_no_random_packing_holds_is_refused_before_the_run(tmp_path, capsys):
    assert run(tmp_path, "porosity: 0.3") == 2
    assert "scene.yaml:4:20: zones[0].porosity: found 0.3, expected at least 0.360" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_dispersed_bed_has_no_remarks_and_decks_without_gravity(tmp_path, capsys):
    assert run(tmp_path, "n_particles: 60, gap: 0.1", "--quiet", "--export", "liggghts,lammps,yade") == 0
    assert capsys.readouterr().err == ""
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert report["warnings"] == report["missed"] == []
    assert report["step_zero"] is None
    for name in ("liggghts/in.bed", "lammps/in.bed", "yade/bed.py"):
        assert "No gravity: the spheres are dispersed" in (tmp_path / "out" / name).read_text()


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_a_solver_finds_that_nothing_touches_and_nothing_moves(tmp_path):
    assert run(tmp_path, "n_particles: 60, gap: 0.1", "--quiet", "--validate") == 0
    found = json.loads((tmp_path / "out" / "validation.json").read_text())["solvers"]["liggghts"]
    assert found["step_zero"]["pair_count"] == found["step_zero"]["wall_count"] == 0
    assert found["gravity_run"]["displacement_max"] == 0.0
