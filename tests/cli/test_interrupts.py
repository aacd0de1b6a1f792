"""Real signals at every stage of a run: what is left, what is said, and the exit code."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

from tests.cli.processes import REAL, start, wait_for
from tests.cli.scenes import SCENE

pytestmark = pytest.mark.slow  # each starts processes
STOPS = [signal.SIGINT, signal.SIGTERM, signal.SIGHUP]
BOUND = 30  # seconds; ten times what the slowest machine needs


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """A scene in an otherwise empty folder, with a place of its own for temporary folders."""
    (tmp_path / "tmp").mkdir()
    (tmp_path / "work").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    monkeypatch.chdir(tmp_path / "work")
    Path("box.yaml").write_text(SCENE)
    return "box.yaml"


def stopped(
    run: subprocess.Popen[str], number: int = signal.SIGTERM, times: int = 1
) -> tuple[int, list[str]]:
    """Send a signal; return the exit code and the lines on standard error."""
    for _ in range(times):
        run.send_signal(number)
    _, error = run.communicate(timeout=BOUND)
    return run.returncode, error.splitlines()


@pytest.mark.parametrize("times", [1, 3])
@pytest.mark.parametrize("how", ["as it is", "another error", "lost", "not heard"])
def test_a_stop_ends_the_run_whatever_code_makes_of_it(scene, how, times):
    run = start(scene, "-o", "deep/box", LATTICE_WAIT=how)
    assert stopped(run, times=times) == (130, ["packgen: interrupted, nothing was written"])
    assert os.listdir() == ["box.yaml"]


@pytest.mark.parametrize("number", STOPS)
def test_an_earlier_result_survives_a_stop(scene, number):
    start(scene, "--quiet").communicate()
    before = Path("box/bed.npz").stat().st_mtime_ns
    assert stopped(start(scene, LATTICE_WAIT="as it is"), number)[0] == 130
    assert Path("box/bed.npz").stat().st_mtime_ns == before
    assert sorted(os.listdir()) == ["box", "box.yaml"]


@pytest.mark.parametrize("number", STOPS)
@pytest.mark.parametrize(
    ("place", "seconds"),
    [
        ("pathlib:Path.rename", "2"),  # the result is about to have its name
        ("packgen.resultfolder:ResultFolder.commit", "2"),
        ("packgen.cli.run:conclude", "60"),
    ],
)
def test_a_stop_after_the_bed_has_its_name_says_so_and_keeps_its_exit_code(scene, place, seconds, number):
    run = start(scene, "--quiet", LATTICE_PAUSE=place, LATTICE_SECONDS=seconds)
    code, lines = stopped(run, number)
    assert lines == [f"packgen: interrupted, but the bed is in {Path.cwd() / 'box'}"]
    assert code == 0
    assert sorted(os.listdir()) == ["box", "box.yaml"]


@pytest.mark.parametrize("both", [False, True])
def test_a_stop_ends_a_run_whose_summary_nobody_reads(scene, both):
    read, write = os.pipe()
    os.set_blocking(write, False)
    try:
        while True:
            os.write(write, bytes(4096))
    except BlockingIOError:
        os.set_blocking(write, True)
    from tests.cli.processes import LATTICE, environment

    error = write if both else subprocess.PIPE
    run = subprocess.Popen([*LATTICE, scene], stdout=write, stderr=error, text=True, env=environment())
    wait_for(Path("box"), run)
    code, lines = stopped(run) if not both else (run.terminate(), run.wait(timeout=BOUND))[::-1]
    os.close(read)
    os.close(write)
    assert code == 0
    assert both or lines == [f"packgen: interrupted, but the bed is in {Path.cwd() / 'box'}"]


SOLVER = '#!/bin/sh\necho $$ >"$SOLVER_MARK.part"; mv "$SOLVER_MARK.part" "$SOLVER_MARK"\nexec sleep 60\n'


@pytest.fixture
def validating(scene, tmp_path, monkeypatch):
    """Return what starts a run, and returns once its solver, which takes an hour, runs."""
    program = tmp_path / "bin" / "liggghts"
    program.parent.mkdir()
    program.write_text(SOLVER)
    program.chmod(0o755)
    mark = tmp_path / "solver"
    monkeypatch.setenv("PATH", f"{program.parent}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("SOLVER_MARK", str(mark))

    def run(*arguments):
        mark.unlink(missing_ok=True)
        process = start(scene, "--validate", *arguments)
        wait_for(mark, process)
        return process, int(mark.read_text())

    return run


def is_running(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def assert_unjudged(folder: Path) -> None:
    assert json.loads((folder / "validation.json").read_text())["interrupted"] is True
    report = json.loads((folder / "report.json").read_text())
    assert {"bed.npz", "report.json", "validation.json", "liggghts/in.bed"} <= set(report["files"])
    assert all((folder / name).exists() for name in report["files"])
    assert report["missed"] == ["liggghts: interrupted before it was done"]


@pytest.mark.parametrize("number", STOPS)
def test_an_interrupted_validation_leaves_the_earlier_result_and_the_bed_beside_it(scene, validating, number):
    start(scene, "--quiet").communicate()
    before = {path: path.stat().st_mtime_ns for path in Path("box").iterdir()}
    for _ in range(2):  # the second replaces the first one's bed
        run, solver = validating("--quiet")
        code, lines = stopped(run, number)
        assert code == 130
        assert str(Path.cwd() / "box.unvalidated") in lines[-1]
        assert not is_running(solver)
        assert {path: path.stat().st_mtime_ns for path in Path("box").iterdir()} == before
        assert_unjudged(Path("box.unvalidated"))
        assert sorted(os.listdir()) == ["box", "box.unvalidated", "box.yaml"]
        assert os.listdir(os.environ["TMPDIR"]) == []


def test_an_interrupted_first_validation_gives_no_bed_the_final_name(scene, validating):
    run, _ = validating()
    code, lines = stopped(run, times=3)
    assert code == 130
    assert (
        lines[-1]
        == f"packgen: interrupted before the bed was judged, it is in {Path.cwd() / 'box.unvalidated'}"
    )
    assert_unjudged(Path("box.unvalidated"))
    assert sorted(os.listdir()) == ["box.unvalidated", "box.yaml"]


def test_an_unvalidated_folder_with_files_of_others_stays(scene, validating):
    Path("box.unvalidated").mkdir()
    Path("box.unvalidated/notes").write_text("mine")
    run, _ = validating("--quiet")
    code, lines = stopped(run)
    assert (code, os.listdir("box.unvalidated")) == (130, ["notes"])
    assert lines[-1].endswith("box.unvalidated2")
    assert_unjudged(Path("box.unvalidated2"))


@pytest.mark.skipif(
    not Path("/proc/self/stat").exists(), reason="the system does not tell when a process started"
)
def test_the_next_run_removes_leftovers_of_killed_runs_and_spares_living_ones(scene, validating):
    killed, solver = validating("--quiet")
    living, _ = validating("--quiet")
    killed.kill()
    killed.communicate()
    os.kill(solver, signal.SIGKILL)
    assert len([name for name in os.listdir() if "unfinished" in name]) == 2
    assert len(os.listdir(os.environ["TMPDIR"])) == 2
    start(scene, "--quiet").communicate()
    (name,) = [name for name in os.listdir() if "unfinished" in name]
    assert f"-{living.pid:x}-" in name
    assert len(os.listdir(os.environ["TMPDIR"])) == 1
    stopped(living)
    assert sorted(os.listdir()) == ["box", "box.unvalidated", "box.yaml"]


@pytest.mark.parametrize("delay", [0.3, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0])
def test_a_real_run_ends_at_any_moment_with_one_line(scene, tmp_path, monkeypatch, delay):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))  # it compiles, which takes seconds
    Path(scene).write_text(SCENE.replace("125", "60"))
    run = start(scene, "--quiet", program=REAL)
    time.sleep(delay)
    if run.poll() is None:
        code, lines = stopped(run)
        if code == -signal.SIGTERM:  # before packgen's first line ran
            assert lines == []
        elif not Path("box").exists():
            assert (code, lines) == (130, ["packgen: interrupted, nothing was written"])
    assert not [name for name in os.listdir() if name.startswith(".")]
