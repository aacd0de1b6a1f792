"""``packgen measure`` and ``packgen convert``: beds from files."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from packgen.cli import main
from packgen.reading import read_spheres
from tests.beds import cubic_lattice
from tests.cli.scenes import SCENE, report_of


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A current folder with 125 spheres of radius 0.1 that fill a box of one metre, and its scene."""
    monkeypatch.chdir(tmp_path)
    lattice_file("beads.csv", cubic_lattice(5, 0.1))
    Path("box.yaml").write_text(SCENE)
    return tmp_path


def lattice_file(name, position, radius=0.1):
    rows = "".join(f"{x!r},{y!r},{z!r},{radius}\n" for x, y, z in position.tolist())
    Path(name).write_text(f"x,y,z,r\n{rows}")


def errors(capsys):
    return capsys.readouterr().err.splitlines()


def test_a_sound_bed_is_measured_and_told_to_be_sound(folder, capsys):
    assert main(["measure", "beads.csv", "--scene", "box.yaml"]) == 0
    assert set(os.listdir("beads")) == {"bed.npz", "report.json", "report.html"}
    report = report_of("beads")
    assert report["missed"] == []
    assert report["sphere_count"] == 125
    assert report["solid_fraction"]["filled"] == pytest.approx(np.pi / 6)
    assert report["contacts"][1]["mean"] == pytest.approx(4.8)
    assert 0.0 < report["overlap"]["wall_overlap_max"] < 1e-12
    assert report["settings"]["read_from"] == "beads.csv"
    assert (report["settings"]["seed"], "algorithm" in report["settings"]) == ("none", False)
    page = Path("beads/report.html").read_text(encoding="utf-8")
    assert "beads.csv, table of text" in page
    assert "optimiser" not in page
    assert "125" in capsys.readouterr().out
    assert main(["report", "beads"]) == 0
    assert main(["measure", "beads.csv", "--scene", "box.yaml", "--quiet"]) == 0  # its own folder is replaced


def test_without_walls_pairs_are_judged_and_what_is_not_known_is_said(folder, capsys):
    assert main(["measure", "beads.csv"]) == 0
    report = report_of("beads")
    assert report["sets"][0]["mass"] is None
    assert report["step_zero"] is None
    assert report["overlap"]["wall_overlap_max"] == 0.0
    said = capsys.readouterr()
    assert "largest overlap with a wall" in said.out
    assert said.out.count("not known") == 2
    assert any(
        "walls are not in the file: figures are of the box around the spheres" in line
        for line in report["warnings"]
    )
    assert any("gravity is not in the file: -z is taken for down" in line for line in report["warnings"])
    page = Path("beads/report.html").read_text(encoding="utf-8")
    assert "not judged" in page


def test_faults_name_the_spheres(folder, capsys):
    position = cubic_lattice(5, 0.1)
    position[7] += [0, 0, 0.02]
    position[30, 0] = -0.3
    lattice_file("beads.csv", position)
    assert main(["measure", "beads.csv", "--scene", "box.yaml", "--quiet"]) == 1
    missed = report_of("beads")["missed"]
    assert "sphere 30 at (-0.3, 0.3, 0.1) is outside the container" in missed
    assert (
        "sphere 7 at (0.1, 0.3, 0.52) and sphere 8 at (0.1, 0.3, 0.7) overlap by 0.2 of the smaller radius"
        in missed
    )
    assert any(line.endswith("overlap by 0.2 of the smaller radius") for line in errors(capsys))
    assert main(["measure", "beads.csv", "--quiet", "--tolerance", "0.25", "-o", "soft"]) == 0


def test_a_container_without_a_scene(folder, capsys):
    import trimesh

    trimesh.creation.box(bounds=[[0, 0, 0], [1000, 1000, 900]]).export("box.stl")
    assert main(["measure", "beads.csv", "--container", "box.stl", "--container-units", "mm", "--quiet"]) == 1
    assert any("is in the wall by 1 of its radius" in line for line in report_of("beads")["missed"])
    assert main(["measure", "beads.csv", "--container", "box.stl"]) == 2
    assert "if the container's mesh is in mm, say so (--container-units mm)" in errors(capsys)[-1]
    assert main(["measure", "beads.csv", "--container", "gone.stl"]) == 2
    assert "--container: found gone.stl, expected a file of a mesh" in errors(capsys)[-1]
    assert main(["measure", "beads.csv", "--container", "box.yaml"]) == 2
    assert main(["measure", "beads.csv", "--container", "box.stl", "--scene", "box.yaml"]) == 2
    assert "leave one of them out" in errors(capsys)[-1]


def test_what_a_format_needs_and_nobody_says_is_asked_for_by_name(folder, capsys):
    assert main(["convert", "beads.csv", "--export", "liggghts"]) == 2
    assert errors(capsys) == [
        "packgen: beads.csv: density of set_0 is not in the file: give --scene, or --density set_0=VALUE",
        "packgen: beads.csv: materials (Young's modulus, Poisson's ratio, restitution, friction) are not in "
        "the file: give --scene",
        "packgen: beads.csv: walls are not in the file: give --scene, or --container",
    ]
    assert sorted(os.listdir()) == ["beads.csv", "box.yaml"]
    assert main(["convert", "beads.csv", "--export", "csv"]) == 2
    assert main(["convert", "beads.csv", "--export", "csv", "--density", "2.5 g/cm3", "--quiet"]) == 0
    assert set(read_spheres(Path("beads/csv/bed.csv")).density.tolist()) == {2500.0}


@pytest.mark.parametrize("name", ["extxyz", "vtk", "kratos", "chrono"])
def test_formats_of_spheres_alone_need_nothing_else(folder, name):
    assert main(["convert", "beads.csv", "--export", name, "--quiet"]) == 0
    assert set(os.listdir("beads")) == {"bed.npz", "report.json", "report.html", name}
    assert "wall.vtp" not in os.listdir(f"beads/{name}")


