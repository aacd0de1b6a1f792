"""The plots of a page, from ``report.json`` and ``validation.json``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from packgen.page import svg

RADIAL_REACH = 6.0  # mean diameters from the wall: beyond, a profile is flat


@dataclass(frozen=True, slots=True)
class Plot:
    """A plot: its title, what it shows in words, and its SVG text."""

    title: str
    caption: str
    svg: str


def plots(report: Mapping[str, Any], validation: Mapping[str, Any]) -> list[Plot]:
    """Return the plots that there are numbers for; reports of older versions have fewer.

    Args:
        report: Content of ``report.json``.
        validation: Content of ``validation.json``; empty without one.
    """
    drawn = [
        _size_plot(report),
        _height_plot(report),
        _radial_plot(report),
        _correlation_plot(report),
        _contact_plot(report),
        _gap_plot(report),
        _order_plot(report),
        *_validation_plots(validation),
        _time_plot(report["timings"]),
    ]
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


def _radial_plot(report: Mapping[str, Any]) -> Plot | None:
    profile = report.get("radial")
    if not profile:
        return None
    middle = [0.5 * (low + high) for low, high in pairwise(profile["wall_distance"])]
    count = sum(each <= RADIAL_REACH for each in middle)
    series = [
        svg.Series(label, middle[:count], profile[name][:count], style, colour)
        for label, name, style, colour in (
            ("this bed", "porosity", "line", 0),
            ("Mueller 1992", "mueller", "dashed", 1),
            ("de Klerk 2003", "de_klerk", "dotted", 2),
        )
        if profile[name]
    ]
    title = "Porosity near the wall"
    drawing = svg.curves(title, "distance from the wall [mean diameters]", "porosity of a shell", series)
    ratio = 2.0 * profile["radius"] / profile["diameter"]
    caption = (
        f"Exact porosity of cylindrical shells at heights from {profile['low']:.4g} to "
        f"{profile['high']:.4g} m; in the bulk {profile['bulk']:.4f}. The container is {ratio:.3g} diameters "
        "wide. Both published curves are of equal spheres."
    )
    return Plot(title, caption, drawing)


def _correlation_plot(report: Mapping[str, Any]) -> Plot | None:
    found = report.get("pair_correlation")
    if not found:
        return None
    ends = [found["distance"][0], found["distance"][-1]]
    series = [svg.Series("", found["distance"], found["g"]), svg.Series("", ends, [1.0, 1.0], "dashed", 1)]
    title = "Pair correlation g(r)"
    drawing = svg.curves(title, "distance [mean diameters]", "g(r)", series)
    caption = f"Of the core, around {found['references']:,} spheres; 1 (dashed): no order."
    return Plot(title, caption, drawing)


def _order_plot(report: Mapping[str, Any]) -> Plot | None:
    order = report.get("order")
    if not order or not sum(order["bonds"]):
        return None
    share = [100.0 * count / sum(order["bonds"]) for count in order["bonds"]]
    title = "Local order"
    names = [str(number) for number in range(len(share))]
    drawing = svg.bars(title, "neighbours with surroundings like a sphere's own", "spheres [%]", names, share)
    caption = f"From seven on, a sphere counts as part of a crystal: {100.0 * order['crystal']:.2g} % do."
    return Plot(title, caption, drawing)


def _validation_plots(validation: Mapping[str, Any]) -> list[Plot | None]:
    """Return plots that put the solvers side by side; non-finite numbers are left out."""
    solvers = validation.get("solvers", {})
    limits, moved = {}, {}
    for solver, each in solvers.items():
        zero, run, limit = each["step_zero"], each["gravity_run"], each["limits"]
        judged = run.get("judged", True)  # a run cut short tells nothing of where a bed ends
        for name, value, most in (
            ("force", zero.get("force_max"), limit["force_limit"]),
            ("moved", run["displacement_rest_mean"], limit["displacement_limit"]),
            ("sunk", run.get("sinking_rest"), limit["sinking_limit"]),
        ):
            if value is not None and most and (judged or name == "force"):
                limits[f"{solver}, {name}"] = 100.0 * max(value, 0.0) / most
        for name, key in (("mean", "displacement_mean"), ("largest", "displacement_max")):
            if run[key] is not None:
                moved[f"{solver}, {name}"] = run[key]
    shown = (
        (
            "Solvers against their limits", limits, "%",
            "Share of the limit used up: largest force at step 0, mean displacement and sinking of the "
            "centre of mass without their elastic parts; 100 % is the limit.",
        ),
        ("Displacements in the solvers", moved, "r", "In the gravity run, in mean radii."),
    )  # fmt: skip
    return [
        Plot(title, caption, svg.lying_bars(title, list(values), list(values.values()), unit))
        for title, values, unit, caption in shown
        if values
    ]


def _contact_plot(report: Mapping[str, Any]) -> Plot | None:
    entry = next((each for each in report["contacts"] if each["gap"] == 0.01), None)
    if entry is None or not entry.get("spread"):
        return None
    bodies = report.get("bodies")
    one, several = ("particle", "particles") if bodies else ("sphere", "spheres")
    total = bodies["body_count"] if bodies else report["sphere_count"]
    share = [100.0 * count / max(total, 1) for count in entry["spread"]]
    title = f"Contacts a {one}"
    names = [str(number) for number in range(len(share))]
    about = f"{one} contacts, gaps up to 1 % of the radius"
    drawing = svg.bars(title, about, f"{several} [%]", names, share)
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
