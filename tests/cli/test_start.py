"""``packgen init`` and ``packgen schema``."""

from __future__ import annotations

import json
import os
from pathlib import Path

import numpy as np
import pytest
import trimesh

from packgen.cli import main
from packgen.container import load_container
from packgen.filling.fit import checked_locations
from packgen.scene import load_scene
from packgen.scene.yamlmarks import read_yaml
from tests.scene.json_schema import faults


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def mesh(name, extents):
    trimesh.creation.box(extents=extents).export(name)
    return name


def remarks_of(path):
    """What a run of a scene would say of its amounts before it starts."""
    scene, said = load_scene(Path(path)), []
    checked_locations(scene, load_container(scene), said.append)
    return said


@pytest.mark.parametrize("kind", ["box", "tube"])
def test_a_scene_to_start_from_is_valid_and_fits(kind, capsys):
    assert main(["init", kind]) == 0
    assert capsys.readouterr() == (f"written: {kind}.yaml\nwritten: packgen.schema.json\n", "")
    first = Path(f"{kind}.yaml").read_text().splitlines()[0]
    assert first == "# yaml-language-server: $schema=packgen.schema.json"
    schema = json.loads(Path("packgen.schema.json").read_text())
    assert faults(read_yaml(Path(f"{kind}.yaml")).data, schema, schema) == []
    assert remarks_of(f"{kind}.yaml") == []


@pytest.mark.parametrize(
    ("extents", "unit"),
    [((600, 600, 900), "mm"), ((2, 2, 9), "m"), ((300, 300, 3000), "mm"), ((0.1, 0.1, 0.2), "m")],
)
def test_the_unit_of_a_mesh_is_guessed_and_said(extents, unit, capsys):
    mesh("silo.stl", extents)
    assert main(["init", "silo.stl"]) == 0
    assert f"in its own unit, taken for {unit}: " in capsys.readouterr().err
    scene = load_scene(Path("silo.yaml"))
    assert scene.container.units == unit
    assert remarks_of("silo.yaml") == []


def test_a_radius_decides_the_unit_by_the_rule_of_the_warning(capsys):
    mesh("silo.stl", (20, 20, 30))
    assert main(["init", "silo.stl", "--radius", "1 mm"]) == 0
    scene = load_scene(Path("silo.yaml"))
    assert scene.container.units == "mm"
    assert scene.particle_sets[0].distribution.radius_bounds[1] == pytest.approx(0.001, rel=0.01)


def test_a_unit_that_is_given_is_no_guess(capsys):
    mesh("silo.stl", (600, 600, 900))
    assert main(["init", "silo.stl", "--units", "cm"]) == 0
    assert capsys.readouterr().err == ""
    assert load_scene(Path("silo.yaml")).container.units == "cm"


def test_the_path_of_a_mesh_starts_at_the_scene(capsys):
    Path("scenes").mkdir()
    Path("meshes").mkdir()
    mesh("meshes/a silo.stl", (1, 1, 2))
    assert main(["init", "meshes/a silo.stl", "-o", "scenes/silo.yaml"]) == 0
    scene = load_scene(Path("scenes/silo.yaml"))
    np.testing.assert_allclose(np.ptp(load_container(scene).bounds, axis=0), [1, 1, 2])


def test_a_file_is_never_overwritten_untold(capsys):
    Path("box.yaml").write_text("mine")
    assert main(["init", "box"]) == 2
    said = "packgen: box.yaml: is there already; choose another file with -o, or overwrite it by --force\n"
    assert capsys.readouterr().err == said
    assert os.listdir() == ["box.yaml"]
    assert Path("box.yaml").read_text() == "mine"
    assert main(["init", "box", "--force"]) == 0
    assert "container:" in Path("box.yaml").read_text()


def test_somebody_elses_schema_stays(capsys):
    Path("packgen.schema.json").write_text("{}")
    assert main(["init", "box"]) == 0
    assert Path("packgen.schema.json").read_text() == "{}"
    assert "stays as it is" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["bx"], "bx: found no such file, expected box, tube or the path of a mesh"),
        (["box", "-o", "nowhere/box.yaml"], "found no folder nowhere"),
        (["box", "-o", "."], "found a folder"),
        (["notes.txt"], "cannot be read as a mesh"),
    ],
)
def test_what_cannot_be_is_told_in_a_line(arguments, said, capsys):
    Path("notes.txt").write_text("mine")
    assert main(["init", *arguments]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1
    assert os.listdir() == ["notes.txt"]


def test_the_schema_is_shown_as_json(capsys):
    assert main(["schema"]) == 0
    assert json.loads(capsys.readouterr().out)["title"] == "packgen scene"
