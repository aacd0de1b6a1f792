"""``packgen sweep``; the runs are made in this process, with a lattice for a core."""

from __future__ import annotations

import csv
import json
import os
from pathlib import Path

import pytest

from packgen.cli import main
from packgen.sweep import processes
from packgen.sweep.processes import Ended
from tests.cli.scenes import SCENE
from tests.seeds import raised


@pytest.fixture
def runs(core, monkeypatch, capsys):
    """The arguments of the runs that a sweep has made."""
    core()
    made = []

    def run_all(commands, jobs):
        for run, arguments in commands:
            made.append(run.name)
            code = main(arguments)
            yield Ended(run, code, capsys.readouterr().err)

    monkeypatch.setattr(processes, "run_all", run_all)
    return made


def table(folder="box.sweep"):
    with Path(folder, "sweep.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


def test_each_combination_has_a_folder_and_a_line(scene, runs):
    assert main(["sweep", scene, "--over", "seed=0:2", "--over", "gravity=9.81,1.62", "--quiet"]) == 0
    names = [f"seed={seed}_gravity={gravity}" for seed in range(3) for gravity in (9.81, 1.62)]
    assert runs == names
    assert set(os.listdir("box.sweep")) == {*names, "sweep.csv"}
    rows = table()
    assert [(row["folder"], row["seed"], row["gravity"]) for row in rows[:2]] == [
        ("seed=0_gravity=9.81", "0", "9.81"), ("seed=0_gravity=1.62", "0", "1.62"),
    ]  # fmt: skip
    assert {row["sphere_count"] for row in rows} == {"125"}
    report = json.loads(Path("box.sweep", names[1], "report.json").read_text())
    assert report["settings"]["seed"] == raised(0)


def test_a_wrong_combination_has_its_line_and_stops_no_other(scene, runs, capsys):
    assert main(["sweep", scene, "--over", "seed=0,-1,2"]) == 1
    rows = table()
    assert [row["exit_code"] for row in rows] == ["0", "2", "0"]
    assert rows[1]["message"].startswith("--over seed: found -1, expected a whole number")
    assert rows[1]["sphere_count"] == ""


def test_a_run_that_fails_has_its_line_and_stops_no_other(scene, runs, capsys):
    Path("box.sweep/seed=1").mkdir(parents=True)
    Path("box.sweep/seed=1/notes.txt").write_text("mine")
    assert main(["sweep", scene, "--over", "seed=0:2", "--quiet"]) == 1
    rows = table()
    assert [row["exit_code"] for row in rows] == ["0", "2", "0"]
    assert "has files that packgen did not write (notes.txt)" in rows[1]["message"]
    assert os.listdir("box.sweep/seed=1") == ["notes.txt"]


def test_a_value_that_is_wrong_in_every_run_is_the_command_lines_fault(scene, runs, capsys):
    assert main(["sweep", scene, "--over", "sede=1,2", "--over", "gravity=1"]) == 2
    assert capsys.readouterr().err.startswith("packgen: --over sede: found an unknown key")
    assert os.listdir() == ["box.yaml"]


def stored(scene, runs):
    """Give folders of the lattice the settings that the core would have stored."""
    from packgen.bedfile import plain
    from packgen.scene import load_scene

    for name in runs:
        path = Path("box.sweep", name, "report.json")
        report = json.loads(path.read_text())
        seed = name.removeprefix("seed=")
        report["settings"]["settings"] = plain(load_scene(Path(scene), [f"seed={seed}"]).model_dump())
        path.write_text(json.dumps(report))


def test_what_is_complete_is_not_run_again_unless_the_scene_has_changed(scene, runs, capsys):
    assert main(["sweep", scene, "--over", "seed=0:1", "--quiet"]) == 0
    stored(scene, runs)
    runs.clear()
    assert main(["sweep", scene, "--over", "seed=0:2"]) == 0
    assert runs == ["seed=2"]
    assert [row["folder"] for row in table()] == ["seed=0", "seed=1", "seed=2"]
    stored(scene, ["seed=2"])
    runs.clear()
    assert main(["sweep", scene, "--over", "seed=0:2", "--export", "liggghts", "--quiet"]) == 0
    assert len(runs) == 3  # none had the deck
    runs.clear()
    Path(scene).write_text(SCENE.replace("n_particles: 125", "n_particles: 124"))
    assert main(["sweep", scene, "--over", "seed=0:2", "--quiet"]) == 0
    assert len(runs) == 3


def test_the_table_as_json_is_all_of_standard_output(scene, runs, capsys, monkeypatch):
    shown = []
    monkeypatch.setattr("packgen.cli.sweep.say_json", shown.append)
    assert main(["sweep", scene, "--over", "seed=0:1", "--json", "--quiet"]) == 0
    assert [each["seed"] for each in shown[0]["runs"]] == ["0", "1"]
    assert shown[0]["folder"] == os.path.abspath("box.sweep")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ([], "--over: found none, expected a key and its values"),
        (["--over", "seed=9:0"], "--over seed: found 9:0, expected the lower end first, 0:9"),
        (["--over", "seed=1", "--set", "seed=2"], "--set seed: found beside --over seed"),
        (["--over", "seed=1", "-o", "box.yaml"], "is a file, expected a folder"),
        (["--over", "seed=1", "--export", "stone"], "stone"),
        (["--over", "seed=1", "--solver", "liggghts"], "--validate"),
    ],
)
def test_a_wrong_command_line_is_told_and_nothing_is_written(scene, runs, capsys, arguments, said):
    assert main(["sweep", scene, *arguments]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert os.listdir() == ["box.yaml"]


def test_all_wrong_ranges_are_told_at_once(scene, runs, capsys):
    assert main(["sweep", scene, "--over", "seed=9:0", "--over", "gravity=1,,2"]) == 2
    assert len(capsys.readouterr().err.splitlines()) == 2


def test_the_result_of_one_run_or_a_foreign_table_is_no_folder_of_a_sweep(scene, runs, capsys):
    assert main([scene, "--quiet"]) == 0
    assert main(["sweep", scene, "--over", "seed=1", "-o", "box"]) == 2
    assert "is the result of one run" in capsys.readouterr().err
    Path("mine").mkdir()
    Path("mine/sweep.csv").write_text("a,b\n")
    assert main(["sweep", scene, "--over", "seed=1", "-o", "mine"]) == 2
    assert Path("mine/sweep.csv").read_text() == "a,b\n"
