"""Beds that solvers have dumped: read, measured, and converted to all solvers, whose forces agree."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import exporters
from packgen import load_container, load_scene, read_bed
from packgen.bed import ParticleSet
from packgen.cli import main
from packgen.reading import read_spheres
from packgen.validation import Limits, predicted_forces, validate
from packgen.validation.process import SOLVERS
from tests.beds import make_bed

pytestmark = [
    pytest.mark.solver,
    pytest.mark.slow,
    pytest.mark.skipif(
        not all(shutil.which(program) for program, _ in SOLVERS.values()),
        reason=f"not all of {', '.join(SOLVERS)} are installed",
    ),
]

SCENE = """
container: {box: {min: [0, 0, 0], max: [7.8, 7.8, 9]}}
particle_sets:
  - {name: a, radius_distribution: uniform, radius_min: 0.9, radius_max: 1, density: 2500, material: coke}
  - {name: b, radius_distribution: uniform, radius_min: 0.9, radius_max: 1, density: 3500, material: ore}
materials:
  ore: {youngs_modulus: 1.0e+8, poissons_ratio: 0.25, restitution: 0.5, friction: 0.4}
  coke: {youngs_modulus: 3.0e+7, poissons_ratio: 0.2, restitution: 0.3, friction: 0.6}
wall_material: ore
zones:
  - {n_particles: 64, set_proportions: [0.5, 0.5]}
"""
COMMANDS = {
    "liggghts": (["liggghts", "-in", "in.bed", "-log", "none"], "bed_10.dump"),
    "lammps": (["lmp", "-in", "in.bed", "-log", "none"], "bed_10.dump"),
    "yade": (["yade", "-n", "-x", "-j1", "bed.py"], "bed_end.txt"),
}


def crowded(scene):
    """Spheres of two sets on a lattice, shaken so that many overlap."""
    rng = np.random.default_rng(4)
    grid = np.stack(np.meshgrid(*[np.arange(4)] * 3, indexing="ij"), axis=-1).reshape(-1, 3) + 0.5
    return make_bed(
        1.95 * grid + rng.uniform(-0.03, 0.03, grid.shape), rng.uniform(0.9, 1.0, 64), load_container(scene),
        set_index=np.arange(64) % 2,
        particle_sets=(ParticleSet("a", 2500.0, "coke"), ParticleSet("b", 3500.0, "ore")),
        materials=scene.materials, wall_material="ore",
    )  # fmt: skip


def run(solver, bed, folder, **options):
    """Let a solver run a deck for 10 steps, and return the file that it leaves."""
    exporter = exporters.get(solver)
    exporter.write(bed, folder, exporter.Options(steps=10, **options))
    command, name = COMMANDS[solver]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=120, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return folder / "post" / name


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("scene.yaml").write_text(SCENE)
    return load_scene(Path("scene.yaml"))


@pytest.mark.parametrize("solver", COMMANDS)
def test_what_a_solver_leaves_is_measured_and_runs_in_all_of_them_with_the_same_forces(
    tmp_path, scene, solver
):
    bed = crowded(scene)
    (tmp_path / "run").mkdir()
    left = run(solver, bed, tmp_path / "run")
    found = read_bed(left, scene=scene)
    assert np.array_equal(found.set_index, bed.set_index)
    assert np.allclose(found.radius, bed.radius, rtol=1e-5)
    moved = np.linalg.norm(found.position - bed.position, axis=1)
    assert 1e-5 < moved.max() < 0.1
    assert (
        main(["measure", str(left), "--scene", "scene.yaml", "-o", "measured", "--quiet"]) == 1
    )  # it overlaps
    report = json.loads(Path("measured/report.json").read_text())
    assert report["sphere_count"] == 64
    assert any("overlap by" in line and "(id " in line for line in report["missed"]) is (solver != "yade")
    names = ",".join(COMMANDS)
    assert main(
        ["convert", str(left), "--scene", "scene.yaml", "--export", names, "-o", "decks", "--quiet"]
    ) in (0, 1)
    predicted = predicted_forces(found)
    assert predicted.pair_force_max > 0
    for name in COMMANDS:
        zero = validate(
            found, Path("decks", name), solver=name, limits=Limits(free_fall_times=0.02)
        ).step_zero
        assert zero.pair_count == predicted.pair_count
        assert zero.pair_force_max == pytest.approx(predicted.pair_force_max, rel=1e-6)
        assert zero.law_error < 1e-6


def test_vtk_dumps_of_liggghts_are_read(tmp_path, scene):
    bed = crowded(scene)
    run("liggghts", bed, tmp_path, dumps="vtk")
    found = read_spheres(tmp_path / "post" / "bed_0.vtk")
    assert np.allclose(found.position, bed.position, rtol=1e-5)
    assert np.allclose(found.radius, bed.radius, rtol=1e-5)
    assert np.array_equal(found.groups.number, bed.type_index + 1)
