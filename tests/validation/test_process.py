from __future__ import annotations

import json
import os
import time
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from packgen.cli import main
from packgen.errors import SolverError
from packgen.validation import Limits, find_solver, validate
from packgen.validation.process import SOLVERS, run_solver
from tests.exporters.beds import lattice

SCENE = """\
container: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
particle_sets: [{radius_distribution: constant, radius: 0.2}]
zones: [{n_particles: 5}]
"""


@pytest.fixture
def on_path(tmp_path, monkeypatch):
    """Put a shell script on the PATH in place of a solver."""

    def put(solver, script):
        program = tmp_path / "bin" / SOLVERS[solver][0]
        program.parent.mkdir(exist_ok=True)
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)
        monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")

    return put


@pytest.fixture(params=SOLVERS)
def fake(request, tmp_path, on_path):
    """Return what validates a small deck with a shell script as the solver, each solver in turn."""
    deck = tmp_path / "deck"
    deck.mkdir()
    for name in ("in.bed", "bed.py"):
        (deck / name).write_text("# nothing\n")

    def validate_with(script, **limits):
        on_path(request.param, script)
        with pytest.raises(SolverError, match=f"^{request.param}: ") as caught:
            validate(lattice(), deck, solver=request.param, limits=Limits(**limits))
        assert caught.value.exit_code == 1
        assert {path.name for path in deck.iterdir()} == {"in.bed", "bed.py"}
        return str(caught.value)

    return validate_with


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_missing_solver_is_exit_code_2_with_the_way_to_install_it(monkeypatch, tmp_path, solver):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SolverError, match=f"apt-get install {solver}") as caught:
        find_solver(solver)
    assert caught.value.exit_code == 2


def test_a_missing_solver_is_told_before_anything_is_made(monkeypatch, tmp_path, capsys):
    (tmp_path / "five.yaml").write_text(SCENE)
    monkeypatch.setenv("PATH", str(tmp_path))
    code = main(
        [str(tmp_path / "five.yaml"), "--validate", "--solver", "lammps", "-o", str(tmp_path / "out")]
    )
    assert code == 2
    assert "apt-get install lammps" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


FAILURES = {
    "refuses": ("echo 'ERROR: no such style'; exit 1", "stopped with exit code 1"),
    "is killed": ("kill -9 $$", "SIGKILL"),
    "prints garbage": ("head -c 9999 /dev/urandom", "ended without writing"),
    "hangs": ("sleep 60", "hangs: it said nothing for 0.5 s"),
}


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("failure", FAILURES)
def test_the_bed_outlives_a_solver_that_fails(tmp_path, monkeypatch, on_path, capsys, solver, failure):
    monkeypatch.setattr("packgen.validation.Limits", partial(Limits, silence_max=0.5))
    script, words = FAILURES[failure]
    (tmp_path / "five.yaml").write_text(SCENE)
    on_path(solver, script)
    out = tmp_path / "out"
    options = ["--validate", "--solver", solver, "-o", str(out), "--no-report", "--quiet"]
    code = main([str(tmp_path / "five.yaml"), *options])
    assert code == 1
    assert words in capsys.readouterr().err
    with np.load(out / "bed.npz") as bed:
        assert bed["position"].shape == (5, 3)
    assert list((out / solver).iterdir())
    verdict = json.loads((out / "validation.json").read_text())
    assert verdict["passed"] is False
    assert words in verdict["errors"][solver]
    assert words in " ".join(json.loads((out / "report.json").read_text())["missed"])


def test_an_unknown_solver_is_exit_code_2_with_the_choices():
    with pytest.raises(SolverError, match="found 'ligghts', expected one of liggghts, lammps") as caught:
        find_solver("ligghts")
    assert caught.value.exit_code == 2


def test_a_solver_that_refuses_the_deck_is_quoted(fake):
    message = fake(
        "echo Reading; echo 'ERROR: youngsModulus <= 1e9 required'; printf '\\377\\001\\n'; exit 1"
    )
    assert "exit code 1; it said:\nERROR: youngsModulus <= 1e9 required" in message
    assert message.isprintable() or message.replace("\n", "").isprintable()


def test_a_solver_that_is_killed_is_told_by_its_signal(fake):
    assert "ended by signal SIGKILL; was there enough memory?" in fake("echo 80 atoms; kill -9 $$")


def test_a_solver_that_hangs_is_ended(fake, tmp_path):
    number = tmp_path / "child"
    message = fake(f"echo Setting up; sleep 60 & echo $! > {number}; wait", silence_max=0.5)
    assert "hangs: it said nothing for 0.5 s and was ended; it said:\nSetting up" in message
    assert _has_ended(int(number.read_text()))


def _has_ended(process):
    """Whether a process is gone, or only waits to be collected by a parent that may never do so."""
    for _ in range(50):
        try:
            state = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0]
        except FileNotFoundError:
            return True
        if state in "ZX":
            return True
        time.sleep(0.02)
    return False


def test_a_solver_that_talks_for_ever_is_ended(tmp_path):
    with pytest.raises(SolverError, match="not done in 1 s"):
        run_solver("fake", ["sh", "-c", "while :; do echo y; done"], tmp_path, silence_max=9, seconds_max=1)


@pytest.mark.parametrize("output", ["head -c 300000 /dev/urandom", "echo all is well", "true"])
def test_a_solver_that_prints_garbage_and_says_all_is_well_is_not_believed(fake, output):
    assert "the solver ended without writing" in fake(f"{output}; exit 0")


def test_results_that_are_garbage_are_not_believed(fake):
    dump = "printf 'ITEM: NUMBER OF ATOMS\\n80\\nITEM: ATOMS id\\n1 2 nonsense\\n' > packgen_spheres.dump"
    assert "cannot be read" in fake(f"{dump}; echo nonsense > packgen_judge.npz")
