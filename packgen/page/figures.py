"""What a page says of a bed: key figures with their limits and verdicts, and plots, from ``report.json``."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from itertools import pairwise
from typing import Any

from packgen.page import svg
from packgen.validation.results import GravityRun, Limits, SolverReport, StepZero


@dataclass(frozen=True, slots=True)
class Figure:
    """A line of the key figures.

    Attributes:
        label: What it is.
        value: What was reached, as text.
        asked: What was asked for, or the limit; empty where there is none.
        verdict: ``ok``, ``missed``, ``not judged``, or empty.
        key: Its path in ``report.json``; empty where it is a sum of several.
        exact: Its exact value.
    """

    label: str
    value: str
    asked: str = ""
    verdict: str = ""
    key: str = ""
    exact: float | int | None = None


@dataclass(frozen=True, slots=True)
class Plot:
    """A plot: its title, what it shows in words, and its SVG text."""

    title: str
    caption: str
    svg: str


def key_figures(report: Mapping[str, Any]) -> list[Figure]:
    """Return the key figures of a report.

    Args:
        report: Content of ``report.json``.
    """
    asked = [zone["asked"] for zone in report["zones"]]
    known = bool(asked) and None not in asked
    complete = all(zone["asked"] is None or zone["placed"] >= zone["asked"] for zone in report["zones"])
    overlap, solid = report["overlap"], report["solid_fraction"]
    limit = overlap["tolerance"]
    figures = [
        Figure(
            "Spheres", f"{report['sphere_count']:,}", f"{sum(asked):,}" if known else "until full",
            _verdict(complete), "sphere_count", report["sphere_count"],
        ),
        _bounded("Largest overlap of two spheres", overlap, "overlap_max", limit),
        _bounded("Largest overlap with a wall", overlap, "wall_overlap_max", limit),
        Figure(
            "Spheres outside the container", f"{overlap['outside_count']:,}", "0",
            _verdict(overlap["outside_count"] == 0), "overlap.outside_count", overlap["outside_count"],
        ),
        Figure("Mass", mass_text(sum(each["mass"] for each in report["sets"]))),
        Figure(
            "Solid fraction, filled volume", f"{solid['filled']:.4f}",
            key="solid_fraction.filled", exact=solid["filled"],
        ),
    ]  # fmt: skip
    if solid["core"] is not None:
        figures.append(
            Figure(
                f"Solid fraction, core ({solid['core_rule']})", f"{solid['core']:.4f}",
                key="solid_fraction.core", exact=solid["core"],
            )
        )  # fmt: skip
    for place, each in enumerate(report["contacts"]):
        gap = "no gap at all" if each["gap"] == 0 else f"gap up to {100 * each['gap']:g} % of the radius"
        key = f"contacts.{place}.mean"
        figures.append(
            Figure(f"Contacts a sphere, {gap}", f"{each['mean']:.2f}", key=key, exact=each["mean"])
        )
    for place, each in enumerate(report["sizes"]):
        off = each["by_mass"]["distance_max"]
        if off is not None:
            key = f"sizes.{place}.by_mass.distance_max"
            figures.append(
                Figure(
                    f"Size curve of {each['name']}, off by", f"{100 * off:.2g} % by mass", key=key, exact=off
                )
            )
    return figures


def _bounded(label: str, overlap: Mapping[str, Any], name: str, limit: float | None) -> Figure:
    value = overlap[name]
    asked = "no limit" if limit is None else f"at most {limit:.3g} r"
    verdict = "" if limit is None else _verdict(value <= limit)
    return Figure(label, f"{value:.3g} r", asked, verdict, f"overlap.{name}", value)


def mass_text(mass: float) -> str:
    """Return a mass [kg] as text."""
    return f"{mass:,.0f} kg" if mass >= 1e5 else f"{mass:.6g} kg"


def _verdict(good: bool) -> str:
    return "ok" if good else "missed"


def solver_reports(validation: Mapping[str, Any]) -> list[SolverReport]:
    """Return the solvers' reports of ``validation.json``."""
    return [
        SolverReport(
            solver,
            each["version"],
            each["sphere_count"],
            _filled(StepZero, each["step_zero"]),
            _filled(GravityRun, each["gravity_run"]),
            _filled(Limits, each["limits"]),
        )
        for solver, each in validation.get("solvers", {}).items()
    ]


def _filled(kind: Callable[..., Any], content: Mapping[str, Any]) -> Any:
    """Return a dataclass from its JSON; numbers that JSON could not hold are no numbers again."""
    optional = {"worst_pair", "worst_wall_sphere", "worst_outside"}
    names = {each.name for each in fields(kind)}  # type: ignore[arg-type]
    return kind(
        **{
            key: math.nan if value is None and key not in optional else value
            for key, value in content.items()
            if key in names
        }
    )


