"""A suite that misses a solver says so, and does not pass in CI."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent


def run_pytest(path, ci):
    environment = {**os.environ, "PATH": str(path), "CI": ci}
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-q",
        "-p",
        "no:cacheprovider",
        "tests/validation/test_yade.py",
    ]
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)


def programs(folder, *names):
    for name in names:
        (folder / name).write_text("#!/bin/sh\n")
        (folder / name).chmod(0o755)
    return folder


def test_without_its_solver_a_test_is_skipped_and_a_line_says_so(tmp_path):
    done = run_pytest(programs(tmp_path, "lmp"), ci="")
    assert done.returncode == 0, done.stdout
    assert "solvers missing: liggghts yade; the tests that run them are skipped" in done.stdout
    assert "skipped" in done.stdout
    assert "passed" not in done.stdout


@pytest.mark.parametrize("there", [(), ("liggghts", "lmp")])
def test_in_ci_a_missing_solver_is_a_failure(tmp_path, there):
    done = run_pytest(programs(tmp_path, *there), ci="true")
    assert done.returncode != 0
    assert "CI does not pass without them" in done.stderr
    assert "yade" in done.stderr
