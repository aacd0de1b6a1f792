"""How the algorithms of a contest stand: the medians of their beds, and why one has none."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from types import MappingProxyType
from typing import Any

from packgen.arrange.registry import find
from packgen.arrange.traits import traits_of
from packgen.sweep.table import VALIDATION, Line

__all__ = ["HEAD", "Standing", "standing_rows", "standings"]

BED_ROWS: tuple[tuple[str, str, Callable[[float], str]], ...] = (
    ("Spheres", "sphere_count", lambda value: f"{value:,.0f}"),
    ("Solid fraction, filled volume", "solid_fraction_filled", lambda value: f"{value:.4f}"),
    ("Solid fraction, core", "solid_fraction_core", lambda value: f"{value:.4f}"),
    ("Share of random close packing", "close_packing_reached", lambda value: f"{value:.3f}"),
    ("Largest overlap of two [r]", "overlap_max", lambda value: f"{value:.1e}"),
    ("Largest overlap with a wall [r]", "wall_overlap_max", lambda value: f"{value:.1e}"),
    ("Contacts, gap up to 1 % r", "contacts", lambda value: f"{value:.2f}"),
    ("Coordination number, plateau", "coordination", lambda value: f"{value:.2f}"),
    ("Rattlers", "rattlers", lambda value: f"{value:.1%}"),
    ("In a crystal", "crystal", lambda value: f"{value:.1%}"),
    ("Distance to the law of sizes", "law_distance", lambda value: f"{value:.4f}"),
    ("Stands from a friction of", "stands_from_friction", lambda value: f"{value:.2f}"),
    ("Weight not carried at its own", "weight_not_carried", lambda value: f"{value:.1%}"),
    ("Time of arranging [s]", "arrange_seconds", lambda value: f"{value:.3g}"),
    ("Time of the whole run [s]", "seconds", lambda value: f"{value:.3g}"),
    ("Peak memory [MB]", "peak_memory", lambda value: f"{value / 1e6:,.0f}"),
)
"""Label, key among the main figures, and form of each figure of a bed."""

FRICTION, CARRIED = "Stands from a friction of", "weight_not_carried"

NOTHING = frozenset({"-", "defaults"})
"""Texts of which a row that holds no other tells nothing."""

HEAD = ("May change", "Settings", "Beds")
"""Labels of what is said of an algorithm that has no bed, too."""


@dataclass(frozen=True, slots=True)
class Standing:
    """How an algorithm did.

    Attributes:
        algorithm: Its name.
        may_change: What it may change of what the scene says.
        runs: How many runs there were.
        settings: The settings that are not its defaults.
        beds: Main figures of each bed that it made, complete or not.
        verdicts: By solver, a line for each bed that it judged.
        folder: Folder of the first bed; None: there is none.
        reasons: What was missed, and why there is no bed, each once.
    """

    algorithm: str
    may_change: str
    runs: int
    settings: str = ""
    beds: tuple[Mapping[str, Any], ...] = ()
    verdicts: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: MappingProxyType({}))
    folder: str | None = None
    reasons: tuple[str, ...] = ()

    def values(self) -> dict[str, str]:
        """Return what was reached as texts by their labels: the median, and the span of several beds."""
        texts = {
            label: _spread([each[key] for each in self.beds if each.get(key) is not None], form)
            for label, key, form in BED_ROWS
        }
        if any(each.get(CARRIED) is not None for each in self.beds) and texts[FRICTION] == "-":
            texts[FRICTION] = "none"  # asked, and no friction is enough
        said = (self.may_change, self.settings or "defaults", f"{len(self.beds)} of {self.runs}")
        own = dict(zip(HEAD, said, strict=True))
        judged = {f"Verdict of {name}": "; ".join(lines) for name, lines in self.verdicts.items()}
        return {**own, **texts, **judged}

    def as_dict(self) -> dict[str, Any]:
        """Return the standing as plain data."""
        return {
            "algorithm": self.algorithm,
            "may_change": self.may_change,
            "settings": self.settings,
            "runs": self.runs,
            "beds": [dict(each) for each in self.beds],
            "verdicts": {name: list(lines) for name, lines in self.verdicts.items()},
            "reasons": list(self.reasons),
        }


def standings(
    lines: Sequence[Line],
    target: Path,
    may_change: Mapping[str, str],
    settings: Mapping[str, str] = MappingProxyType({}),
) -> list[Standing]:
    """Return how each algorithm did, in the order in which they first ran.

    Args:
        lines: The lines of all runs.
        target: The folder of the runs.
        may_change: What each algorithm may change, by its name; what its settings say where it has no entry.
        settings: The settings of each that are not its defaults, by its name.
    """
    by_name: dict[str, list[Line]] = {}
    for line in lines:
        by_name.setdefault(line.run.values["algorithm"], []).append(line)
    return [
        _standing(name, own, target, may_change.get(name) or _declared(name), settings.get(name, ""))
        for name, own in by_name.items()
    ]


def _standing(name: str, lines: Sequence[Line], target: Path, may_change: str, settings: str) -> Standing:
    made = [each for each in lines if each.figures]
    verdicts: dict[str, list[str]] = {}
    for each in made:
        for solver, text in _verdicts(target / each.run.name).items():
            verdicts.setdefault(solver, []).append(text)
    return Standing(
        name,
        may_change,
        len(lines),
        settings,
        tuple(each.figures for each in made),
        {solver: tuple(texts) for solver, texts in verdicts.items()},
        made[0].run.name if made else None,
        tuple(dict.fromkeys(each.message for each in lines if each.message)),
    )


def _declared(name: str) -> str:
    return traits_of(find(name).params).may_change


def _verdicts(folder: Path) -> dict[str, str]:
    """Return what each solver found, in a few words."""
    try:
        content = json.loads((folder / VALIDATION).read_text(encoding="utf-8"))
    except FileNotFoundError:
        return {}
    found = {}
    for name, each in content["solvers"].items():
        run = each["gravity_run"]
        moved = "" if run is None else f", moves {run['displacement_mean']:.3f} r"
        found[name] = ("passed" if each["passed"] else "failed") + moved
    return found | dict.fromkeys(content.get("errors", {}), "came to no end")


def _spread(values: Sequence[float], form: Callable[[float], str]) -> str:
    """Return the median of some values, with the span of several; a dash where there is none."""
    sound = [each for each in values if math.isfinite(each)]
    if not sound:
        return "-"
    middle, low, high = (form(each) for each in (median(sound), min(sound), max(sound)))
    return middle if low == high else f"{middle} ({low} to {high})"


def standing_rows(table: Sequence[Standing]) -> list[tuple[str, ...]]:
    """Return the standings as rows of texts: a head, and a quantity a row; none that nobody has.

    Without settings that are not defaults, there is no row of them.
    """
    columns = [each.values() for each in table]
    labels = list(dict.fromkeys(label for column in columns for label in column))
    rows = [(label, *(column.get(label, "-") for column in columns)) for label in labels]
    return [("", *(each.algorithm for each in table)), *(row for row in rows if not set(row[1:]) <= NOTHING)]
