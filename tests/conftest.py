"""In CI a missing solver is a failure; elsewhere a line says that the tests that run it are skipped."""

from __future__ import annotations

import os
import shutil

import pytest

from packgen.validation.process import SOLVERS


def missing_solvers() -> list[str]:
    """Debian's packages of the solvers whose programs are not on the PATH."""
    return [package for program, package in SOLVERS.values() if shutil.which(program) is None]


def pytest_configure(config: pytest.Config) -> None:
    missing = missing_solvers()
    if missing and os.environ.get("CI") == "true":
        raise pytest.UsageError(
            f"solvers missing: {' '.join(missing)}; CI does not pass without them:"
            f" apt-get install --no-install-recommends {' '.join(missing)}"
        )


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    missing = missing_solvers()
    if missing:
        terminalreporter.write_line(
            f"solvers missing: {' '.join(missing)}; the tests that run them are skipped"
        )
