"""The plan for 1e9 spheres: its simulation against cases whose time is known, and its script end to end."""

from __future__ import annotations

import importlib
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parent / "benchmarks" / "plan_1e9"
sys.path.append(str(FOLDER))
sys.path.append(str(FOLDER.parent))
simulate = importlib.import_module("simulate")

PLAN = simulate.Plan(1, 1, 20.0, 0.0, 1e-5, 1.0, 0.0, 1e9, spheres=1_000_000)


def test_one_machine_with_a_scheduler_that_takes_no_time_is_always_busy():
    outcome = simulate.simulate(PLAN)
    assert outcome.tiles == 4
    assert outcome.units == 4 * PLAN.layers
    assert outcome.busy == pytest.approx(1.0)
    assert outcome.seconds == pytest.approx(10.0, rel=0.03)


def test_a_scheduler_that_takes_longer_than_all_units_is_what_the_time_goes_to():
    slow = replace(PLAN, nodes=64, call=10.0)
    outcome = simulate.simulate(slow)
    assert outcome.seconds == pytest.approx(10.0 * outcome.units, rel=0.01)
    assert outcome.scheduler == pytest.approx(1.0, abs=0.01)


def test_four_stripes_keep_two_machines_busy_and_no_more():
    two, three = (simulate.simulate(replace(PLAN, nodes=nodes)) for nodes in (2, 3))
    assert 5.0 < two.seconds < 6.0
    assert three.seconds > 0.85 * two.seconds


def test_a_few_layers_tell_the_time_of_all():
    some, every = simulate.simulate(PLAN, 12), simulate.simulate(PLAN)
    assert some.seconds == pytest.approx(every.seconds, rel=0.05)


def test_cores_divide_their_share_of_a_unit():
    assert replace(PLAN, cores=4).unit_time(100.0) == pytest.approx(0.25 * PLAN.unit_time(100.0))
    assert replace(PLAN, cores=4, shared=0.0).unit_time(100.0) == pytest.approx(PLAN.unit_time(100.0))


@pytest.mark.slow
def test_the_script_says_what_breaks_first(tmp_path):
    command = [sys.executable, str(FOLDER / "simulate.py"), "--out", str(tmp_path), "--layers", "4"]
    subprocess.run(command, check=True, capture_output=True)
    text = (tmp_path / "plan_1e9.txt").read_text(encoding="utf-8")
    assert "What breaks first, and next:" in text
    assert len((tmp_path / "plan_1e9.csv").read_text(encoding="utf-8").splitlines()) > 10
