"""A user's own templates: by folder, one file at a time, for every deck that is filled in."""

from __future__ import annotations

import json

import numpy as np
import pytest

import exporters
from exporters.shared import deck
from packgen.cli import main
from packgen.errors import ExportError
from tests.exporters.beds import lattice

FILES = {
    "liggghts": ("liggghts/in.bed.j2", "in.bed"),
    "lammps": ("lammps/in.bed.j2", "in.bed"),
    "yade": ("yade/bed.py.j2", "bed.py"),
    "cfdem": ("cfdem/in.liggghts_run.j2", "DEM/in.liggghts_run"),
}
SCENE = """\
container: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
particle_sets: [{radius_distribution: constant, radius: 0.2}]
zones: [{n_particles: 5}]
"""


def own(folder, name, text):
    path = folder / name
    path.parent.mkdir(parents=True)
    path.write_text(text)
    return folder


@pytest.mark.parametrize("name", FILES)
def test_a_template_of_the_users_folder_is_taken_and_the_others_stay_ours(tmp_path, name):
    template, written = FILES[name]
    mine = own(tmp_path / "mine", template, "# mine: {{ sphere_count }} spheres\n")
    exporter, texts = exporters.get(name), {}
    for kind, options in (("ours", {}), ("mine", {"templates": mine})):
        folder = tmp_path / f"deck_{kind}"
        folder.mkdir()
        paths = exporter.write(lattice(), folder, exporter.Options(**options))
        texts[kind] = {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}
    assert texts["mine"].pop(written) == b"# mine: 80 spheres\n"
    assert texts["ours"].pop(written).startswith(b"# ")
    assert texts["mine"] == texts["ours"]


def test_a_part_that_a_template_includes_can_be_replaced_alone(tmp_path):
    mine = own(tmp_path / "mine", "liggghts/physics.j2", "# my own law\n")
    exporter = exporters.get("liggghts")
    exporter.write(lattice(), tmp_path, exporter.Options(templates=mine))
    text = (tmp_path / "in.bed").read_text()
    assert "# my own law" in text
    assert "read_data bed.data" in text
    assert "pair_style" not in text


def test_the_command_line_takes_the_folder(tmp_path, capsys):
    (tmp_path / "five.yaml").write_text(SCENE)
    mine = own(tmp_path / "mine", "yade/bed.py.j2", "# mine: {{ sphere_count }} spheres\n")
    out = tmp_path / "out"
    options = ["--export", "yade,lammps", "--templates", str(mine), "-o", str(out), "--no-report", "--quiet"]
    assert main([str(tmp_path / "five.yaml"), *options]) == 0
    assert (out / "yade" / "bed.py").read_text() == "# mine: 5 spheres\n"
    assert "pair_style granular" in (out / "lammps" / "in.bed").read_text()


def test_a_wrong_template_costs_its_deck_not_the_bed(tmp_path, capsys):
    (tmp_path / "five.yaml").write_text(SCENE)
    mine = own(tmp_path / "mine", "yade/bed.py.j2", "ok\n{{ no_such_thing }}\n")
    out = tmp_path / "out"
    options = ["--export", "yade", "--templates", str(mine), "-o", str(out), "--no-report", "--quiet"]
    assert main([str(tmp_path / "five.yaml"), *options]) == 1
    assert "no_such_thing" in capsys.readouterr().err
    assert not (out / "yade").exists()
    assert "no yade deck" in json.loads((out / "report.json").read_text())["missed"][0]
    with np.load(out / "bed.npz") as bed:
        assert len(bed["radius"]) == 5


def test_a_folder_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(ExportError, match="is not a folder"):
        deck.render("yade/bed.py.j2", {}, tmp_path / "nowhere")
