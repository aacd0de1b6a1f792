"""How the algorithms of a contest stand."""

from __future__ import annotations

import json

from packgen.contest import standing_rows, standings
from packgen.summary import FIGURES
from packgen.sweep.over import Run
from packgen.sweep.table import Line


def line(name, seed, code=0, message="", **figures):
    known = dict.fromkeys(FIGURES) | figures if code < 2 else {}
    return Line(Run(f"{name}_{seed}", {"algorithm": name, "seed": str(seed)}), code, known, message)


def test_figures_are_medians_with_the_span_of_several_beds(tmp_path):
    lines = [line("A", seed, solid_fraction_core=core) for seed, core in enumerate((0.6, 0.7, 0.61))]
    rows = dict(standing_rows(standings(lines, tmp_path, {"A": "radii"})))
    assert rows["Solid fraction, core"] == "0.6100 (0.6000 to 0.7000)"
    assert rows["Beds"] == "3 of 3"
    assert rows["May change"] == "radii"
    assert "Peak memory [MB]" not in rows  # nobody has it
    assert "Settings" not in rows  # all have their defaults


def test_settings_that_are_not_defaults_are_told(tmp_path):
    found = standings(
        [line("A", 0), line("B", 0)], tmp_path, {"A": "nothing", "B": "radii"}, {"B": "lr: 0.1"}
    )
    rows = {label: values for label, *values in standing_rows(found)}
    assert rows["Settings"] == ["defaults", "lr: 0.1"]


def test_a_bed_that_no_friction_holds_is_told_from_one_that_nobody_asked(tmp_path):
    lines = [line("A", 0, weight_not_carried=0.7), line("B", 0), line("C", 0, stands_from_friction=0.4)]
    rows = {
        label: values
        for label, *values in standing_rows(standings(lines, tmp_path, dict.fromkeys("ABC", "nothing")))
    }
    assert rows["Stands from a friction of"] == ["none", "-", "0.40"]
    assert rows["Weight not carried at its own"] == ["70.0%", "-", "-"]


def test_what_an_algorithm_declares_counts_where_its_settings_say_nothing(tmp_path):
    found = standings([line("DISPERSED", 0, 2, "why"), line("JAMMED", 0)], tmp_path, {"JAMMED": "count"})
    assert [each.may_change for each in found] == ["nothing", "count"]


def test_reasons_are_told_once_and_a_bed_that_misses_something_counts(tmp_path):
    lines = [
        line("A", 0, 1, "9 found no place", sphere_count=91), line("A", 1, 2, "no room"),
        line("A", 2, 2, "no room"),
    ]  # fmt: skip
    [found] = standings(lines, tmp_path, {"A": "nothing"})
    assert (found.folder, len(found.beds), found.reasons) == ("A_0", 1, ("9 found no place", "no room"))


def test_solvers_verdicts_are_those_of_the_folders(tmp_path):
    (tmp_path / "A_0").mkdir()
    judged = {"passed": True, "gravity_run": {"displacement_mean": 0.0123}}
    content = {"passed": False, "solvers": {"liggghts": judged}, "errors": {"yade": "hangs"}}
    (tmp_path / "A_0" / "validation.json").write_text(json.dumps(content))
    [found] = standings([line("A", 0)], tmp_path, {"A": "nothing"})
    assert found.values()["Verdict of liggghts"] == "passed, moves 0.012 r"
    assert found.values()["Verdict of yade"] == "came to no end"
