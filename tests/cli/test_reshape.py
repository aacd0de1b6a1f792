"""``packgen carve`` and ``packgen repeat``: the same results as of a bed from a file."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from packgen.bedfile import load_columns, save_bed
from packgen.cli import main
from packgen.container import mesh_container
from packgen.reading import read_bed
from tests.beds import box_container, box_surface, cubic_lattice, make_bed
from tests.cli.scenes import SCENE, report_of

QUICK = ["--no-report", "--quiet"]
PERIODIC = SCENE.replace("max: [1, 1, 1]}", "max: [1, 1, 1]}, periodic: [x, y]")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A current folder with a bed of 125 spheres in a box of one metre, its scene, and meshes."""
    monkeypatch.chdir(tmp_path)
    bed = make_bed(cubic_lattice(5, 0.1), 0.1, box_container((0, 0, 0), (1, 1, 1)))
    Path("box").mkdir()
    save_bed(bed, Path("box/bed.npz"))
    Path("box.yaml").write_text(SCENE)
    Path("periodic.yaml").write_text(PERIODIC)
    write_mesh("core.stl", (0.2, 0.2, -0.1), (0.8, 0.8, 0.5))
    write_mesh("bore.stl", (0.3, 0.3, -2), (0.5, 0.5, 3))
    write_mesh("core_mm.stl", (200, 200, -100), (800, 800, 500))
    return tmp_path


def write_mesh(name, low, high):
    import trimesh

    surface = box_surface(low, high)
    trimesh.Trimesh(surface.vertices, surface.faces, process=False).export(name)


def errors(capsys):
    return capsys.readouterr().err.splitlines()


def test_a_part_is_a_result_folder_with_the_numbers_that_its_spheres_had(folder, capsys):
    assert main(["carve", "box", "--inside", "core.stl", "--scene", "box.yaml", "--export", "csv"]) == 0
    assert set(os.listdir("box_carved")) == {
        "bed.npz", "report.json", "report.html", "csv", "source_index.npy", "walls.stl"
    }  # fmt: skip
    part, whole = load_columns(Path("box_carved/bed.npz")), load_columns(Path("box/bed.npz"))
    kept = np.load("box_carved/source_index.npy")
    assert len(kept) == report_of("box_carved")["sphere_count"] == 9 * 2
    assert np.array_equal(part.position, whole.position[kept])
    said = capsys.readouterr()
    assert said.out.splitlines()[:2] == ["kept: 18 of 125 spheres", "walls: core"]
    assert said.err == ""
    assert report_of("box_carved")["settings"]["carved"]["side"] == "inside"
    assert main(["report", "box_carved"]) == 0
    assert "inside core, of 125 spheres" in Path("box_carved/report.html").read_text(encoding="utf-8")


def test_units_formats_and_both_sides(folder):
    again = ["--scene", "box.yaml", *QUICK]
    assert (
        main(["convert", "box/bed.npz", "--scene", "box.yaml", "--export", "extxyz", "-o", "xyz", *QUICK])
        == 0
    )
    file = "xyz/extxyz/bed.xyz"
    assert main(["carve", file, "--inside", "core_mm.stl", "--mesh-units", "mm", "-o", "in", *again]) == 0
    assert main(["carve", file, "--outside", "core.stl", "--touching", "-o", "out", *again]) == 0
    both = np.concatenate([np.load("in/source_index.npy"), np.load("out/source_index.npy")])
    assert np.array_equal(np.sort(both), np.arange(125))
    assert not Path("out/walls.stl").exists()


def test_the_walls_outside_are_a_mesh_with_which_the_part_is_measured_again(folder):
    assert main(["carve", "box", "--outside", "core.stl", "--scene", "box.yaml", *QUICK]) == 0
    walls = mesh_container(Path("box_carved/walls.stl"), "m", "walls")
    assert walls.volume == pytest.approx(1.0 - 0.36 * 0.5, rel=0.02)
    again = ["measure", "box_carved/bed.npz", "--container", "box_carved/walls.stl"]
    assert main([*again, "-o", "again", *QUICK]) == 0
    assert report_of("again")["sphere_count"] == 125 - 9 * 3


def test_faults_of_the_command_line_are_named_and_write_nothing(folder, capsys):
    before = set(os.listdir())
    for arguments, message in (
        (["--inside", "lost.stl"], "packgen: --inside: found lost.stl, expected a file of a closed mesh"),
        (["--outside", "box.yaml"], "packgen: --outside: box.yaml cannot be read as a mesh"),
    ):
        assert main(["carve", "box", *arguments]) == 2
        assert any(line.startswith(message) for line in errors(capsys))
    for arguments in ([], ["--inside", "core.stl", "--outside", "core.stl"]):
        with pytest.raises(SystemExit) as caught:
            main(["carve", "box", *arguments])
        assert caught.value.code == 2
    assert main(["carve", "lost", "--inside", "core.stl"]) == 2
    assert "lost: found no such file, expected a file of spheres" in errors(capsys)[-1]
    assert main(["repeat", "box", "2", "1", "1", "--scene", "box.yaml"]) == 2
    assert "walls along x (found 2), expected 1 there; it wraps around along no axis" in errors(capsys)[-1]
    assert set(os.listdir()) == before


def test_spheres_of_a_part_that_overlap_have_the_ids_of_the_file(folder, capsys):
    rows = "".join(f"{10 * each + 5},{x},0.5,0.25,0.1\n" for each, x in enumerate((0.05, 0.4, 0.55, 0.9)))
    Path("four.csv").write_text("id,x,y,z,r\n" + rows)
    assert main(["carve", "four.csv", "--inside", "core.stl", *QUICK]) == 1
    assert "sphere 0 (id 15) at (0.4, 0.5, 0.25) and sphere 1 (id 25)" in errors(capsys)[-1]


def test_copies_are_checked_across_the_seams_and_counted(folder, capsys):
    assert main(["repeat", "box", "4", "3", "1", "--scene", "periodic.yaml"]) == 0
    assert "4 x 3 x 1 of 125 spheres" in Path("box_repeated/report.html").read_text(encoding="utf-8")
    report = report_of("box_repeated")
    assert report["sphere_count"] == 12 * 125
    assert report["contacts"][1]["mean"] == pytest.approx(2 + 2 + 2 * 0.8)
    assert report["settings"]["repeated"]["contacts_between_copies"] == 12 * 50
    copies, seams = capsys.readouterr().out.splitlines()[:2]
    assert copies == "copies: 4 x 3 x 1 of 125 spheres are 1,500"
    assert seams.startswith("seams: 600 contacts between copies, 50 for each copy; largest overlap ")


@pytest.mark.solver
@pytest.mark.slow
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
@pytest.mark.parametrize(
    "command", [["repeat", "box", "2", "2", "1"], ["carve", "box", "--outside", "core.stl"]]
)
def test_the_decks_run(folder, command):
    scene = "periodic.yaml" if command[0] == "repeat" else "box.yaml"
    assert main([*command, "--scene", scene, "--export", "liggghts", "-o", "new", *QUICK]) == 0
    run = subprocess.run(
        ["liggghts", "-in", "in.bed", "-var", "steps", "50", "-var", "dump_every", "50"],
        cwd="new/liggghts", capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stdout[-500:]
    sphere_count = json.loads(Path("new/report.json").read_text())["sphere_count"]
    assert read_bed(Path("new/liggghts/post/bed_50.dump")).count == sphere_count
