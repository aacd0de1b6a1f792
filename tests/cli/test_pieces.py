"""Beds in pieces on the command line: what is refused, and what is read without ever being whole."""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from packgen.cli import main
from packgen.pieces import PieceBed, in_pieces
from packgen.reading import read_bed
from tests.beds import box_container, cubic_lattice, make_bed
from tests.cli.scenes import SCENE, report_of


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("box.yaml").write_text(SCENE)
    return "box.yaml"


@pytest.fixture
def pieces(scene):
    """A bed of 125 spheres of radius 0.1 in pieces in a folder of its own, and the same bed in one."""
    Path("bed").mkdir()
    bed = make_bed(cubic_lattice(5, 0.1), 0.1, box_container(np.zeros(3), np.ones(3)))
    return in_pieces(bed, Path("bed"), spheres=10)


@pytest.fixture
def _never_whole(monkeypatch):
    def whole(self):
        raise AssertionError("the bed was gathered")

    monkeypatch.setattr(PieceBed, "gathered", whole)


def errors(capsys):
    return capsys.readouterr().err.splitlines()


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ([], "--pieces: found without --workers or --scheduler; add one of them"),
        (["--workers", "2", "--validate"], "--pieces: found with --validate, which takes the whole bed"),
        (["--workers", "2", "--picture"], "--pieces: found with --picture, which takes the whole bed"),
    ],
)
def test_what_goes_with_no_bed_in_pieces_is_refused_before_the_run(scene, capsys, options, told):
    pytest.importorskip("distributed")
    assert main([scene, "--pieces", *options]) == 2
    assert any(told in line for line in errors(capsys))
    assert os.listdir() == ["box.yaml"]


def test_a_format_that_takes_no_pieces_is_refused_by_name_before_a_run_of_very_many(
    scene, capsys, monkeypatch
):
    pytest.importorskip("distributed")
    monkeypatch.setattr("packgen.pieces.GATHERED_MAX", 100)
    assert main([scene, "--pieces", "--workers", "2", "--export", "mfix,csv,esys"]) == 2
    told = errors(capsys)
    assert [line.split(":")[1].strip() for line in told] == ["mfix", "esys"]
    assert "found a bed in pieces of 125 spheres, expected at most 100" in told[0]
    assert os.listdir() == ["box.yaml"]


def test_a_bed_of_processes_that_is_too_large_for_one_is_told_of_the_pieces(scene, core, capsys, monkeypatch):
    pytest.importorskip("distributed")
    core()
    monkeypatch.setattr("packgen.cli.crews.GATHERED_MANY", 100)
    assert main([scene, "--quiet", "--workers", "2"]) == 0
    told = [line for line in errors(capsys) if "--pieces leaves them in pieces" in line]
    assert told
    assert "found 125 spheres" in told[0]
    assert main([scene, "--quiet"]) == 0
    assert not [line for line in errors(capsys) if "--pieces" in line]


@pytest.mark.usefixtures("_never_whole")
def test_a_bed_in_pieces_is_measured_and_converted_without_being_whole(pieces, capsys):
    assert main(["measure", "bed/manifest.json", "--scene", "box.yaml", "--no-report"]) == 0
    report = report_of("bed_measure")
    assert report["sphere_count"] == 125
    assert report["solid_fraction"]["filled"] == pytest.approx(np.pi / 6)
    assert report["contacts"][1]["mean"] == pytest.approx(4.8)
    assert os.listdir("bed_measure") == ["report.json"]
    assert report["coordination"]["rattlers"] is None
    assert "coordination.rattlers and coordination.plateau_held are left out" in capsys.readouterr().err
    convert = [
        "convert",
        "bed/manifest.json",
        "--scene",
        "box.yaml",
        "--no-report",
        "--export",
        "csv,liggghts",
    ]
    assert main(convert) == 0
    assert set(os.listdir("bed_convert")) == {"report.json", "csv", "liggghts"}
    assert read_bed("bed_convert/csv/bed.csv").count == 125


def test_faults_of_a_bed_in_pieces_are_named_by_the_spheres_numbers(pieces, capsys):
    bed = pieces.gathered()
    position = bed.position.copy()
    apart = [np.abs(bed.position - at).max(axis=1) for at in ([0.5, 0.5, 0.5], [0.7, 0.5, 0.5])]
    one, other = (int(each.argmin()) for each in apart)
    position[other, 0] -= 0.05
    Path("fault").mkdir()
    found = in_pieces(replace(bed, position=position), Path("fault"), spheres=10)
    place = sorted(
        int(np.flatnonzero((found.gathered().position == position[each]).all(axis=1))[0])
        for each in (one, other)
    )
    assert main(["measure", "fault/manifest.json", "--scene", "box.yaml", "--no-report", "--quiet"]) == 1
    told = [line for line in errors(capsys) if "overlap by" in line]
    named = [f"sphere {each} at" in told[-1] for each in place]
    assert named == [True, True]
    assert "overlap by 0.5 of the smaller radius" in told[-1]


def test_a_small_bed_in_pieces_is_gathered_for_its_page_and_for_formats_that_take_it_whole(pieces):
    assert main(["convert", "bed/manifest.json", "--scene", "box.yaml", "--export", "esys", "-o", "out"]) == 0
    assert set(os.listdir("out")) == {"report.json", "report.html", "esys"}


def test_of_a_large_one_no_page_is_made_and_the_format_is_refused_by_name(pieces, capsys, monkeypatch):
    monkeypatch.setattr("packgen.pieces.GATHERED_MAX", 100)
    assert main(["convert", "bed/manifest.json", "--scene", "box.yaml", "--export", "esys"]) == 2
    assert "esys: found a bed in pieces of 125 spheres, expected at most 100" in errors(capsys)[-1]
    assert main(["measure", "bed/manifest.json", "--scene", "box.yaml"]) == 0
    assert "no report.html: found a bed in pieces of 125 spheres" in errors(capsys)[-1]


def test_walls_that_the_manifest_does_not_know_are_said_not_to_be(pieces, capsys):
    assert main(["measure", "bed/manifest.json", "--no-report"]) == 0
    told = errors(capsys)
    assert any(
        "walls are not in the file: figures are of the box around the spheres" in line for line in told
    )
    assert main(["convert", "bed/manifest.json", "--export", "liggghts"]) == 2
    assert any("walls are not in the file: give --scene" in line for line in errors(capsys))


@pytest.mark.parametrize("option", [["--step", "3"], ["--units", "mm"], ["--picture"]])
def test_options_for_other_files_are_refused(pieces, capsys, option):
    assert main(["measure", "bed/manifest.json", *option]) == 2
    assert errors(capsys)[-1].startswith(f"packgen: {option[0]}: found with a bed in pieces")


def test_a_damaged_manifest_is_told_in_a_line(pieces, capsys):
    path = Path("bed/manifest.json")
    found = json.loads(path.read_text())
    del found["census"]
    path.write_text(json.dumps(found))
    assert main(["measure", "bed/manifest.json"]) == 2
    [told] = errors(capsys)
    assert "found a damaged manifest" in told
