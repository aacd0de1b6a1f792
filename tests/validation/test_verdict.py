"""The verdict of several solvers, and the ``validation.json`` that it leaves; the solvers are replaced."""

from __future__ import annotations

import json
from contextlib import contextmanager
from types import SimpleNamespace

import pytest

from packgen.errors import SolverError
from packgen.validation import Verdict, validate_decks


class Found(SimpleNamespace):
    """A solver's report, as far as the verdict reads it."""

    passed, missed, unjudged = True, (), ""

    def as_dict(self):
        return {"passed": self.passed}


@pytest.fixture
def solvers(monkeypatch, tmp_path):
    """Return what lets solvers, whose decks are there, find or raise something; they run one by one."""

    def judge(**outcomes):
        def validate(_bed, deck, *, solver, limits, on_progress):
            assert deck == tmp_path / solver
            if on_progress is not None:
                on_progress("step 0", 0.5)
            if isinstance(outcomes[solver], BaseException):
                raise outcomes[solver]
            return outcomes[solver]

        monkeypatch.setattr("packgen.validation.validate", validate)
        for name in outcomes:
            (tmp_path / name).mkdir(exist_ok=True)
        return validate_decks(None, tmp_path, [*outcomes, "absent"])

    return judge


def written(folder):
    return json.loads((folder / "validation.json").read_text(encoding="utf-8"))


def test_a_solver_that_fails_costs_the_others_nothing(solvers, tmp_path):
    verdict = solvers(yade=SolverError("yade: crashed"), lammps=Found(missed=("too soft",), passed=False))
    assert verdict.missed == ("too soft", "yade: crashed", "absent: has no deck to run")
    assert not verdict.interrupted
    assert written(tmp_path) == verdict.as_dict() == {
        "passed": False,
        "solvers": {"lammps": {"passed": False}},
        "errors": {"yade": "yade: crashed", "absent": "absent: has no deck to run"},
        "interrupted": False,
    }  # fmt: skip


def test_a_stop_leaves_out_the_rest_and_is_written_down(solvers, tmp_path):
    verdict = solvers(liggghts=Found(), yade=KeyboardInterrupt(), lammps=Found())
    assert verdict.interrupted
    assert verdict.missed == ("yade: interrupted before it was done",)
    assert written(tmp_path)["interrupted"] is True
    assert list(written(tmp_path)["solvers"]) == ["liggghts"]


def test_any_other_error_ends_the_run(solvers, tmp_path):
    with pytest.raises(ZeroDivisionError):
        solvers(yade=ZeroDivisionError())
    assert not (tmp_path / "validation.json").exists()


def test_what_could_not_be_judged_is_told_apart(solvers):
    assert solvers(yade=Found(unjudged="too short"), lammps=Found()).unjudged == ("too short",)


def test_where_all_pass_nothing_is_said_of_errors():
    assert Verdict({"yade": Found()}).as_dict() == {"passed": True, "solvers": {"yade": {"passed": True}}}
    assert Verdict().missed == Verdict().unjudged == ()


def test_each_solver_has_a_progress_of_its_own(solvers, monkeypatch, tmp_path):
    told = []

    @contextmanager
    def progress(solver):
        told.append(f"{solver} starts")
        yield lambda stage, share: told.append(f"{solver}: {stage} {share}")
        told.append(f"{solver} ends")

    solvers(yade=Found(), lammps=Found())
    validate_decks(None, tmp_path, ["yade", "lammps"], progress=progress)
    assert told == [
        "yade starts", "yade: step 0 0.5", "yade ends", "lammps starts", "lammps: step 0 0.5", "lammps ends",
    ]  # fmt: skip
