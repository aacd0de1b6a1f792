"""The command line as a user meets it; the core is replaced by a lattice, so that these run in no time."""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import packgen.container
from packgen.cli import main
from tests.cli.scenes import SCENE, report_of


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
    assert "threads of the arrangement and of the measures; the bed is the same for any number" in said
    assert "default: as many as cores are free to packgen" in said


def test_warnings_of_every_stage_are_in_the_report_in_the_order_of_the_stages(
    scene, core, capsys, monkeypatch
):
    core(warnings=("soft",))
    load = packgen.container.load_container
    monkeypatch.setattr(
        "packgen.container.load_container", lambda given, warn: (warn("mended"), load(given))[1]
    )
    monkeypatch.setattr("packgen.page.view_data", lambda *_: 1 / 0)
    assert main([scene, "--quiet"]) == 0
    assert [line[:14] for line in report_of()["warnings"]] == ["mended", "soft", "no report.html"]
    said = [line[:24] for line in capsys.readouterr().err.splitlines()]
    assert said == [f"packgen: warning: {each}" for each in ("soft", "mended", "soft", "no rep")]


@pytest.mark.parametrize(("formats", "for_solver"), [([], False), (["csv"], False), (["csv,yade"], True)])
def test_the_core_hears_whether_a_solver_will_get_the_bed(scene, core, formats, for_solver):
    keys = {}
    core(called_with=keys)
    assert main([scene, "--quiet", "--no-report", *(["--export", *formats] if formats else [])]) == 0
    assert keys["for_solver"] is for_solver
