"""Pages and pictures of results: with a run, later, and side by side."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from packgen.cli import main
from packgen.errors import PackgenError
from tests.cli.scenes import report_of


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
