"""``--settle``: what a run does with the bed that a solver has settled, has not, or was stopped at."""

from __future__ import annotations

import json
import os
import shutil
import signal
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from packgen.cli import build_parser, main
from packgen.cli.options import run_options
from packgen.errors import SolverError
from packgen.reading.known import known_by_provenance
from packgen.scene import load_scene
from packgen.settlement import DEM_TOLERANCE
from packgen.settling.run import Settled
from packgen.validation.results import Limits
from tests.cli.processes import start, wait_for
from tests.cli.scenes import SCENE, report_of
from tests.cli.test_interrupts import stopped

DEEP = 0.01  # radii


def lowered(bed, deepest=DEEP):
    """The bed with its lowest spheres in the floor."""
    position = bed.position.copy()
    position[position[:, 2] == position[:, 2].min(), 2] -= deepest * bed.radius[0]
    return replace(bed, position=position)


@pytest.fixture
def solver(monkeypatch):
    """Replaces the solver by one that lowers the bed, or raises; returns what it was called with."""

    def install(outcome=None, *, deepest=DEEP, **changes):
        called = {}

        def settle(bed, folder, *, solver, time, on_progress):
            called.update(folder=folder, files=sorted(os.listdir(folder)), solver=solver, time=time)
            if outcome is not None:
                raise outcome
            state = folder / "state.restart"
            state.write_text("state")
            found = Settled(
                bed=lowered(bed, deepest), solver=solver, version="LIGGGHTS 3", time=0.5, steps=10,
                free_fall_times=3.5, speed=5e-5, still=True, interrupted=False, displacement_mean=0.02,
                displacement_max=0.04, restart=state,
            )  # fmt: skip
            return replace(found, **changes)

        monkeypatch.setattr("packgen.settling.settle", settle)
        monkeypatch.setattr("packgen.validation.find_solver", lambda name, option="": Path(name))
        return called

    return install


def test_the_settled_bed_becomes_the_bed_with_its_overlaps_and_the_tolerance_of_soft_spheres(
    scene, core, solver, capsys
):
    core()
    called = solver()
    assert main([scene, "--settle", "liggghts", "--export", "csv"]) == 0
    assert called["files"] == ["bed.data", "in.bed", "wall.stl"]
    assert (called["solver"], called["time"]) == ("liggghts", None)
    report = report_of()
    assert report["overlap"]["wall_overlap_max"] == pytest.approx(DEEP)
    assert report["overlap"]["tolerance"] == DEM_TOLERANCE
    assert report["overlap"]["within_tolerance"]
    with np.load("box/bed.npz") as bed:
        assert bed["position"][:, 2].min() == pytest.approx(0.1 - 0.1 * DEEP)
        assert (bed["radius"] == 0.1).all()
        provenance = json.loads(str(bed["provenance"]))["settled"]
    assert (provenance["solver"], provenance["still"]) == ("liggghts", True)
    assert provenance["tolerance"] == DEM_TOLERANCE
    rows = np.loadtxt("box/liggghts/bed.data", skiprows=12)
    assert rows[:, 6].min() == pytest.approx(0.1 - 0.1 * DEEP)  # the deck is the settled bed's
    assert Path("box/liggghts/settled.restart").read_text() == "state"
    assert "liggghts/settled.restart" in report["files"]
    assert not [name for name in report["files"] if "settling" in name]
    said = capsys.readouterr().out
    assert "(DEM bed, at most 0.2)" in said
    assert "still after 0.5 s (3.5 free-fall times)" in said


def test_before_and_after_stand_side_by_side_in_report_summary_and_page(scene, core, solver, capsys):
    core()
    solver()
    assert main([scene, "--settle", "liggghts"]) == 0
    found = report_of()["settling"]
    assert (found["before"]["wall_overlap_max"], found["after"]["wall_overlap_max"]) == pytest.approx(
        (0, DEEP)
    )
    for key in ("solid_fraction", "contacts", "top", "overlap_max", "seconds"):
        assert {key} <= found["before"].keys() & found["after"].keys()
    assert found["restart"] == "liggghts/settled.restart"
    assert "packed, settled: largest overlap with a wall" in capsys.readouterr().out
    page = Path("box/report.html").read_text()
    assert "Settled by LIGGGHTS 3: still" in page
    assert " r</td><td>0.01 r</td>" in page
    assert "DEM bed, at most 0.2 r" in page
    assert main(["report", "box"]) == 0  # from the folder alone
    assert "Settled by LIGGGHTS 3: still" in Path("box/report.html").read_text()


