"""The plot of the scaling curves: cost a sphere over spheres, layers and threads, memory, and hard cases."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import output

BLUE, ORANGE, GREY = "#1f6fb2", "#c8641b", "#b9c3cc"
COST = "time a sphere [µs]"

Rows = Sequence[Mapping[str, Any]]


def draw(summary: Rows, facts: Mapping[str, str], path: Path) -> None:
    """Draw a panel a curve, as far as it was measured."""
    panels = {
        "spheres": _spheres,
        "memory": _memory,
        "layer": _layer,
        "threads": _threads,
        "hard": _hard,
        "first run": _first_run,
    }
    figure = output.start_figure(11.5, 6.6)
    for place, (name, panel) in enumerate(panels.items()):
        axes = figure.add_subplot(2, 3, place + 1)
        axes.grid(axis="y", color="#e6e6e6", linewidth=0.6, zorder=0)
        axes.set_axisbelow(True)
        sources = {"memory": ("spheres",), "hard": ("sizes", "busy")}.get(name, (name,))
        rows = [row for row in summary if row["series"] in sources]
        if rows:
            panel(axes, rows)
        else:
            axes.text(0.5, 0.5, "not measured", ha="center", color=output.FAINT, transform=axes.transAxes)
            axes.set_axis_off()
    output.save_figure(figure, path, facts)


def _curve(axes: Any, series: Rows, color: str = BLUE) -> None:
    """Draw the cost over the value of each point, with the range over the rounds."""
    rows = [row for row in series if not math.isnan(row["value"])]
    x = [row["value"] for row in rows]
    y = [row["microseconds_a_sphere"] for row in rows]
    low = [cost - row["fastest"] for cost, row in zip(y, rows, strict=True)]
    high = [row["slowest"] - cost for cost, row in zip(y, rows, strict=True)]
    axes.errorbar(x, y, yerr=(low, high), color=color, marker="o", markersize=5, linewidth=1.4, capsize=2)
    axes.set_ylim(0.0, 1.2 * max(row["slowest"] for row in series))
    axes.set_ylabel(COST)


def _spheres(axes: Any, rows: Rows) -> None:
    _curve(axes, rows)
    axes.set_xscale("log")
    _count_ticks(axes)
    axes.set_title("Cost a sphere over their number")


def _memory(axes: Any, rows: Rows) -> None:
    x = [row["value"] for row in rows]
    peak = [row["peak_memory_MB"] / 1000.0 for row in rows]
    axes.plot(x, peak, color=BLUE, marker="o", markersize=5, linewidth=1.4)
    before = [row["memory_before_MB"] / 1000.0 for row in rows]
    axes.plot(x, before, color=GREY, linewidth=1.4)
    axes.annotate("before the first sphere", (x[0], before[0]), xytext=(2, -12), textcoords="offset points",
                  fontsize=8, color=output.FAINT)  # fmt: skip
    axes.set_xscale("log")
    _count_ticks(axes)
    axes.set_ylim(0.0, 1.15 * max(peak))
    axes.set_ylabel("peak memory [GB]")
    axes.set_title("Memory over their number")


def _count_ticks(axes: Any) -> None:
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.xaxis.set_major_locator(LogLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,.0f}"))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("spheres")


def _layer(axes: Any, rows: Rows) -> None:
    given = [row for row in rows if not math.isnan(row["value"])]
    _curve(axes, rows)
    _choice(axes, rows)
    axes.set_xlabel("thickness of a layer [diameters]")
    axes.set_xlim(left=0.0)
    axes.set_title("Cost a sphere over the layers")
    for row in given:
        if row["core_density"] is not None:
            axes.annotate(
                f"{row['core_density']:.3f}", (row["value"], row["microseconds_a_sphere"]), xytext=(0, 9),
                textcoords="offset points", ha="center", fontsize=7.5, color=output.FAINT,
            )  # fmt: skip
    axes.annotate(
        "small: core density",
        (1.0, 0.03),
        xycoords="axes fraction",
        ha="right",
        fontsize=8,
        color=output.FAINT,
    )


def _choice(axes: Any, rows: Rows) -> None:
    """Mark packgen's own choice by a line across."""
    for row in rows:
        if math.isnan(row["value"]):
            axes.axhline(row["microseconds_a_sphere"], color=ORANGE, linewidth=1.2, linestyle=(0, (4, 3)))
            axes.annotate(
                row["label"], (0.02, row["microseconds_a_sphere"]), xycoords=("axes fraction", "data"),
                xytext=(0, -11), textcoords="offset points", fontsize=8, color=ORANGE,
            )  # fmt: skip


def _threads(axes: Any, rows: Rows) -> None:
    from matplotlib.ticker import MaxNLocator

    _curve(axes, rows)
    _choice(axes, rows)
    axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    axes.set_xlabel("threads")
    axes.set_title("Cost a sphere over the threads")


def _hard(axes: Any, rows: Rows) -> None:
    _bars(axes, rows, [row["microseconds_a_sphere"] for row in rows], "{:.3g} µs, {:.2f}x")
    axes.set_xlabel(COST)
    axes.set_title("Broad sizes; a busy machine")


def _first_run(axes: Any, rows: Rows) -> None:
    _bars(axes, rows, [row["seconds_in_all"] for row in rows], "{:.1f} s")
    axes.set_xlabel("start to bed [s]")
    axes.set_title("First run (compiles) and second")


def _bars(axes: Any, rows: Rows, values: Sequence[float], text: str) -> None:
    """Draw labelled bars; the first of each curve is what the others are compared with."""
    places = range(len(rows))
    first = {row["series"]: value for row, value in reversed(list(zip(rows, values, strict=True)))}
    colors = [
        GREY if value == first[row["series"]] else BLUE for row, value in zip(rows, values, strict=True)
    ]
    axes.barh(places, values, color=colors, height=0.6)
    for place, row, value in zip(places, rows, values, strict=True):
        label = text.format(value, value / first[row["series"]])
        axes.annotate(
            label, (value, place), xytext=(4, 0), textcoords="offset points", va="center", fontsize=8.5
        )
    axes.set_yticks(places, [row["label"].replace(", ", ",\n") for row in rows])
    axes.invert_yaxis()
    axes.set_xlim(0.0, 1.45 * max(values))
    axes.grid(visible=False)
