"""What a page says of a bed: key figures with their limits and verdicts, from ``report.json``."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from packgen.bed import UNKNOWN
from packgen.settlement import LABELS, BedFigures, Settling
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


def key_figures(report: Mapping[str, Any]) -> list[Figure]:
    """Return the key figures of a report.

    Args:
        report: Content of ``report.json``.
    """
    asked = [zone["asked"] for zone in report["zones"]]
    gone_on, new = report.get("start_from"), report["overlap"].get("new")
    before = 0 if gone_on is None else gone_on["earlier_count"]
    known = bool(asked) and None not in asked
    walls = report["settings"].get("walls") != UNKNOWN
    complete = all(zone["asked"] is None or zone["placed"] >= zone["asked"] for zone in report["zones"])
    overlap, solid = report["overlap"], report["solid_fraction"]
    limit, kind = overlap["tolerance"], "DEM bed, " if report.get("settling") else ""
    if new is not None:  # spheres that were there before may overlap each other by more
        limit, kind = overlap["earlier_tolerance"], "DEM bed, "
    figures = [
        *_counted(
            report,
            f"{before + sum(asked):,}" if known else "until full" if asked else "",
            _verdict(complete) if asked else "",
        ),
        *_of_new(overlap),
        _bounded("Largest overlap of two spheres", overlap, "overlap_max", limit, kind),
        *(_of_walls(overlap, limit, kind) if walls else [Figure("Walls", UNKNOWN, verdict="not judged")]),
        Figure("Mass", mass_text(_total([each["mass"] for each in report["sets"]]))),
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
    packing = report.get("close_packing")
    if packing:
        part = "core" if packing["of"] == "core" else "filled volume"
        label = f"Share of random close packing, {part}"
        value = f"{packing['reached']:.2f} of {packing['fraction']:.4f}"
        figures.append(Figure(label, value, key="close_packing.reached", exact=packing["reached"]))
    for place, each in enumerate(report["contacts"]):
        gap = "no gap at all" if each["gap"] == 0 else f"gap up to {100 * each['gap']:g} % r"
        key = f"contacts.{place}.mean"
        figures.append(
            Figure(
                f"Contacts a {'particle' if report.get('bodies') else 'sphere'}, {gap}",
                f"{each['mean']:.2f}",
                key=key,
                exact=each["mean"],
            )
        )
    figures += _structure(report)
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


def _counted(report: Mapping[str, Any], asked: str, verdict: str) -> list[Figure]:
    """Return the figures of how many spheres there are, and clumps, and of how these lie."""
    spheres, bodies = report["sphere_count"], report.get("bodies")
    if not bodies:
        return [Figure("Spheres", f"{spheres:,}", asked, verdict, "sphere_count", spheres)]
    count, clumps = bodies["body_count"], bodies["clump_count"]
    figures = [
        Figure("Particles", f"{count:,}", asked, verdict, "bodies.body_count", count),
        Figure("Clumps among them", f"{clumps:,}", key="bodies.clump_count", exact=clumps),
        Figure("Spheres of all particles", f"{spheres:,}", key="sphere_count", exact=spheres),
    ]
    for place, each in enumerate(bodies["shapes"]):
        if each["order"] is not None:
            angle = each["angle_to_gravity"]
            told = "" if angle is None else f", {angle:.1f}°"
            label = f"Order of the {each['axis']} axes of {each['name']}, angle to gravity (random: 0, 57.3°)"
            key = f"bodies.shapes.{place}.order"
            figures.append(Figure(label, f"{each['order']:.3f}{told}", key=key, exact=each["order"]))
    return figures


def _structure(report: Mapping[str, Any]) -> list[Figure]:
    """Return the figures of how spheres are held and ordered; reports of older versions have none."""
    figures = []
    for place, each in enumerate(report["contacts"]):
        if each["gap"] == 0.01 and "rattlers" in each:
            label = "Rattlers (fewer than 4 contacts, gap up to 1 % r)"
            figures.append(_percent(label, each["rattlers"], f"contacts.{place}.rattlers"))
    order = report.get("order") or {}
    for name, label in (
        ("crystal", "Spheres in a crystal"),
        ("crystal_wall", "Spheres in a crystal, of those at a wall"),
        ("crystal_core", "Spheres in a crystal, of those in the core"),
    ):
        if order.get(name) is not None:
            figures.append(_percent(label, order[name], f"order.{name}"))
    return figures + _balance(report)


def _jammed(report: Mapping[str, Any]) -> list[Figure]:
    """Return the figures of a jammed bed."""
    jamming = report.get("jamming")
    if not jamming:
        return []
    verdict = "proven" if jamming["proven"] else "not proven"
    label = f"Jammed ({jamming['certificate']}), contacts beyond isostatic"
    excess = jamming["isostatic_excess"]
    value = f"{excess:+,} of {jamming['contacts']:,}, {verdict}"
    scaled = f"{jamming['factor']:.6g} times that asked for"
    return [
        Figure(label, value, key="jamming.isostatic_excess", exact=excess),
        Figure("Container", scaled, key="jamming.factor", exact=jamming["factor"]),
    ]


def _found(report: Mapping[str, Any]) -> list[Figure]:
    """Return the figures of a bed that was searched for."""
    found = report.get("search")
    if not found:
        return []
    label = f"Largest {found['maximized']} found, by {found['hits']:,} of {found['starts']:,} starts"
    value = f"{found['value']:.10g}"
    figures = [Figure(label, value, key="search.value", exact=found["value"])]
    if found["bound"] is not None:
        verdict = "proven" if found["proven"] else f"{found['gap']:.2%} above"
        text = f"{found['bound']:.10g}, {verdict}"
        figures.append(
            Figure(f"Its bound: {found['bound_by']}", text, key="search.bound", exact=found["bound"])
        )
    if found["cell"] is not None:
        a, b, c, *angles = found["cell"]
        edges = f"{a:.6g} x {b:.6g} x {c:.6g} m"
        figures.append(Figure("Edges of the cell", edges, key="search.cell.0", exact=a))
        turned = ", ".join(f"{each:.4g}" for each in angles)
        figures.append(Figure("Angles of the cell, degrees", turned, key="search.cell.3", exact=angles[0]))
    return figures


def _balance(report: Mapping[str, Any]) -> list[Figure]:
    """Return the figures of what carries the spheres; reports of older versions have none."""
    figures = [*_jammed(report), *_found(report)]
    number = report.get("coordination") or {}
    if number.get("plateau") is not None:
        low, high = number["plateau_low"], number["plateau_high"]
        label = f"Contacts a sphere with walls, plateau (gaps of {low:.2g} to {high:.2g} r)"
        value = number["plateau"]
        figures.append(Figure(label, f"{value:.2f}", key="coordination.plateau", exact=value))
        if number["rattlers"] is not None:  # of a bed in pieces they are not known
            label = "Rattlers, taken out one after the other (contacts of the plateau)"
            figures.append(_percent(label, number["rattlers"], "coordination.rattlers"))
    stands = report.get("stands_at_friction")
    if stands:
        least = stands["friction_least"]
        looked_at = f"{stands['blocks']} blocks" if stands["blocks"] else "whole bed"
        label = f"Least friction at which the bed stands ({looked_at})"
        value = "none" if least is None else f"{least:.2g}"
        figures.append(Figure(label, value, key="stands_at_friction.friction_least", exact=least))
        label = "Weight that contacts cannot carry at its own friction"
        figures.append(_percent(label, stands["not_carried"], "stands_at_friction.not_carried"))
    forces = report.get("step_zero")
    if forces:
        label = "Largest force at step 0, predicted"
        value = forces["force_max"]
        figures.append(Figure(label, f"{value:.3g} W", key="step_zero.force_max", exact=value))
    return figures


def _percent(label: str, share: float, key: str) -> Figure:
    return Figure(label, f"{100.0 * share:.2g} %", key=key, exact=share)


def _bounded(label: str, overlap: Mapping[str, Any], name: str, limit: float | None, kind: str) -> Figure:
    value = overlap[name]
    asked = kind + ("no limit" if limit is None else f"at most {limit:.3g} r")
    verdict = "" if limit is None else _verdict(value <= limit)
    return Figure(label, f"{value:.3g} r", asked, verdict, f"overlap.{name}", value)


def _of_new(overlap: Mapping[str, Any]) -> list[Figure]:
    """Return the figures of the new spheres of a bed that goes on from another."""
    if overlap.get("new") is None:
        return []
    label, limit = "Largest overlap of a new sphere", overlap["tolerance"]
    pair = _bounded(label, overlap["new"], "overlap_max", limit, "")
    wall = _bounded(f"{label} with a wall", overlap["new"], "wall_overlap_max", limit, "")
    return [replace(each, key=f"overlap.new.{each.key.split('.')[1]}") for each in (pair, wall)]


def _of_walls(overlap: Mapping[str, Any], limit: float | None, kind: str) -> list[Figure]:
    """Return the figures that only a bed in known walls has."""
    return [
        _bounded("Largest overlap with a wall", overlap, "wall_overlap_max", limit, kind),
        Figure(
            "Spheres outside the container", f"{overlap['outside_count']:,}", "0",
            _verdict(overlap["outside_count"] == 0), "overlap.outside_count", overlap["outside_count"],
        ),
    ]  # fmt: skip


def _total(masses: Sequence[float | None]) -> float | None:
    """Return the sum of masses [kg]; None where one is not known."""
    known = [each for each in masses if each is not None]
    return sum(known) if len(known) == len(masses) else None


def mass_text(mass: float | None) -> str:
    """Return a mass [kg] as text."""
    if mass is None:
        return UNKNOWN
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
            each.get("body_count"),
        )
        for solver, each in validation.get("solvers", {}).items()
    ]


def _filled(kind: Callable[..., Any], content: Mapping[str, Any]) -> Any:
    """Return a dataclass from its JSON; numbers that JSON cannot hold become NaN again."""
    optional = {"worst_pair", "worst_wall_sphere", "worst_outside", "force_limit"}
    names = {each.name for each in fields(kind)}  # type: ignore[arg-type]
    return kind(
        **{
            key: math.nan if value is None and key not in optional else value
            for key, value in content.items()
            if key in names
        }
    )


def settling_of(report: Mapping[str, Any]) -> Settling | None:
    """Return how a solver settled the bed of a ``report.json``; None where none did, or it is older."""
    found = report.get("settling")
    if not found:
        return None
    sides = {side: BedFigures(**found[side]) for side in ("before", "after")}
    return Settling(**{**found, **sides})


def settling_rows(report: Mapping[str, Any]) -> list[tuple[str, str, str]]:
    """Return the bed as packed and as settled, rows of a label and two values; none where it was not."""
    settling = settling_of(report)
    if settling is None:
        return []
    sides = zip(LABELS, settling.before.cells(), settling.after.cells(), strict=True)
    return [(f"{label[0].upper()}{label[1:]}", before, after) for label, before, after in sides]


def side_by_side(reports: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    """Return the key figures of some reports as rows: a label, then a value a report."""
    columns = [{each.label.split(" (")[0]: each.value for each in key_figures(report)} for report in reports]
    labels = list(dict.fromkeys(label for column in columns for label in column))
    rows = [(label, *(column.get(label, "") for column in columns)) for label in labels]
    verdicts = ["missed" if report["missed"] else "complete" for report in reports]
    times = [f"{sum(report['timings'].values()):.1f} s" for report in reports]
    seeds = [str(report["settings"].get("seed", "")) for report in reports]
    return [("Verdict", *verdicts), *rows, ("Time", *times), ("Seed", *seeds)]
