"""Write README.md from page.md.j2 and the studies' CSV files: ``python examples/studies/make_page.py``.

Numbers of ours come from the files alone, so that a study that is run again changes the page. Numbers of the
paper are read from its text; its figures hold more, which nobody can read from them exactly.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import study
from jinja2 import StrictUndefined, Template

PAGE = Path(__file__).resolve().parent / "README.md"
TEMPLATE = PAGE.with_name("page.md.j2")
FURNACE_SPHERES = 430_062
NEAR = 0.02  # objectives that differ by less are as good as each other
LOAD_MAX = 0.7  # processes that wait for a core before a study whose times count
FURNACE_SECONDS = 31 * 3600 + 11 * 60


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def times(rows: list[study.Row], key: str = "seconds", factor: float = 1.0) -> str:
    """Return mean and, of several runs, least and most of a column, three digits each."""
    mean, least, most = (factor * each for each in study.spread(rows, key))
    return f"{mean:.3g}" if len(rows) == 1 else f"{mean:.3g} ({least:.3g} to {most:.3g})"


def densities(rows: list[study.Row]) -> str:
    """Return the solid fraction of the core: mean and, of several runs, least and most."""
    rows = [row for row in rows if row["core_density"] is not None]
    if not rows:
        return "-"
    mean, least, most = study.spread(rows, "core_density")
    return f"{mean:.3f}" if len(rows) == 1 else f"{mean:.3f} ({least:.3f} to {most:.3f})"


def machine_line(facts: dict[str, str], rows: list[study.Row]) -> str:
    """Return where and when a study ran, and whether the machine had something else to do."""
    runs = len({row["seed"] for row in rows}) if "seed" in rows[0] else 1
    line = (
        f"{facts['cpu']}, {facts['cores']} cores (load before: {facts['load before']}), {facts['date']}, "
        f"{facts['versions']}; {runs} {'run' if runs == 1 else 'runs'} a point."
    )
    busy = float(facts["load before"]) > LOAD_MAX and "seconds" in rows[0]
    return line + (" **The machine was busy: the times say little.**" if busy else "")


def batch_size(rows: list[study.Row]) -> str:
    """Fig. 2."""
    body = []
    for (method, size), group in study.grouped(rows, "method", "batch_size").items():
        name = "its own choice" if size is None else f"{size:,.0f}"
        cells = [times(group, "ms_a_sphere"), times(group), densities(group)]
        body.append([method, f"{group[0]['spheres']:,.0f}", name, *cells])
    head = [
        "optimiser",
        "spheres",
        "batch size",
        "time a sphere [ms]",
        "time [s]",
        "solid fraction of the core",
    ]
    return table(head, body)


def learning_rate(rows: list[study.Row]) -> str:
    """Fig. 3."""
    body = []
    for (name,), group in study.grouped(rows, "setting").items():
        last = group[-1]
        steps = "-" if last["step"] is None else f"{last['step']:,.0f}"
        cells = [
            steps,
            f"{last['best']:,.0f}",
            f"{100 * last['overlap_mean']:.2g} %",
            f"{last['seconds']:.2g}",
        ]
        body.append([name, *cells])
    ends = [group[-1] for group in study.grouped(rows, "setting").values() if group[-1]["step"] is not None]
    lowest = min(ends, key=lambda row: row["best"])
    near = [row for row in ends if row["best"] <= (1.0 + NEAR) * lowest["best"]]
    quickest = min(near, key=lambda row: row["step"])
    return (
        table(["learning rate", "steps", "best objective", "mean overlap [radii]", "time [s]"], body)
        + f"\n\nLowest of adam's: {lowest['setting']}. Of those within {100 * NEAR:g} % of it, "
        f"{quickest['setting']} takes the fewest steps."
    )


def core_density(rows: list[study.Row]) -> str:
    """Fig. 5."""
    import core_density as script

    paper = f"{script.PAPER_MEAN} ({script.PAPER_LOW} to {script.PAPER_HIGH})"
    body = [["the paper (10 runs)", "950 to 1006", paper, "below 1.1 %", "not given"]]
    against = []
    for (method,), group in study.grouped(rows, "method").items():
        _, least, most = study.spread(group, "spheres")
        mean = f"{100 * study.spread(group, 'overlap_mean')[2]:.2g} %"
        largest = f"{100 * study.spread(group, 'overlap_max')[2]:.2g} %"
        count = f"{least:.0f}" if least == most else f"{least:.0f} to {most:.0f}"
        body.append([f"{method} ({len(group)} runs)", count, densities(group), mean, largest])
        off = study.spread(group, "core_density")[0] - script.PAPER_MEAN
        against.append(f"{abs(off):.3f} {'below' if off < 0 else 'above'} it ({method})")
    head = ["", "spheres", "solid fraction of the core", "mean overlap, at most", "largest overlap [radii]"]
    return table(head, body) + f"\n\nAgainst the paper's mean, ours are {', '.join(against)}."


def threads(rows: list[study.Row]) -> str:
    """Figs. 6 and 7."""
    import threads as script

    body = [["the paper", "10,000", "64", "not given", "7.93"]]
    for (method,), group in study.grouped(rows, "method").items():
        gain = script.speedups(group)
        for (count,), some in study.grouped(group, "threads").items():
            spheres = f"{some[0]['spheres']:,.0f}"
            body.append([method, spheres, f"{count:.0f}", times(some), f"{gain[count]:.2f}"])
    return table(["optimiser", "spheres", "threads", "time [s]", "speed-up"], body)


def sphere_count(rows: list[study.Row]) -> str:
    """Fig. 8."""
    import sphere_count as script

    spheres, seconds = script.PAPER_SPHERES, script.PAPER_SECONDS
    body = [["the paper", f"{spheres:,}", f"{seconds:,}", f"{1e3 * seconds / spheres:.3g}", "about 0.6"]]
    for (method, count), group in study.grouped(rows, "method", "spheres").items():
        cells = [times(group), times(group, factor=1e3 / count), densities(group)]
        body.append([method, f"{count:,.0f}", *cells])
    return table(
        ["optimiser", "spheres", "time [s]", "time a sphere [ms]", "solid fraction of the core"], body
    )


def cone(rows: list[study.Row]) -> str:
    """Figs. 9 and 10."""
    body = []
    for (method, zone), group in study.grouped(rows, "method", "zone").items():
        _, least, most = study.spread(group, "placed")
        placed = f"{least:.0f}" if least == most else f"{least:.0f} to {most:.0f}"
        low, high = study.spread(group, "lowest_centre")[1], study.spread(group, "highest_centre")[2]
        cells = [f"{group[0]['asked']:.0f}", placed, f"{low:.2f} to {high:.2f}"]
        overlap = f"{study.spread(group, 'overlap_max')[2]:.2g}"
        body.append([method, ("sphere", "slice")[round(zone)], *cells, overlap, times(group)])
    head = [
        "optimiser",
        "zone",
        "asked",
        "placed",
        "heights of the centres [m]",
        "largest overlap [radii]",
        "time [s]",
    ]
    return table(head, body)


def furnace(rows: list[study.Row]) -> str:
    """Fig. 11."""
    body = [
        [
            "the paper",
            f"{FURNACE_SPHERES:,}",
            f"{FURNACE_SECONDS:,}",
            f"{1e3 * FURNACE_SECONDS / FURNACE_SPHERES:.3g}",
            "-",
            "31 h 11 min",
        ]
    ]
    for row in rows:
        whole = row["spheres"] >= FURNACE_SPHERES
        hours = row["ms_a_sphere"] * 1e-3 * FURNACE_SPHERES / 3600
        all_of_it = f"{3600 * hours:,.3g} s" if hours < 1 else f"{hours:,.0f} h"
        cells = [f"{row['spheres']:,.0f}", f"{row['seconds']:.3g}", f"{row['ms_a_sphere']:.3g}"]
        density = "-" if row["core_density"] is None or not whole else f"{row['core_density']:.3f}"
        body.append([row["method"], *cells, density, all_of_it + ("" if whole else " (extrapolated)")])
    head = [
        "optimiser",
        "pellets",
        "time [s]",
        "time a pellet [ms]",
        "solid fraction of the core",
        "430,062 pellets",
    ]
    return table(head, body)


TABLES: dict[str, Callable[[list[study.Row]], str]] = {
    "batch_size": batch_size,
    "learning_rate": learning_rate,
    "core_density": core_density,
    "threads": threads,
    "sphere_count": sphere_count,
    "cone": cone,
    "furnace": furnace,
}


def page(folder: Path = study.RESULTS) -> str:
    """Return the text of the page from the CSV files in a folder."""
    files = {name: study.read(folder / f"{name}.csv") for name in TABLES}
    template = Template(
        TEMPLATE.read_text(encoding="utf-8"), undefined=StrictUndefined, keep_trailing_newline=True
    )
    return template.render(
        table={name: TABLES[name](rows) for name, (_, rows) in files.items()},
        machine={name: machine_line(facts, rows) for name, (facts, rows) in files.items()},
    )


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
