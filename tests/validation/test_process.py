from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from packgen.errors import SolverError
from packgen.validation import Limits, find_solver, validate
from packgen.validation.process import run_solver
from tests.exporters.beds import lattice


@pytest.fixture
def fake(tmp_path, monkeypatch):
    """Put a shell script on the PATH as liggghts, and return what validates a small deck with it."""
    deck = tmp_path / "deck"
    deck.mkdir()
    (deck / "in.bed").write_text("# nothing\n")

    def validate_with(script, **limits):
        program = tmp_path / "bin" / "liggghts"
        program.parent.mkdir()
        program.write_text(f"#!/bin/sh\n{script}\n")
        program.chmod(0o755)
        monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")
        with pytest.raises(SolverError) as caught:
            validate(lattice(), deck, limits=Limits(**limits))
        assert caught.value.exit_code == 1
        assert [path.name for path in deck.iterdir()] == ["in.bed"]
        return str(caught.value)

    return validate_with


def test_a_missing_solver_is_exit_code_2_with_the_way_to_install_it(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(SolverError, match="apt-get install liggghts") as caught:
        find_solver("liggghts")
    assert caught.value.exit_code == 2


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
    assert "ended without writing packgen_spheres.dump" in fake(f"{output}; exit 0")


def test_a_dump_that_is_garbage_is_not_believed(fake):
    script = "printf 'ITEM: NUMBER OF ATOMS\\n80\\nITEM: ATOMS id\\n1 2 nonsense\\n' > packgen_spheres.dump"
    assert "packgen_spheres.dump that cannot be read" in fake(script)
