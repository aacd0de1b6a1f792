"""The command line as a user meets it; the core is replaced by a lattice, so that these run in no time."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

import packgen.container
from packgen.cli import main
from packgen.errors import PackgenError, PackingError, SolverError
from tests.beds import cubic_lattice, make_bed

SCENE = """
container: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
seed: 7
particle_sets:
  - {name: pellets, radius_distribution: constant, radius: 0.1}
zones:
  - {n_particles: 125}
"""


@dataclass
class Zone:
    asked: int | None = 125
    placed: int = 125
    left_over: int = 0
    locations: tuple[object, ...] = ()


@dataclass
class Result:
    bed: object
    zones: tuple[Zone, ...] = (Zone(),)
    warnings: tuple[str, ...] = ()


@pytest.fixture
def scene(tmp_path, monkeypatch):
    """A scene file in an otherwise empty current folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "box.yaml").write_text(SCENE)
    return "box.yaml"


@pytest.fixture
def core(monkeypatch):
    """Replaces the core by one that returns, or raises, what the test says."""

    def install(outcome=None, *, shift=0.0, placed=125):
        def pack(scene, container, **_):
            if outcome is not None:
                raise outcome
            position = cubic_lattice(5, 0.1)[:placed]
            position[0, 2] += shift
            bed = make_bed(position, 0.1, container, provenance={"seed": scene.seed})
            return Result(bed, (Zone(125, placed, 125 - placed),))

        monkeypatch.setattr("packgen.filling.pack.pack", pack)

    return install


def report_of(folder="box"):
    return json.loads(Path(folder, "report.json").read_text())


def test_a_run_leaves_the_files_of_the_contract_and_no_other(scene, core, capsys):
    core()
    assert main([scene, "--export", "liggghts"]) == 0
    assert sorted(os.listdir()) == ["box", "box.yaml"]
    assert {"bed.npz", "report.json", "report.html", "liggghts"} == set(os.listdir("box"))
    assert {"bed.data", "in.bed"} <= set(os.listdir("box/liggghts"))
    listed = {path.relative_to("box").as_posix() for path in Path("box").rglob("*") if path.is_file()}
    assert set(report_of()["files"]) == listed
    out = capsys.readouterr().out
    assert "125 of 125" in out
    assert "0.5236" in out


@pytest.mark.parametrize("where", ["packgen.page.view_data", "packgen.page.write_page"])
def test_a_fault_of_the_page_costs_a_warning_not_the_bed(scene, core, capsys, monkeypatch, where):
    def fail(*_):
        raise ZeroDivisionError("drawn too small")

    core(placed=100)
    monkeypatch.setattr(where, fail)
    assert main([scene, "--export", "liggghts"]) == 1  # as it would be: 25 spheres are missing
    assert {"bed.npz", "report.json", "liggghts"} == set(os.listdir("box"))
    assert "report.html" not in report_of()["files"]
    (line,) = report_of()["warnings"]
    assert "no report.html: ZeroDivisionError: drawn too small" in line
    lines = capsys.readouterr().err.splitlines()
    assert f"packgen: warning: {line}" in lines
    assert "100 of 125" in lines[-1]


def test_pictures_are_drawn_where_asked_for(scene, core, monkeypatch):
    def write_pictures(folder):
        (folder / "bed.png").write_bytes(b"picture")
        return (folder / "bed.png",)

    core()
    monkeypatch.setattr("packgen.page.write_pictures", write_pictures)
    assert main([scene, "--picture", "--quiet"]) == 0
    assert "bed.png" in report_of()["files"]
    assert main([scene, "--quiet"]) == 0  # packgen's own picture is no foreign file
    assert not Path("box/bed.png").exists()


def test_without_anything_to_draw_with_the_bed_is_kept(scene, core, capsys, monkeypatch):
    def write_pictures(folder):
        raise PackgenError("no pictures: VTK found nothing to draw with")

    core()
    monkeypatch.setattr("packgen.page.write_pictures", write_pictures)
    assert main([scene, "--picture"]) == 0
    assert {"bed.npz", "report.json", "report.html"} == set(os.listdir("box"))
    assert "packgen: warning: no pictures: VTK found nothing" in capsys.readouterr().err


def test_seed_and_folder_of_the_command_line_win(scene, core):
    core()
    assert main([scene, "--seed", "3", "-o", "deep/out", "--quiet"]) == 0
    assert report_of("deep/out")["settings"]["seed"] == 3


def test_quiet_writes_and_says_nothing(scene, core, capsys):
    core()
    assert main([scene, "--quiet"]) == 0
    assert capsys.readouterr() == ("", "")


def test_a_second_run_replaces_the_first_as_a_whole(scene, core):
    core()
    main([scene, "--export", "liggghts", "--quiet"])
    assert main([scene, "--quiet"]) == 0
    assert set(os.listdir("box")) == {"bed.npz", "report.json", "report.html"}


def test_spheres_that_do_not_fit_end_with_exit_code_1_and_a_last_line(scene, core, capsys):
    core(placed=100)
    assert main([scene]) == 1
    assert report_of()["missed"]
    assert "100 of 125" in capsys.readouterr().err.splitlines()[-1]


def test_an_overlap_above_tolerance_ends_with_exit_code_1(scene, core, capsys):
    core(shift=0.01)
    assert main([scene, "--quiet"]) == 1
    assert "overlap" in capsys.readouterr().err.splitlines()[-1]