def test_the_settled_bed_is_measured_by_its_own_tolerance_later(scene):
    settings = {"settings": load_scene(Path(scene)).model_dump()}
    assert known_by_provenance(settings).tolerance == 1e-6
    for tolerance in (DEM_TOLERANCE, None):
        assert known_by_provenance({**settings, "settled": {"tolerance": tolerance}}).tolerance == tolerance


def test_a_run_without_it_has_nothing_of_it(scene, core):
    core()
    assert main([scene, "--quiet"]) == 0
    assert report_of()["settling"] is None
    assert "Settled by" not in Path("box/report.html").read_text()


def test_overlaps_of_faults_are_missed_unless_the_scene_allows_soft_spheres(scene, core, solver, capsys):
    core()
    solver(deepest=0.3)
    assert main([scene, "--settle", "liggghts", "--quiet"]) == 1
    assert "in the wall by 0.3 of its radius, tolerance 0.2" in capsys.readouterr().err
    Path(scene).write_text(SCENE + "allow_soft: true\n")
    assert main([scene, "--settle", "liggghts", "--quiet"]) == 0
    assert report_of()["overlap"]["tolerance"] is None


def test_a_solver_that_fails_costs_no_bed_and_is_told_in_a_line(scene, core, solver, capsys):
    core()
    solver(SolverError("liggghts: 3 of 125 spheres were lost"))
    assert main([scene, "--settle", "liggghts", "--quiet"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line == (
        "packgen: missed: not settled, the bed is as it was packed: liggghts: 3 of 125 spheres were lost"
    )
    report = report_of()
    assert (report["settling"], report["overlap"]["tolerance"]) == (None, 1e-6)
    assert sorted(os.listdir("box")) == ["bed.npz", "liggghts", "report.html", "report.json"]


def test_a_bed_that_is_not_still_is_missed_and_one_settled_for_a_time_is_not(scene, core, solver, capsys):
    core()
    called = solver(still=False, speed=0.2)
    assert main([scene, "--settle", "liggghts", "--quiet"]) == 1
    assert "liggghts: the bed is not still after 0.5 s" in capsys.readouterr().err
    assert main([scene, "--settle", "liggghts", "--until", "20 ms", "--quiet"]) == 0
    assert called["time"] == 0.02
    assert report_of()["settling"]["until"] == "0.02 s"


def test_forces_of_a_settled_bed_are_no_fault_unless_the_scene_says_so(scene, core, solver, monkeypatch):
    core()
    solver()
    seen = []

    def validate(_bed, _deck, *, limits, **_):
        seen.append(limits.force_limit)
        raise SolverError("enough")

    monkeypatch.setattr("packgen.validation.validate", validate)
    assert main([scene, "--settle", "liggghts", "--validate", "--quiet"]) == 1
    Path(scene).write_text(SCENE + "validation: {force_limit: 3}\n")
    assert main([scene, "--settle", "liggghts", "--validate", "--quiet"]) == 1
    assert main([scene, "--validate", "--quiet"]) == 1
    Path(scene).write_text(SCENE)
    assert main([scene, "--validate", "--quiet"]) == 1
    assert seen == [None, 3, 3, Limits().force_limit]


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ("gravity: 0", "no gravity"),
        ("container: {box: {min: [0, 0, 0], max: [1, 1, 1]}, periodic: [z]}", "wraps around along gravity"),
    ],
)
def test_beds_that_nothing_holds_are_refused_before_the_run(scene, core, solver, capsys, keys, words):
    core()
    solver()
    lines = [line for line in SCENE.splitlines() if not line.startswith(keys.partition(":")[0])]
    text = "\n".join(lines) + f"\n{keys}\n"
    Path(scene).write_text(text.replace("gravity: 0\n", "algorithm: DISPERSED\n"))
    assert main([scene, "--settle", "liggghts", "--quiet"]) == 2
    assert words in capsys.readouterr().err
    assert not Path("box").exists()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--settle", "ligghts"], "--settle: found 'ligghts', expected one of liggghts, lammps, yade"),
        (["--until", "still"], "--until: found without --settle"),
    ],
)
def test_options_that_make_no_sense_are_one_line_and_nothing_is_written(scene, core, capsys, options, said):
    core()
    assert main([scene, *options]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert not Path("box").exists()


def test_a_missing_solver_is_told_before_anything_is_made(scene, core, capsys, monkeypatch, tmp_path):
    core()
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main([scene, "--settle", "yade"]) == 2
    assert "apt-get install yade`, or leave --settle out" in capsys.readouterr().err
    assert not Path("box").exists()


@pytest.mark.parametrize(
    ("text", "seconds"), [("still", float("inf")), ("0.5", 0.5), ("2min", 120), ("20 us", 2e-5)]
)
def test_a_time_may_have_a_unit(text, seconds):
    options = run_options(build_parser().parse_args(["s.yaml", "--settle", "yade", "--until", text]))
    assert options.until == pytest.approx(seconds)


@pytest.mark.parametrize("text", ["soon", "-1", "0", "3 kg", "nan"])
def test_what_is_no_time_is_a_usage_error(text, capsys):
    with pytest.raises(SystemExit) as caught:
        build_parser().parse_args(["s.yaml", f"--until={text}"])
    assert caught.value.code == 2
    assert f"found '{text}', expected still, or a" in capsys.readouterr().err


# ---- Real signals, with a shell script as the solver: it keeps the bed once, and would run for a minute ----

SCRIPT = """#!/bin/sh
case "$2" in in.packgen_timestep) echo "packgen timestep 1e-4"; exit 0;; esac
{ printf 'ITEM: TIMESTEP\\n7\\nITEM: NUMBER OF ATOMS\\n125\\n'
  printf 'ITEM: BOX BOUNDS\\n0 1\\n0 1\\n0 1\\nITEM: ATOMS id\\n'
  for id in $(seq 125); do echo "$id 0.5 0.5 0.$((id + 200))"; done; } > packgen_kept_7.dump
echo state > packgen_kept_7.restart
echo "7 125 0 0 0.25"
echo "8 125 0 0 0.25"
sleep 0.2
echo $$ > "$SOLVER_MARK.part"; mv "$SOLVER_MARK.part" "$SOLVER_MARK"
exec sleep 60
"""


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_what_a_stopped_run_has_reached_is_kept_beside_an_earlier_result_and_said(
    tmp_path, monkeypatch, number
):
    for name in ("work", "bin"):
        (tmp_path / name).mkdir()
    (tmp_path / "bin" / "liggghts").write_text(SCRIPT)
    (tmp_path / "bin" / "liggghts").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setenv("SOLVER_MARK", str(tmp_path / "mark"))
    monkeypatch.chdir(tmp_path / "work")
    Path("box.yaml").write_text(SCENE)
    start("box.yaml", "--quiet").communicate()
    before = Path("box/bed.npz").read_bytes()
    run = start("box.yaml", "--settle", "liggghts", "--validate", "--quiet")
    wait_for(tmp_path / "mark", run)
    code, lines = stopped(run, number)
    assert code == 130
    where = Path.cwd() / "box.unsettled"
    assert lines[-1] == f"packgen: interrupted before the bed was settled, what was reached is in {where}"
    assert Path("box/bed.npz").read_bytes() == before
    assert sorted(os.listdir()) == ["box", "box.unsettled", "box.yaml"]
    assert Path("box.unsettled/liggghts/settled.restart").read_text() == "state\n"
    with np.load("box.unsettled/bed.npz") as bed:
        assert np.allclose(bed["position"][:, 2], (np.arange(125) + 201) / 1000)
    report = report_of("box.unsettled")
    assert any("interrupted before the bed was settled, after 0.0007 s" in line for line in report["missed"])
    assert report["settling"]["interrupted"]
    assert all(Path("box.unsettled", name).exists() for name in report["files"])
    assert not Path("box.unsettled/validation.json").exists()
    pid = int((tmp_path / "mark").read_text())
    assert not Path(f"/proc/{pid}").exists() or shutil.which("ps") is None


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_a_bed_that_liggghts_has_settled_is_confirmed_by_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("box.yaml").write_text(SCENE.replace("125", "60"))
    assert main(["box.yaml", "--settle", "liggghts", "--validate", "--quiet"]) == 0
    report = report_of()
    assert report["settling"]["still"]
    assert report["settling"]["after"]["top"] < report["settling"]["before"]["top"]
    verdict = json.loads(Path("box/validation.json").read_text())["solvers"]["liggghts"]
    assert verdict["passed"]
    assert verdict["step_zero"]["force_max"] > 0.5
    assert verdict["limits"]["force_limit"] is None
    assert verdict["gravity_run"]["displacement_mean"] < 0.02
