"""Which runs of a sweep are done already."""

from __future__ import annotations

import json

import pytest

from packgen.bedfile import plain
from packgen.scene import load_scene
from packgen.sweep.table import is_done
from tests.cli.scenes import SCENE


@pytest.fixture
def run(tmp_path):
    """A folder with a liggghts deck that liggghts has judged, and whether it is done for some solvers."""
    path = tmp_path / "box.yaml"
    path.write_text(SCENE)
    scene = load_scene(path)
    folder = tmp_path / "seed=0"
    (folder / "liggghts").mkdir(parents=True)
    (folder / "report.json").write_text(
        json.dumps({"settings": {"settings": plain(scene.model_dump())}}, default=str)
    )
    (folder / "validation.json").write_text(
        json.dumps({"passed": False, "solvers": {"liggghts": {}}, "errors": {"yade": "yade: hangs"}})
    )
    return folder, lambda *solvers, formats=(): is_done(folder, scene, formats, solvers)


def test_a_run_is_done_where_each_solver_asked_for_has_had_its_turn(run):
    _, done = run
    assert done()
    assert done("liggghts")
    assert done("liggghts", "yade")
    assert not done("lammps")
    assert not done("liggghts", "lammps")


def test_a_run_without_the_deck_of_a_format_asked_for_is_not_done(run):
    _, done = run
    assert done(formats=["liggghts"])
    assert not done(formats=["liggghts", "lammps"])


def test_a_solver_that_was_stopped_has_its_turn_again(run):
    folder, done = run
    judged = json.loads((folder / "validation.json").read_text())
    (folder / "validation.json").write_text(json.dumps({**judged, "interrupted": True}))
    assert done("liggghts")
    assert not done("yade")