def test_with_its_scene_a_bed_becomes_decks(folder):
    arguments = [
        "convert",
        "beads.csv",
        "--scene",
        "box.yaml",
        "--export",
        "liggghts,lammps",
        "--export",
        "yade",
    ]
    assert main([*arguments, "--export-option", "liggghts.steps=7", "--quiet"]) == 0
    assert {"liggghts", "lammps", "yade"} <= set(os.listdir("beads"))
    assert "steps index 7" in Path("beads/liggghts/in.bed").read_text()
    for deck in ("liggghts/bed.data", "lammps/bed.data", "yade/bed.txt"):
        found = read_spheres(Path("beads", deck))
        assert np.array_equal(found.position, cubic_lattice(5, 0.1))
        assert (found.radius == 0.1).all()
    assert main(["convert", "beads/bed.npz", "--export", "liggghts", "-o", "again", "--quiet"]) == 0
    assert Path("again/liggghts/bed.data").read_text() == Path("beads/liggghts/bed.data").read_text()


def test_overlaps_are_no_fault_of_a_conversion_but_lost_spheres_are(folder):
    position = cubic_lattice(5, 0.1)
    position[7] += [0, 0, 0.02]
    lattice_file("beads.csv", position)
    arguments = ["convert", "beads.csv", "--scene", "box.yaml", "--export", "extxyz", "--quiet"]
    assert main(arguments) == 0
    assert report_of("beads")["overlap"]["overlap_max"] == pytest.approx(0.2)
    position[30, 0] = -0.3
    lattice_file("beads.csv", position)
    assert main(arguments) == 1


def test_formats_refuse_what_they_cannot_take_before_anything_is_written(folder, capsys):
    Path("box.yaml").write_text(SCENE.replace("seed: 7", "materials: {m: {restitution: 0.01}}"))
    assert main(["convert", "beads.csv", "--scene", "box.yaml", "--export", "liggghts"]) == 2
    assert "restitution" in errors(capsys)[-1]
    assert not Path("beads").exists()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["measure", "gone.csv"], "gone.csv: found no such file, expected a file of spheres"),
        (["measure", "folder"], "found a directory, expected a file of spheres"),
        (["measure", "bad.csv"], "bad.csv:3: found y 'nan', expected a finite number"),
        (["convert", "beads.csv"], "--export: found no format, expected one, such as --export liggghts"),
        (["convert", "beads.csv", "--export", "ligggths"], "no exporter is called 'ligggths'"),
        (["convert", "beads.csv", "--export", "csv", "--density", "ore=7"], "'ore', expected one of set_0"),
        (["measure", "beads.csv", "--scene", "gone.yaml"], "gone.yaml"),
        (["measure", "beads.csv", "--container-units", "mm"], "--container-units: found without --container"),
        (["measure", "beads.csv", "--step", "7"], "which has no steps"),
        (["measure", "beads.csv", "--units", "mm", "--scene", "box.yaml"], ""),
    ],
)  # fmt: skip
def test_wrong_input_is_a_line_and_nothing_is_written(folder, capsys, arguments, expected):
    Path("bad.csv").write_text("x,y,z,r\n0,0,0,1\n0,nan,0,1\n")
    Path("folder").mkdir()
    before = sorted(os.listdir())
    code = main(arguments)
    lines = errors(capsys)
    if expected:
        assert code == 2
        assert expected in lines[-1]
        assert sorted(os.listdir()) == before
    else:  # units that are given are believed
        assert code == 0


@pytest.mark.parametrize(
    "arguments",
    [["--density", "x"], ["--density", "a=-1"], ["--tolerance", "2"], ["--threads", "0"], ["--units", "km"]],
)
def test_wrong_values_of_options_are_refused_by_the_parser(folder, capsys, arguments):
    with pytest.raises(SystemExit) as caught:
        main(["measure", "beads.csv", *arguments])
    assert caught.value.code == 2
    assert "expected" in capsys.readouterr().err or "km" in arguments


def test_foreign_files_are_refused_unless_forced(folder, capsys):
    Path("beads").mkdir()
    Path("beads/mine.txt").write_text("mine")
    assert main(["measure", "beads.csv"]) == 2
    assert "has files that packgen did not write (mine.txt)" in errors(capsys)[-1]
    assert main(["measure", "beads.csv", "--force", "--quiet"]) == 0
    assert Path("beads.old/mine.txt").read_text() == "mine"


def test_a_result_is_not_replaced_by_its_own_measures(folder, capsys):
    assert main(["measure", "beads.csv", "--quiet", "-o", "bed"]) == 0
    assert main(["measure", "bed/bed.npz"]) == 2
    assert "holds bed.npz, an input; choose another folder with -o" in errors(capsys)[-1]


def test_a_fault_of_mine_leaves_nothing(folder, monkeypatch, capsys):
    def fail(*_, **__):
        raise ZeroDivisionError("no")

    monkeypatch.setattr("packgen.report.measure_bed", fail)
    assert main(["measure", "beads.csv"]) == 2
    assert "nothing was written" in errors(capsys)[-1]
    assert sorted(os.listdir()) == ["beads.csv", "box.yaml"]


@pytest.mark.parametrize("command", ["measure", "convert"])
def test_help_names_the_formats_and_the_exit_codes(command, capsys):
    with pytest.raises(SystemExit) as caught:
        main([command, "--help"])
    assert caught.value.code == 0
    text = capsys.readouterr().out
    assert "particle_input.dat of MFiX" in text
    assert ("--export " in text) is (command == "convert")
    assert ("--tolerance" in text) is (command == "measure")
