"""Pages as HTML: one file each, with all that it needs inside."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from packgen.page.figures import (
    key_figures,
    mass_text,
    settling_of,
    settling_rows,
    side_by_side,
    solver_reports,
)
from packgen.page.plots import Plot, plots
from packgen.version import __version__

MARKS = {"ok": "✔ ok", "complete": "✔ complete", "missed": "✘ missed", "not judged": "○ not judged"}
CLASSES = {"ok": "ok", "complete": "ok", "missed": "missed"}


def template_root() -> Path:
    """Return the folder of the pages' templates: inside the installed package, else that of the checkout."""
    installed = Path(str(files("packgen.page") / "templates"))
    checkout = Path(__file__).resolve().parent.parent.parent / "templates" / "report"
    return installed if installed.is_dir() else checkout


def report_html(
    name: str, report: Mapping[str, Any], validation: Mapping[str, Any], view: Mapping[str, Any]
) -> str:
    """Return the page of a bed.

    Args:
        name: What the bed is called.
        report: Content of ``report.json``.
        validation: Content of ``validation.json``; empty without one.
        view: What `packgen.page.spheres.view_data` gives.
    """
    sets = [each["name"] for each in report["sets"]]
    colours = [("set", "set"), ("zone", "zone"), ("batch", "batch"), ("radius", "radius")]
    colours += [("body", "body")] if "body" in view else []
    one_size = view["radius_max"] - view["radius_min"] <= 1e-9 * view["radius_max"]
    return environment().get_template("report.html.j2").render(
        name=name,
        report={"warnings": [], **report},  # older versions had none
        figures=key_figures(report),
        solvers=solver_reports(validation),
        settling=settling_of(report),
        settling_rows=settling_rows(report),
        plots=[_safe(each) for each in plots(report, validation)],
        view=view,
        colours=colours,
        colour="set" if len(sets) > 1 else "body" if "body" in view else "batch" if one_size else "radius",
        facts=_facts(report),
        settings=json.dumps(report["settings"], indent=2, ensure_ascii=False),
        report_data=inside_script(report),
        view_data=inside_script({**view, "sets": sets}),
    )  # fmt: skip


def comparison_html(names: Sequence[str], reports: Sequence[Mapping[str, Any]]) -> str:
    """Return the page that puts beds side by side.

    Args:
        names: What the beds are called.
        reports: Content of each ``report.json``.
    """
    return environment().get_template("compare.html.j2").render(
        names=names,
        rows=side_by_side(reports),
        plots=plots_by_title(names, reports),
        version=__version__,
    )  # fmt: skip


def plots_by_title(
    names: Sequence[str], reports: Sequence[Mapping[str, Any]]
) -> list[tuple[str, list[tuple[str, Plot]]]]:
    """Return the plots of some beds, those of one kind together, each with the name of its bed."""
    by_title: dict[str, list[tuple[str, Plot]]] = {}
    for name, report in zip(names, reports, strict=True):
        for plot in plots(report, {}):
            by_title.setdefault(plot.title, []).append((name, _safe(plot)))
    return list(by_title.items())


def _facts(report: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return what made the bed, as rows of a label and a value."""
    settings = report["settings"]
    inner = settings.get("settings", {})
    rows = [
        ("Scene", str(settings.get("scene", "not known"))),
        ("Seed", str(settings.get("seed", "not known"))),
    ]
    if "read_from" in settings:
        rows.append(("Read from", f"{settings['read_from']}, {settings.get('format', '')}"))
    if report.get("start_from") is not None:
        rows.append(("Goes on from", _gone_on(report["start_from"])))
    rows += _reshaped(settings)
    params = inner.get("params", {})
    if params.get("optimizer") and "algorithm" in settings:
        tiled = ", in tiles" if params.get("tile") else ""
        rows.append(("Algorithm", f"{settings['algorithm']}, optimiser {params['optimizer']}{tiled}"))
    kind = "particles" if report.get("bodies") else "spheres"
    rows.append(("Version", f"packgen {report['packgen']}"))
    rows += [
        (
            f"Set {each['name']}",
            f"{each['count']:,} {kind}, {each['volume']:.6g} m³, {mass_text(each['mass'])}",
        )
        for each in report["sets"]
    ]
    rows += [
        (f"Zone {place}", f"{each['placed']:,} {kind} of {_wanted(each['asked'])}")
        for place, each in enumerate(report["zones"])
    ]
    rows += [(f"Time, {stage}", f"{seconds:.2f} s") for stage, seconds in report["timings"].items()]
    if report["peak_memory"] is not None:
        rows.append(("Peak memory", f"{report['peak_memory'] / 1e6:,.0f} MB"))
    rows.append(("Files", ", ".join(report["files"])))
    return rows


def _gone_on(told: Mapping[str, Any]) -> str:
    held = {"surface": ", surface re-opened", "fixed": ", held where they were"}.get(told["hold"], "")
    return f"{told['path']}: {told['earlier_count']:,} spheres{held}; {told['new_count']:,} new"


def _reshaped(settings: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return rows that say of which bed this one is a part, or copies."""
    rows = []
    part, copies = settings.get("carved"), settings.get("repeated")
    if part is not None:
        cut = ", cut spheres too" if part["touching"] else ""
        rows.append(("Part", f"{part['side']} {part['mesh']}{cut}, of {part['spheres_before']:,} spheres"))
    if copies is not None:
        counts = " x ".join(map(str, copies["counts"]))
        rows.append(("Copies", f"{counts} of {copies['spheres_before']:,} spheres"))
    return rows


def _wanted(asked: int | None) -> str:
    return "as many as fit" if asked is None else f"{asked:,} asked for"


def environment() -> Environment:
    """Return the environment of the pages' templates."""
    environment = Environment(
        loader=FileSystemLoader(template_root(), encoding="utf-8"),
        undefined=StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals["mark"] = _mark
    return environment


def _mark(verdict: str) -> Markup:
    """Return a verdict as a sign and a word, which do not need their colour."""
    if not verdict:
        return Markup("")
    return Markup('<span class="{}">{}</span>').format(CLASSES.get(verdict, ""), MARKS.get(verdict, verdict))


def _safe(plot: Plot) -> Plot:
    """Return a plot whose SVG, which escapes its texts itself, goes into the page as it is."""
    return replace(plot, svg=Markup(plot.svg))


def inside_script(content: Mapping[str, Any]) -> Markup:
    """Return JSON that cannot end the script element around it."""
    # Python writes NaN, which no browser reads.
    finite = json.loads(json.dumps(content), parse_constant=lambda _: None)
    text = json.dumps(finite, ensure_ascii=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c"))
