"""Runs that processes share: what is refused before they start, and what an interrupted one leaves."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from packgen.cli import main
from tests.cli.processes import REAL, environment, start

WIDE = """
container: {box: {min: [0, 0, 0], max: [8, 1, 3]}}
particle_sets:
  - {radius_distribution: constant, radius: 0.05}
params: {tile: 20}
zones:
  - {n_particles: 9000}
"""
BOUND = 120  # seconds; many times what a slow machine needs


def test_a_run_is_shared_where_it_says_so_alone(scene, core):
    given = {}
    core(called_with=given)
    assert main([scene, "--quiet"]) == 0
    assert given["crew"] is None


def test_processes_get_a_folder_beside_the_results_which_goes_with_the_end(scene, core):
    pytest.importorskip("distributed")
    given = {}
    core(called_with=given)
    assert main([scene, "--quiet", "--workers", "2", "--threads", "3"]) == 0
    assert given["crew"].folder == Path("box.parts").absolute()
    assert given["crew"].threads == 3
    assert sorted(os.listdir()) == ["box", "box.yaml"]


def test_a_shared_run_that_fails_before_its_first_unit_leaves_nothing(scene, core, capsys):
    pytest.importorskip("distributed")
    core(ValueError("no"))
    assert main([scene, "--workers", "2"]) == 2
    assert "no; nothing was written" in capsys.readouterr().err
    assert os.listdir() == ["box.yaml"]


def test_a_shared_run_that_fails_later_keeps_its_parts_and_says_so(scene, core, capsys, monkeypatch):
    pytest.importorskip("distributed")
    core(ValueError("no"))
    monkeypatch.setattr("packgen.workers.parts.Parts.begun", True)
    assert main([scene, "--workers", "2"]) == 2
    assert f"what is done is in {Path('box.parts').absolute()}, --resume" in capsys.readouterr().err
    assert sorted(os.listdir()) == ["box.parts", "box.yaml"]
    core()
    assert main([scene, "--workers", "2"]) == 2
    assert "give --resume to go on with it" in capsys.readouterr().err
    assert main([scene, "--quiet", "--workers", "2", "--resume"]) == 0
    assert sorted(os.listdir()) == ["box", "box.yaml"]


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (["--workers", "2", "--scheduler", "tcp://here"], "--workers: found with --scheduler; leave one"),
        (["--resume"], "--resume: found without --workers or --scheduler; add the one of the first run"),
        (["--workers", "2", "--resume"], "found no parts of an earlier run, expected some"),
    ],
)
def test_options_that_do_not_go_together_are_refused(scene, core, capsys, options, expected):
    core(AssertionError("the run started"))
    assert main([scene, *options]) == 2
    assert expected in capsys.readouterr().err
    assert os.listdir() == ["box.yaml"]


def test_a_vessel_too_narrow_for_tiles_is_refused_before_processes_start(scene, capsys):
    pytest.importorskip("distributed")
    assert main([scene, "--workers", "2"]) == 2
    [line] = [each for each in capsys.readouterr().err.splitlines() if "not supported" in each]
    assert "found a width of 1 m, expected at least 12 m for two tiles" in line
    assert os.listdir() == ["box.yaml"]


def units_done(folder):
    return len(list(folder.glob("layer_*_0000.npz")))


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_shared_run_that_is_stopped_goes_on_with_resume(tmp_path, monkeypatch, number):
    pytest.importorskip("distributed")
    monkeypatch.chdir(tmp_path)
    Path("wide.yaml").write_text(WIDE)
    run = start("wide.yaml", "--workers", "2", "--quiet", program=REAL)
    end = time.monotonic() + BOUND
    while units_done(Path("wide.parts")) < 3:
        assert run.poll() is None, run.communicate()
        assert time.monotonic() < end
        time.sleep(0.02)
    run.send_signal(number)
    _, error = run.communicate(timeout=BOUND)
    if number == signal.SIGINT:
        kept = f"what is done is in {Path('wide.parts').absolute()}, --resume goes on with it"
        assert (run.returncode, error) == (130, f"packgen: interrupted, {kept}\n")
    assert units_done(Path("wide.parts")) >= 3
    for name, options in (("wide", ["--workers", "1", "--resume"]), ("one", [])):
        command = [*REAL, "wide.yaml", "-o", name, "--quiet", "--no-report", *options]
        subprocess.run(command, env=environment(), check=True, timeout=BOUND)
    assert Path("wide/bed.npz").read_bytes() == Path("one/bed.npz").read_bytes()
    assert sorted(each for each in os.listdir() if not each.startswith(".")) == ["one", "wide", "wide.yaml"]
