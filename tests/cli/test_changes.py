"""``--set`` and ``--json`` of a run; the core is a lattice."""

from __future__ import annotations

import json
import os

from packgen.cli import main
from packgen.summary import FIGURES
from tests.cli.scenes import report_of
from tests.seeds import raised


def test_values_of_the_command_line_shape_the_bed_and_are_in_its_report(scene, core):
    core()
    assert main([scene, "--set", "container.box.max=[2, 2, 2]", "--set", "seed=5", "--quiet"]) == 0
    report = report_of()
    assert report["settings"]["seed"] == raised(5)
    assert report["solid_fraction"]["filled"] < 0.4  # the same spheres in a wider box


def test_wrong_values_of_the_command_line_are_told_together_and_nothing_is_written(scene, core, capsys):
    core(AssertionError("the run started"))
    given = ["--set", "zones[0].n_particels=5", "--set", "seed=-1", "--set", "zones[4].mass=1"]
    assert main([scene, *given]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 3
    assert all(line.startswith("packgen: --set ") for line in lines)
    assert os.listdir() == ["box.yaml"]


def test_seed_comes_from_one_option(scene, core, capsys):
    assert main([scene, "--seed", "3", "--set", "seed=4"]) == 2
    assert capsys.readouterr().err == "packgen: --seed: found beside --set seed; leave one of them out\n"


def test_an_amount_of_the_command_line_that_cannot_fit_names_the_option(scene, capsys):
    assert main([scene, "--set", "zones[0].n_particles=500"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("packgen: --set zones[0].n_particles: found 500, expected at most")


def test_the_summary_is_one_json_object_on_standard_output(scene, core, capsys):
    core(placed=100, warnings=("a warning",))
    assert main([scene, "--json"]) == 1
    shown = capsys.readouterr()
    found, report = json.loads(shown.out), report_of()
    assert set(FIGURES) < set(found)
    assert (found["exit_code"], found["folder"], found["seed"]) == (1, os.path.abspath("box"), raised(7))
    assert (found["sphere_count"], found["asked"]) == (100, 125)
    assert found["missed"] == report["missed"]
    assert found["warnings"] == report["warnings"]
    assert found["solid_fraction_filled"] == report["solid_fraction"]["filled"]
    assert "missed" in shown.err
