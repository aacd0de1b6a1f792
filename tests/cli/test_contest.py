"""``packgen contest``; the runs are made in this process, with a lattice for a core."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from packgen.cli import main
from packgen.sweep import processes
from packgen.sweep.processes import Ended
from tests.cli.scenes import SCENE
from tests.seeds import raised

BOTH = ["--algorithms", "COLLECTIVE_ARRANGEMENT,DISPERSED"]


@pytest.fixture
def runs(core, monkeypatch, capsys):
    """The names and arguments of the runs that a contest has made."""
    core()
    made = {}

    def run_all(commands, jobs):
        for run, arguments in commands:
            made[run.name] = arguments
            code = main(arguments)
            yield Ended(run, code, capsys.readouterr().err)

    monkeypatch.setattr(processes, "run_all", run_all)
    return made


def test_each_algorithm_has_each_seed_one_seed_of_all_before_the_next(scene, runs, capsys):
    assert main(["contest", scene, *BOTH, "--seeds", "2", "--set", "seed=3", "--quiet"]) == 0
    seeds = (raised(3), raised(4))
    names = [f"{name}_seed={seed}" for seed in seeds for name in ("COLLECTIVE_ARRANGEMENT", "DISPERSED")]
    assert list(runs) == names
    with Path("box.contest", "contest.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["algorithm"], row["seed"], row["sphere_count"]) for row in rows[:2]] == [
        ("COLLECTIVE_ARRANGEMENT", str(seeds[0]), "125"), ("DISPERSED", str(seeds[0]), "125"),
    ]  # fmt: skip


def test_the_scenes_own_algorithm_keeps_its_settings_and_another_has_the_tolerance(scene, runs):
    Path(scene).write_text(SCENE + "params: {tolerance: 1.0e-4, lr: 0.02}\n")
    assert main(["contest", scene, *BOTH, "--quiet"]) == 0
    own, other = runs.values()
    assert not [each for each in own if each.startswith("params")]
    assert "params={tolerance: 0.0001}" in other
    page = Path("box.contest", "contest.html").read_text()
    assert "<td>lr: 0.02</td>" in page
    assert "<td>defaults</td>" in page


def test_one_that_cannot_do_the_scene_says_why_and_stops_no_other(scene, runs, capsys):
    Path(scene).write_text(SCENE.replace("n_particles: 125", "n_particles: 125, gap: 0.1"))
    assert main(["contest", scene, *BOTH, "--set", "algorithm=DISPERSED"]) == 0
    assert list(runs) == [f"DISPERSED_seed={raised(7)}"]
    shown = capsys.readouterr().out
    assert "COLLECTIVE_ARRANGEMENT: " in shown
    assert "gap" in shown.split("COLLECTIVE_ARRANGEMENT: ")[1].splitlines()[0]
    page = Path("box.contest", "contest.html").read_text()
    row = next(line for line in page.splitlines() if "<tr>" in line and ">COLLECTIVE_ARRANGEMENT<" in line)
    assert "gap" in row.split('class="reason"')[1]
    assert "What was missed" not in page
    assert f'href="DISPERSED_seed={raised(7)}/report.html"' in page


def test_the_standings_as_json_have_every_bed(scene, runs, monkeypatch):
    shown = []
    monkeypatch.setattr("packgen.cli.contest.say_json", shown.append)
    assert main(["contest", scene, *BOTH, "--seeds", "2", "--json", "--quiet"]) == 0
    first = shown[0]["algorithms"][0]
    assert (first["algorithm"], first["may_change"], len(first["beds"])) == (
        "COLLECTIVE_ARRANGEMENT", "nothing", 2,
    )  # fmt: skip
    json.dumps(shown[0])


def test_unknown_algorithms_are_told_at_once_and_nothing_is_written(scene, runs, capsys):
    assert main(["contest", scene, "--algorithms", "POURED,DISPERSED,SHAKEN"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(", expected")[0] for line in lines] == [
        "packgen: --algorithms: found 'POURED'", "packgen: --algorithms: found 'SHAKEN'",
    ]  # fmt: skip
    assert not Path("box.contest").exists()


def test_a_scene_that_no_algorithm_can_do_is_refused(scene, runs, capsys):
    Path(scene).write_text(SCENE.replace("n_particles: 125", "n_particles: 125, solid_fraction: 0.3"))
    assert main(["contest", scene, "--algorithms", "ADAM,JAMMED", "--set", "algorithm=DISPERSED"]) == 2
    assert "solid_fraction" in capsys.readouterr().err
    assert not Path("box.contest").exists()
