"""Runs of a sweep as processes of their own."""

from __future__ import annotations

import pytest

from packgen.sweep.processes import run_all


@pytest.mark.slow
def test_runs_end_by_themselves_each_with_its_code_and_what_it_said(tmp_path):
    scene = tmp_path / "wrong.yaml"
    scene.write_text("container: 3\n")
    commands = [("right", ["schema"]), ("wrong", [str(scene)]), ("usage", ["--nothing"])]
    found = {each.key: each for each in run_all(commands, 2)}
    assert {key: each.code for key, each in found.items()} == {"right": 0, "wrong": 2, "usage": 2}
    assert "wrong.yaml:1:12: container: found 3" in found["wrong"].said
    assert found["right"].said == ""


@pytest.mark.slow
def test_nothing_runs_on_when_the_caller_gives_up(tmp_path):
    started = run_all([("first", ["schema"]), ("second", ["schema"])], 1)
    assert next(started).key == "first"
    started.close()
