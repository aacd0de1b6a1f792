from __future__ import annotations

import json
import os

import pytest

from packgen.errors import ExportError
from packgen.results import ResultFolder, foreign_files, list_files


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
