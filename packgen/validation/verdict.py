"""What all solvers of a run found, as ``validation.json``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any

from packgen.validation.results import SolverReport, comparison, validation_dict


@dataclass(frozen=True, slots=True)
class Verdict:
    """What all solvers of a run found; by its defaults that of a run without any.

    Attributes:
        reports: What each solver measured, by its name.
        errors: Why a solver came to no end, by its name; a line each.
        interrupted: Whether a stop left solvers out.
    """

    reports: Mapping[str, SolverReport] = field(default_factory=lambda: MappingProxyType({}))
    errors: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    interrupted: bool = False

    @property
    def missed(self) -> tuple[str, ...]:
        """A line for each limit that was missed and each solver that came to no end."""
        lines = [line for report in self.reports.values() for line in report.missed]
        return (*lines, *self.errors.values())

    @property
    def unjudged(self) -> tuple[str, ...]:
        """A line for each solver that could not judge everything."""
        return tuple(report.unjudged for report in self.reports.values() if report.unjudged)

    def rows(self) -> list[tuple[str, ...]]:
        """Return what the solvers measured side by side, as `comparison` does."""
        return comparison(list(self.reports.values()))

    def as_dict(self) -> dict[str, Any]:
        """Return the content of ``validation.json``."""
        content = validation_dict(self.reports)
        if self.errors:
            content |= {"passed": False, "errors": dict(self.errors), "interrupted": self.interrupted}
        return content

    def write(self, path: Path) -> None:
        """Write ``validation.json``."""
        text = json.dumps(self.as_dict(), indent=2, ensure_ascii=False, allow_nan=False)
        path.write_text(text + "\n", encoding="utf-8")