def plots(report: Mapping[str, Any]) -> list[Plot]:
    """Return the plots that a report has the numbers for; reports of older versions have fewer."""
    drawn = [_size_plot(report), _height_plot(report), _contact_plot(report), _gap_plot(report)]
    drawn.append(_time_plot(report["timings"]))
    return [each for each in drawn if each is not None]


def _size_plot(report: Mapping[str, Any]) -> Plot | None:
    series = []
    for place, each in enumerate(report["sizes"]):
        curve = each["by_mass"]
        share = [100.0 * value for value in curve["share"]]
        name = each["name"]
        if curve["asked"]:
            asked = [2000.0 * value for value in curve["asked"]]
            series.append(svg.Series(f"{name}, asked", asked, share, "dashed", place))
        reached = [2000.0 * value for value in curve["reached"]]
        series.append(svg.Series(f"{name}, reached", reached, share, "dots", place))
    if not series:
        return None
    title = "Size curve"
    drawing = svg.curves(title, "diameter [mm]", "passing by mass [%]", series)
    return Plot(title, "Share of the mass in spheres up to a diameter: asked for, and reached.", drawing)


def _height_plot(report: Mapping[str, Any]) -> Plot | None:
    profile = report.get("profile") or {"height": []}
    middle = [0.5 * (low + high) for low, high in pairwise(profile["height"])]
    known = [
        (value, at)
        for value, at in zip(profile.get("solid_fraction", ()), middle, strict=True)
        if value is not None
    ]
    if not known:
        return None
    series = [svg.Series("", [each[0] for each in known], [each[1] for each in known])]
    core, ends = report["solid_fraction"]["core"], [known[0][1], known[-1][1]]
    if core is not None:
        series.append(svg.Series(f"core, {core:.4f}", [core, core], ends, "dashed", 1))
    title = "Solid fraction along the height"
    drawing = svg.curves(title, "solid fraction of a slab", "height [m]", series)
    return Plot(
        title, "Exact fraction of each slab of the container, from its floor to the bed's top.", drawing
    )


def _contact_plot(report: Mapping[str, Any]) -> Plot | None:
    entry = next((each for each in report["contacts"] if each["gap"] == 0.01), None)
    if entry is None or not entry.get("spread"):
        return None
    share = [100.0 * count / max(report["sphere_count"], 1) for count in entry["spread"]]
    title = "Contacts a sphere"
    names = [str(number) for number in range(len(share))]
    drawing = svg.bars(title, "sphere contacts, gaps up to 1 % of the radius", "spheres [%]", names, share)
    return Plot(title, f"Mean {entry['mean']:.2f}; walls are not counted.", drawing)


def _gap_plot(report: Mapping[str, Any]) -> Plot | None:
    gaps = report.get("gaps")
    if not gaps or not sum(gaps["count"]):
        return None
    edges, total = gaps["edge"], sum(gaps["count"])
    names = [f"≤{_power(edge)}" for edge in edges]
    share = [100.0 * count / total for count in gaps["count"]]
    first = next(place for place, count in enumerate(gaps["count"]) if count)
    first = min(first, edges.index(0.0))
    overlapping = sum(gaps["count"][: edges.index(0.0) + 1])
    title = "Gaps between neighbours"
    label = "gap as a fraction of the smaller radius; below 0: overlap"
    drawing = svg.bars(title, label, "pairs [%]", names[first:], share[first:])
    caption = f"{total:,} pairs nearer than {edges[-1]:.0%} of the radius; {overlapping:,} of them overlap."
    return Plot(title, caption, drawing)


def _power(value: float) -> str:
    if value == 0.0:
        return "0"
    return f"{value:g}" if abs(value) >= 0.005 else f"{value:.0e}".replace("e-0", "e-")


def _time_plot(timings: Mapping[str, float]) -> Plot | None:
    if not timings:
        return None
    title = "Time by stage"
    drawing = svg.lying_bars(title, list(timings), list(timings.values()), "s")
    return Plot(title, f"{sum(timings.values()):.1f} s in all, wall time.", drawing)


def side_by_side(reports: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Return the key figures of some reports as rows: a label, then a value a report."""
    columns = [{each.label.split(" (")[0]: each.value for each in key_figures(report)} for report in reports]
    labels = list(dict.fromkeys(label for column in columns for label in column))
    rows = [(label, *(column.get(label, "") for column in columns)) for label in labels]
    verdicts = ["missed" if report["missed"] else "complete" for report in reports]
    times = [f"{sum(report['timings'].values()):.1f} s" for report in reports]
    seeds = [str(report["settings"].get("seed", "")) for report in reports]
    return [("Verdict", *verdicts), *rows, ("Time", *times), ("Seed", *seeds)]