def test_a_scene_with_faults_is_refused_with_their_places(scene, core, capsys):
    Path(scene).write_text(SCENE.replace("radius: 0.1", "radius: -1").replace("seed: 7", "sed: 7"))
    assert main([scene]) == 2
    error = capsys.readouterr().err
    assert "box.yaml:3:" in error
    assert "box.yaml:5:" in error
    assert os.listdir() == ["box.yaml"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--export", "stone"], "stone"),
        (["--validate", "--solver", "stone"], "stone"),
        (["--solver", "liggghts"], "--validate"),
        (["--templates", "nowhere"], "nowhere"),
        (["-o", "box.yaml"], "is a file"),
        (["-o", "."], "folder you are in"),
    ],
)
def test_a_wrong_command_line_is_refused_before_the_run(scene, core, capsys, arguments, said):
    core(AssertionError("the run started"))
    assert main([scene, *arguments]) == 2
    assert said in capsys.readouterr().err
    assert os.listdir() == ["box.yaml"]


@pytest.mark.parametrize(
    "arguments", [[], ["a.yaml", "--seed", "-1"], ["a.yaml", "--threads", "0"], ["a.yaml", "--sed"]]
)
def test_arguments_that_make_no_sense_are_usage_errors(arguments, capsys):
    with pytest.raises(SystemExit) as stop:
        main(arguments)
    assert stop.value.code == 2
    assert "usage" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["report", "box"], ["compare", "a", "b"]])
def test_a_page_of_a_folder_that_is_not_there_is_an_error(arguments, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    assert "report.json: not found" in capsys.readouterr().err
    assert os.listdir() == []


def test_no_report_leaves_the_page_out_and_report_makes_it_later(scene, core, capsys):
    core()
    assert main([scene, "--no-report"]) == 0
    assert "report.html" not in os.listdir("box")
    assert main(["report", "box"]) == 0
    assert "report.html" in os.listdir("box")
    assert main([scene]) == 0  # the folder is still all packgen's own


def test_compare_writes_one_page_and_says_the_same_table(scene, core, capsys):
    core()
    assert main([scene, "-o", "first"]) == 0
    assert main([scene, "-o", "second"]) == 0
    capsys.readouterr()
    assert main(["compare", "first", "second"]) == 0
    out = capsys.readouterr().out
    page = Path("compare.html").read_text(encoding="utf-8")
    for text in ("first", "second", "0.5236"):
        assert text in out
        assert text in page


def test_compare_does_not_overwrite_a_file_of_somebody_else(scene, core, capsys):
    core()
    assert main([scene]) == 0
    Path("compare.html").write_text("mine")
    assert main(["compare", "box"]) == 2
    assert Path("compare.html").read_text() == "mine"


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


def test_a_folder_with_foreign_files_is_refused_and_with_force_set_aside(scene, core, capsys):
    core()
    Path("box").mkdir()
    Path("box/notes.txt").write_text("mine")
    assert main([scene]) == 2
    assert os.listdir("box") == ["notes.txt"]
    assert main([scene, "--force"]) == 0
    assert "box.old" in capsys.readouterr().err
    assert Path("box.old/notes.txt").read_text() == "mine"
    assert "notes.txt" not in os.listdir("box")


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


@pytest.mark.parametrize("given", [None, 1, 3])
def test_threads_are_for_the_measures_and_change_no_number(scene, core, monkeypatch, given):
    pools = []

    class Pool(ThreadPoolExecutor):
        def __init__(self, workers):
            pools.append(workers)
            super().__init__(workers)

    core()
    monkeypatch.setattr("packgen.report.ThreadPoolExecutor", Pool)
    arguments = [] if given is None else ["--threads", str(given)]
    assert main([scene, "--quiet", "--no-report", *arguments]) == 0
    assert pools == [given or 2]
    one = report_of()
    assert main([scene, "--quiet", "--no-report"]) == 0
    two = report_of()
    for each in (one, two):
        del each["timings"], each["peak_memory"]
    assert one == two


def test_help_says_what_uses_threads(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "threads for the measures" in said
    assert "projection, the default, arranges on one core" in said


def test_warnings_of_every_stage_are_in_the_report_in_the_order_of_the_stages(
    scene, core, capsys, monkeypatch
):
    core()
    load = packgen.container.load_container
    monkeypatch.setattr(
        "packgen.container.load_container", lambda given, warn: (warn("mended"), load(given))[1]
    )
    monkeypatch.setattr("packgen.filling.softness.check_softness", lambda *_, **__: ["soft"])
    monkeypatch.setattr("packgen.page.view_data", lambda *_: 1 / 0)
    assert main([scene, "--quiet"]) == 0
    assert [line[:14] for line in report_of()["warnings"]] == ["mended", "soft", "no report.html"]
    said = [line[:24] for line in capsys.readouterr().err.splitlines()]
    assert said == [f"packgen: warning: {each}" for each in ("soft", "mended", "soft", "no rep")]


def test_what_was_mended_is_said_once_before_the_error_that_it_may_explain(scene, core, capsys, monkeypatch):
    core(PackingError("nothing fits"))
    load = packgen.container.load_container
    monkeypatch.setattr(
        "packgen.container.load_container", lambda given, warn: (warn("mended"), load(given))[1]
    )
    assert main([scene, "--quiet"]) == 2
    assert capsys.readouterr().err.splitlines() == ["packgen: warning: mended", "packgen: nothing fits"]
