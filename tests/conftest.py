"""Seeds are raised by ``--seed-shift``. A missing solver is a failure in CI; elsewhere a line tells of it."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator

import pytest

from packgen.validation.process import SOLVERS
from tests.seeds import raise_seeds


def missing_solvers() -> list[str]:
    """Debian's packages of the solvers whose programs are not on the PATH."""
    return [package for program, package in SOLVERS.values() if shutil.which(program) is None]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--seed-shift",
        metavar="N",
        type=int,
        default=0,
        help="raise the seeds of all scenes by N: what the tests claim holds for any seed",
    )


@pytest.fixture(scope="session", autouse=True)
def _raised_seeds(request: pytest.FixtureRequest) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        if by := request.config.getoption("--seed-shift"):
            raise_seeds(patch, by)
        yield


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
