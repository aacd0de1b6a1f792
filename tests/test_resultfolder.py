from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from packgen.errors import ExportError
from packgen.leftovers import NOBODY, owner
from packgen.resultfolder import UNSETTLED, UNVALIDATED, ResultFolder, foreign_files, list_files


def run_into(target, content="new", stop=None, **options):
    """What a run does: write, list, commit; ``stop`` is raised before the end."""
    with ResultFolder(target, **options) as folder:
        (folder.path / "deck").mkdir()
        (folder.path / "deck" / "in.bed").write_text(content)
        if stop is not None:
            raise stop
        files = [*list_files(folder.path), "report.json"]
        (folder.path / "report.json").write_text(json.dumps({"files": files}))
        folder.commit()
    return folder


def test_a_complete_run_leaves_its_folder_and_nothing_else(tmp_path):
    run_into(tmp_path / "out")
    assert os.listdir(tmp_path) == ["out"]
    assert foreign_files(tmp_path / "out") == []


def test_an_earlier_run_is_replaced_as_a_whole(tmp_path):
    target = tmp_path / "out"
    run_into(target)
    with ResultFolder(target) as folder:
        (folder.path / "report.json").write_text('{"files": ["report.json"]}')
        folder.commit()
    assert list_files(target) == ["report.json"]
    assert os.listdir(tmp_path) == ["out"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_a_run_that_stops_leaves_nothing_and_the_earlier_results(tmp_path, error):
    target = tmp_path / "deep" / "out"
    with pytest.raises(error):
        run_into(target, stop=error)
    assert os.listdir(tmp_path) == []
    run_into(target, "first")
    with pytest.raises(error):
        run_into(target, "second", stop=error)
    assert (target / "deck" / "in.bed").read_text() == "first"
    assert os.listdir(target.parent) == ["out"]


def test_foreign_files_are_refused_and_named(tmp_path):
    target = tmp_path / "out"
    run_into(target)
    (target / "deck" / "post").mkdir()
    (target / "deck" / "post" / "dump.1").write_text("hours of work")
    with pytest.raises(ExportError, match=r"deck/post/dump\.1.*--force"), ResultFolder(target):
        pass
    assert (target / "deck" / "post" / "dump.1").read_text() == "hours of work"


def test_with_force_a_folder_with_foreign_files_is_set_aside_not_lost(tmp_path):
    target = tmp_path / "out"
    target.mkdir()
    (target / "thesis.tex").write_text("mine")
    folder = run_into(target, force=True)
    assert foreign_files(target) == []
    assert folder.set_aside == tmp_path / "out.old"
    assert (folder.set_aside / "thesis.tex").read_text() == "mine"
    (target / "more.txt").write_text("mine too")
    assert run_into(target, force=True).set_aside == tmp_path / "out.old2"


def test_a_folder_of_another_program_with_a_report_json_is_foreign(tmp_path):
    (tmp_path / "report.json").write_text("[1, 2]")
    assert foreign_files(tmp_path) == ["report.json"]


def test_files_that_come_during_the_run_are_set_aside(tmp_path):
    target = tmp_path / "out"
    with ResultFolder(target) as folder:
        target.mkdir()
        (target / "late.txt").write_text("mine")
        folder.commit()
    assert (tmp_path / "out.old" / "late.txt").exists()
    assert target.is_dir()


def test_an_existing_empty_folder_is_filled(tmp_path):
    (tmp_path / "out").mkdir()
    run_into(tmp_path / "out")
    assert (tmp_path / "out" / "deck" / "in.bed").exists()


def test_a_file_the_current_folder_and_an_input_are_never_replaced(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("x")
    with pytest.raises(ExportError, match="is a file"), ResultFolder(tmp_path / "file", force=True):
        pass
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    with pytest.raises(ExportError, match="folder you are in"), ResultFolder(tmp_path, force=True):
        pass
    scene = tmp_path / "scenes" / "a.yaml"
    scene.parent.mkdir()
    scene.write_text("x")
    with pytest.raises(ExportError, match=r"holds a\.yaml"):
        ResultFolder(scene.parent, force=True, keep=(scene,)).check()


def test_a_place_that_cannot_be_written_is_a_clear_error(tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(ExportError, match="cannot be written"), ResultFolder(tmp_path / "file" / "out"):
        pass


def test_results_are_readable_as_other_new_folders_are(tmp_path):
    (tmp_path / "plain").mkdir()
    run_into(tmp_path / "out")
    assert (tmp_path / "out").stat().st_mode == (tmp_path / "plain").stat().st_mode


KILLED = """
import json, os, pathlib, sys
from packgen.leftovers import NOBODY, owner
from packgen.resultfolder import ResultFolder, list_files

renames = int(sys.argv[2])  # of the commit, until the process is killed
rename = pathlib.Path.rename

def counted(*arguments):
    global renames
    if renames == 0:
        os._exit(9)
    renames -= 1
    return rename(*arguments)

pathlib.Path.rename = counted
with ResultFolder(pathlib.Path(sys.argv[1])) as folder:
    (folder.path / "bed").write_text("killed")
    (folder.path / "report.json").write_text(json.dumps({"files": ["bed", "report.json"]}))
    if len(sys.argv) > 3:
        folder.keep_beside(sys.argv[3])
    folder.commit()
"""
needs_owner = pytest.mark.skipif(owner() == NOBODY, reason="the system does not tell when a process started")


def killed(target, renames, *more):
    command = [sys.executable, "-c", KILLED, str(target), str(renames), *more]
    assert subprocess.run(command, check=False, cwd=Path(__file__).parents[1]).returncode in {0, 9}


@needs_owner
@pytest.mark.parametrize(("renames", "found"), [(0, "first"), (1, "first"), (2, "killed"), (3, "killed")])
def test_a_run_killed_at_any_rename_costs_no_result(tmp_path, renames, found):
    target = tmp_path / "out"
    run_into(target, "first")
    killed(target, renames)
    with pytest.raises(RuntimeError):
        run_into(target, stop=RuntimeError)
    assert os.listdir(tmp_path) == ["out"]
    assert (target / ("bed" if found == "killed" else "deck/in.bed")).read_text() == found
    assert foreign_files(target) == []


@needs_owner
def test_a_former_result_that_a_killed_run_moved_is_not_lost_where_its_name_is_taken(tmp_path):
    target = tmp_path / "out"
    run_into(target, "first")
    killed(target, 1)
    target.mkdir()
    (target / "notes").write_text("mine")
    folder = run_into(target, "second", force=True)
    assert sorted(os.listdir(tmp_path)) == ["out", "out.old", "out.old2"]
    assert (tmp_path / "out.old" / "deck" / "in.bed").read_text() == "first"
    assert (tmp_path / "out.old2" / "notes").read_text() == "mine"
    assert any(str(tmp_path / "out.old") in line for line in folder.notes)


@needs_owner
@pytest.mark.parametrize("suffix", [UNVALIDATED, UNSETTLED])
@pytest.mark.parametrize(("renames", "found"), [(0, "first"), (1, "first"), (2, "first"), (3, "killed")])
def test_a_bed_beside_the_target_is_as_safe_as_any(tmp_path, renames, found, suffix):
    target = tmp_path / "out"
    for _ in range(2):
        with ResultFolder(target) as folder:
            (folder.path / "bed").write_text("first")
            (folder.path / "report.json").write_text(json.dumps({"files": ["bed", "report.json"]}))
            folder.keep_beside(suffix)
            folder.commit()
    killed(target, renames, suffix)
    run_into(target)
    assert sorted(os.listdir(tmp_path)) == ["out", f"out{suffix}"]
    assert (tmp_path / f"out{suffix}" / "bed").read_text() == found


def test_an_unvalidated_bed_touches_no_foreign_files(tmp_path):
    (tmp_path / "out.unvalidated").mkdir()
    (tmp_path / "out.unvalidated" / "notes").write_text("mine")
    with ResultFolder(tmp_path / "out") as folder:
        folder.keep_beside(UNVALIDATED)
        folder.commit()
    assert folder.target == tmp_path / "out.unvalidated2"
    assert sorted(os.listdir(tmp_path)) == ["out.unvalidated", "out.unvalidated2"]
    assert os.listdir(tmp_path / "out.unvalidated") == ["notes"]
