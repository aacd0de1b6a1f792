"""Scenes that look harmless and are not, from the shell to the last line."""

from __future__ import annotations

import pytest

from packgen.cli import main

SOFT = """\
container: {box: {min: [0, 0, 0], max: [1, 1, 2]}}
particle_sets: [{radius_distribution: constant, radius: 0.1}]
materials:
  jelly: {youngs_modulus: 1.0e+5}
zones: [{n_particles: 100}]
"""
TILTED = """\
container: {{box: {{min: [0, 0, 0], max: [1, 1, 1]}}, periodic: [{axes}]}}
gravity_axis: {gravity}
particle_sets: [{{radius_distribution: constant, radius: 0.14}}]
zones: [{{n_particles: 10}}]
"""


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)

    def run_text(text, *arguments):
        (tmp_path / "scene.yaml").write_text(text)
        return main(["scene.yaml", "--no-report", "--quiet", *arguments]), capsys.readouterr().err

    return run_text


def test_spheres_too_soft_for_their_bed_are_refused_before_the_run(run, tmp_path):
    code, text = run(SOFT, "--export", "liggghts")
    assert code == 2
    assert text.startswith("packgen: scene.yaml:4:27: materials.jelly.youngs_modulus: found 1e+05 Pa")
    assert not (tmp_path / "scene").exists()


def test_spheres_that_the_scene_allows_to_be_soft_are_packed_with_a_warning(run):
    for text in (SOFT + "allow_soft: true\n", SOFT.replace("+5}", "+5, allow_soft: true}")):
        code, said = run(text, "--export", "liggghts")
        assert code == 0, said
        assert "warning: scene.yaml:4:" in said


@pytest.mark.parametrize("tilt", [1e-9, 1e-7, 1.1e-6, 1e-5, 1e-3, 0.1, 1.0])
@pytest.mark.parametrize("axes", ["x, z", "x, y, z", "x", "y"])
def test_no_tilt_of_gravity_against_periodic_axes_is_a_fault_of_packgen(run, axes, tilt):
    code, text = run(TILTED.format(axes=axes, gravity=[tilt, 0, -1]), "--export", "liggghts,lammps")
    assert code == 0, text
    assert "sorry" not in text
