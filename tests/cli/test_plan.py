"""``packgen plan``: nothing is packed, and what is wrong is told as a run tells it."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from packgen.cli import main
from tests.cli.scenes import SCENE


@pytest.fixture
def small(scene):
    Path(scene).write_text(SCENE.replace("radius: 0.1", "radius: 0.03"))
    return scene


def test_a_plan_is_shown_and_its_page_written(small, core, capsys):
    core(AssertionError("the run started"))
    assert main(["plan", small]) == 0
    shown = capsys.readouterr()
    assert "125 of 125" in shown.out
    assert "needs" in shown.out
    assert shown.err == ""
    assert sorted(os.listdir()) == ["box.yaml", "plan.html"]
    page = Path("plan.html").read_text(encoding="utf-8")
    assert "<title>Plan of box - packgen</title>" in page
    view = json.loads(page.partition('id="view-data">')[2].partition("</script>")[0])
    assert view["outlines"][0]["name"] == "container"
    assert view["outlines"][1]["name"].startswith("zones[0], 125 spheres up to")
    assert all(each["ends"] for each in view["outlines"])


def test_a_plan_as_json_is_one_object_on_standard_output(small, capsys):
    assert main(["plan", small, "--json", "--no-page"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["exit_code"], found["sphere_count"], found["page"]) == (0, 125, None)
    assert found["zones"][0]["height_needed"] == found["height"]
    assert os.listdir() == ["box.yaml"]


def test_values_of_the_command_line_are_planned_with(small, capsys):
    assert main(["plan", small, "--set", "zones[0].n_particles=200", "--json", "--no-page"]) == 0
    assert json.loads(capsys.readouterr().out)["sphere_count"] == 200


def test_what_will_be_missed_is_told_last_with_exit_code_1(small, capsys):
    assert main(["plan", small, "--set", "zones[0].n_particles=5600"]) == 1
    assert capsys.readouterr().err.splitlines()[-1].startswith("packgen: will be missed: ")


def test_a_scene_with_faults_is_refused_as_a_run_refuses_it(small, capsys):
    assert main(["plan", small, "--set", "zones[0].n_particles=-1", "--set", "sede=1"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(": found")[0] for line in lines] == [
        "packgen: --set zones[0].n_particles", "packgen: --set sede",
    ]  # fmt: skip
    assert os.listdir() == ["box.yaml"]


def test_an_amount_that_is_refused_comes_with_what_it_needs(small, capsys):
    assert main(["plan", small, "--set", "zones[0].n_particles=90000"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert "--set zones[0].n_particles: found 90,000, expected at most" in lines[0]
    assert "90,000 spheres need a height of" in lines[1]
    assert os.listdir() == ["box.yaml"]


@pytest.mark.parametrize(
    ("output", "said"),
    [("mine.html", "is no page of packgen"), (".", "found a folder"), ("no/plan.html", "found no folder")],
)
def test_a_foreign_page_is_not_replaced(small, capsys, output, said):
    Path("mine.html").write_text("mine")
    assert main(["plan", small, "-o", output]) == 2
    assert said in capsys.readouterr().err
    assert Path("mine.html").read_text() == "mine"
