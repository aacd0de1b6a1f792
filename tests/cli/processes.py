"""Runs of the command in processes of their own."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LATTICE = [sys.executable, "-m", "tests.cli.lattice_run"]
REAL = [sys.executable, "-m", "packgen"]


def environment(**values: str) -> dict[str, str]:
    """That of a terminal with UTF-8, which finds this copy of the project."""
    plain = {key: value for key, value in os.environ.items() if not key.startswith(("LC_", "LATTICE_"))}
    return {**plain, "PYTHONPATH": str(ROOT), "LC_ALL": "C.UTF-8", **values}


def in_shell(line: str, *arguments: str | bytes, program=LATTICE, **values: str):
    """Run a shell's line, ``"$@" > /dev/full``; ``"$@"`` is the command with these arguments."""
    command = ["sh", "-c", line, "sh", *program, *arguments]
    return subprocess.run(command, capture_output=True, env=environment(**values), check=False, timeout=120)


def start(*arguments: str, program=LATTICE, **values: str) -> subprocess.Popen[str]:
    """Start the command, and return once it waits where ``LATTICE_WAIT`` or ``LATTICE_PAUSE`` say."""
    mark = Path.cwd() / ".mark"
    mark.unlink(missing_ok=True)
    run = subprocess.Popen(
        [*program, *arguments], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        env=environment(LATTICE_MARK=str(mark), **values),
    )  # fmt: skip
    if any(name.startswith("LATTICE_") for name in values):
        wait_for(mark, run)
        mark.unlink()
    return run


def wait_for(path: Path, run: subprocess.Popen[str]) -> None:
    """Wait until a file is there."""
    end = time.monotonic() + 120
    while not path.exists():
        assert run.poll() is None, run.communicate()
        assert time.monotonic() < end
        time.sleep(0.01)
