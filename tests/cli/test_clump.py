from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh

from packgen.cli import main
from packgen.cli.clump import SHAPE_SIZES, build_clump_parser
from packgen.clumps import SHAPES, read_template


@pytest.fixture
def stone(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mesh = trimesh.creation.icosphere(2)
    mesh.vertices = mesh.vertices * [3.0, 2.0, 2.0]
    mesh.export(tmp_path / "stone.stl")
    return mesh


def test_a_stone_becomes_a_file_of_spheres_and_a_report(stone, tmp_path, capsys):
    assert main(["clump", "stone.stl", "--spheres", "8", "--units", "mm", "-o", "stone.txt"]) == 0
    template = read_template(tmp_path / "stone.txt")
    assert template.count == 8
    assert template.volume == pytest.approx(stone.volume * 1e-9, rel=1e-5)
    told = json.loads((tmp_path / "stone.json").read_text())
    assert told["errors"]["volume"] == pytest.approx(told["union"]["volume"] / told["body"]["volume"] - 1.0)
    assert told["source"]["spheres"] == 8
    shown = capsys.readouterr().out
    assert "8 spheres" in shown
    assert "written: stone.json" in shown


def test_json_shows_what_the_file_has(stone, tmp_path, capsys):
    assert main(["clump", "stone.stl", "--spheres", "3", "--best-fit", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads((tmp_path / "stone.json").read_text())


def test_an_error_that_is_not_reached_ends_with_exit_code_1_and_the_file(stone, tmp_path, capsys):
    assert main(["clump", "stone.stl", "--spheres", "2", "--volume-error", "0.01"]) == 1
    assert "volume error: found" in capsys.readouterr().err
    assert read_template(tmp_path / "stone.csv").count == 2


def test_a_shape_has_its_sizes(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    sizes = ["--set", "radius=5mm", "--set", "thickness=3mm"]
    assert main(["clump", "ring", "--spheres", "12", *sizes]) == 0
    np.testing.assert_allclose(read_template(tmp_path / "ring.csv").spheres[:, 3], 1.5e-3)


def test_the_command_knows_the_shapes_and_their_sizes():
    assert {name: ", ".join(kind.__dataclass_fields__) for name, kind in SHAPES.items()} == SHAPE_SIZES


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["none.stl", "--spheres", "3"], "found no file none.stl"),
        (["stone.stl"], "found no limit"),
        (["cube"], "found no limit"),
        (["stone.stl", "--volume-error", "0.1", "--surface-error", "0.1"], "expected one of them"),
        (["stone.stl", "--surface-error", "0.1", "--equal"], "--equal: found --surface-error as well"),
        (["stone.stl", "--spheres", "3", "--set", "radius=1"], "expected a shape"),
        (["ring", "--units", "mm"], "--units: found ring"),
        (["ring", "--set", "girth=1"], "found size 'girth'"),
        (["ring", "--equal"], "found no number of spheres"),
        (["ring", "-o", "nowhere/ring.csv"], "found no folder nowhere"),
        (["ring", "-o", "ring.json"], "expected the name of a table"),
        (["stone.stl", "--spheres", "3", "-o", "stone.stl", "--force"], "which is the mesh"),
        (["stone.stl", "--spheres", "3", "-o", "holes.stl"], "is there already"),
        (["holes.stl", "--spheres", "3"], "holes.stl has holes: 3 open edges"),
        (["stone.stl", "--spheres", "3", "--least-radius", "9"], "the largest sphere inside"),
    ],
)
def test_what_is_wrong_is_said_in_a_line_and_nothing_is_written(arguments, said, stone, tmp_path, capsys):
    trimesh.Trimesh(stone.vertices, stone.faces[1:]).export(tmp_path / "holes.stl")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert main(["clump", *arguments]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert said in lines[0]
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_shares_and_lengths_are_checked_by_the_parser(capsys):
    for wrong in (["--volume-error", "2"], ["--least-radius", "-1"], ["--set", "radius"], ["--spheres", "0"]):
        with pytest.raises(SystemExit):
            build_clump_parser().parse_args(["ring", *wrong])
    assert "found" in capsys.readouterr().err
