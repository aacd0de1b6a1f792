"""Runs that fail or are stopped: what is said, which exit code comes, and what is left."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import packgen.container
from packgen.cli import main
from packgen.errors import PackingError, SolverError
from tests.cli.scenes import report_of


def test_a_missing_solver_is_told_before_the_run(scene, core, capsys, monkeypatch):
    core(AssertionError("the run started"))

    def find_solver(name):
        raise SolverError(f"{name}: not found; apt-get install {name}", exit_code=2)

    monkeypatch.setattr("packgen.validation.find_solver", find_solver)
    assert main([scene, "--validate"]) == 2
    assert "apt-get install liggghts" in capsys.readouterr().err
    assert os.listdir() == ["box.yaml"]


def test_a_solver_that_crashes_leaves_the_bed_and_exit_code_1(scene, core, capsys, monkeypatch):
    core()

    def validate(*_, **__):
        raise SolverError("liggghts: killed by signal 11")

    monkeypatch.setattr("packgen.validation.find_solver", lambda _: Path("liggghts"))
    monkeypatch.setattr("packgen.validation.validate", validate)
    assert main([scene, "--validate", "--quiet"]) == 1
    assert "signal 11" in capsys.readouterr().err
    assert json.loads(Path("box/validation.json").read_text())["passed"] is False
    assert "validation.json" in report_of()["files"]
    assert Path("box/liggghts/in.bed").exists()


@pytest.mark.parametrize("fault", [KeyError("x"), SystemExit(3), OSError("gone")], ids=repr)
def test_an_exporter_that_fails_costs_its_deck_and_not_the_bed(scene, core, capsys, monkeypatch, fault):
    core()

    def write(*_):
        raise fault

    monkeypatch.setattr("exporters.csv.write", write)
    assert main([scene, "--export", "csv,mfix", "--quiet"]) == 1
    said = capsys.readouterr().err
    assert "missed: no csv deck: its exporter or a template failed, " + type(fault).__name__ in said
    assert sorted(path.name for path in Path("box").iterdir()) == [
        "bed.npz",
        "mfix",
        "report.html",
        "report.json",
    ]


def test_a_disk_that_fills_up_ends_the_run_with_a_remedy(scene, core, capsys, monkeypatch):
    core()

    def write(*_):
        raise OSError(errno.ENOSPC, "No space left on device", "bed.csv")

    monkeypatch.setattr("exporters.csv.write", write)
    assert main([scene, "--export", "csv", "--quiet"]) == 2
    assert "bed.csv: No space left on device; nothing was written; make room" in capsys.readouterr().err
    assert not Path("box").exists()


def test_a_validation_that_is_interrupted_leaves_the_bed_beside(scene, core, capsys, monkeypatch):
    core()

    def validate(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("packgen.validation.find_solver", lambda _: Path("liggghts"))
    monkeypatch.setattr("packgen.validation.validate", validate)
    assert main([scene, "--validate", "--solver", "liggghts,yade", "--quiet"]) == 130
    lines = capsys.readouterr().err.splitlines()
    assert "missed: liggghts: interrupted before it was done" in lines[0]
    assert lines[-1].endswith(f"it is in {Path('box.unvalidated').resolve()}")
    found = json.loads(Path("box.unvalidated/validation.json").read_text())
    assert (found["passed"], found["interrupted"], list(found["errors"])) == (False, True, ["liggghts"])
    assert not Path("box").exists()


@pytest.mark.parametrize(
    ("outcome", "code", "said"),
    [
        (KeyboardInterrupt(), 130, "interrupted"),
        (PackingError("nothing fits"), 2, "nothing fits"),
        (OSError(errno.ENOSPC, "No space left on device", "box/bed.npz"), 2, "No space left"),
        (MemoryError(), 2, "memory"),
        (ZeroDivisionError("oops"), 2, "PACKGEN_DEBUG"),
    ],
)
def test_a_run_that_fails_leaves_nothing_and_one_line(scene, core, capsys, outcome, code, said):
    core(outcome)
    assert main([scene, "--export", "liggghts", "-o", "deep/box"]) == code
    error = capsys.readouterr().err
    assert len(error.splitlines()) == 1
    assert said in error
    assert "Traceback" not in error
    assert os.listdir() == ["box.yaml"]


def test_a_failed_run_leaves_the_earlier_results(scene, core):
    core()
    main([scene, "--quiet"])
    before = Path("box/bed.npz").read_bytes()
    core(KeyboardInterrupt())
    assert main([scene, "--seed", "9"]) == 130
    assert Path("box/bed.npz").read_bytes() == before
    assert sorted(os.listdir()) == ["box", "box.yaml"]


WAITING_CORE = """
import sys, time
import packgen.filling.pack as core
def pack(scene, container, **_):
    print("started", flush=True)
    time.sleep(60)
core.pack = pack
from packgen.cli import main
sys.exit(main(["box.yaml", "--export", "liggghts"]))
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_stops_the_run_without_a_trace(scene, number):
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).resolve().parents[2])}
    run = subprocess.Popen(
        [sys.executable, "-c", WAITING_CORE],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=environment,
    )
    assert run.stdout.readline() == "started\n"
    time.sleep(0.2)  # it prints before it sleeps
    run.send_signal(number)
    _, error = run.communicate(timeout=20)
    assert run.returncode == 130
    assert "interrupted" in error
    assert os.listdir() == ["box.yaml"]


def test_a_reader_that_goes_away_is_no_error(scene, core, monkeypatch):
    core()
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, "w") as closed:
        monkeypatch.setattr(sys, "stdout", closed)
        assert main([scene]) == 0
    assert np.load("box/bed.npz")["radius"].shape == (125,)


def test_a_periodic_box_that_a_format_refuses_ends_the_run_before_it_starts(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path("seam.yaml").write_text(
        "container: {box: {min: [0, 0, 0], max: [1, 1, 1]}, periodic: [x]}\n"
        "particle_sets: [{radius_distribution: constant, radius: 0.1}]\n"
    )
    assert main(["seam.yaml", "--export", "yade"]) == 2
    assert "yade: the box wraps around along some axes only" in capsys.readouterr().err
    assert os.listdir() == ["seam.yaml"]


def test_what_was_mended_is_said_once_before_the_error_that_it_may_explain(scene, core, capsys, monkeypatch):
    core(PackingError("nothing fits"))
    load = packgen.container.load_container
    monkeypatch.setattr(
        "packgen.container.load_container", lambda given, warn: (warn("mended"), load(given))[1]
    )
    assert main([scene, "--quiet"]) == 2
    assert capsys.readouterr().err.splitlines() == ["packgen: warning: mended", "packgen: nothing fits"]
