"""The plot of speed against error: time a sphere over the largest overlap, density as colour."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import output

MARKERS = {"projection": "o", "adam": "s", "the paper's": "D", "spheropack": "^", "LIGGGHTS": "v"}
BAND = 2.6  # width of the band of beds without overlap, in decades
GAP = 0.5  # between it and the smallest overlap that was found, likewise


def draw(summary: Sequence[Mapping[str, Any]], facts: Mapping[str, str], path: Path) -> None:
    """Draw the medians of all cases.

    No overlap has no place on a logarithmic axis: such beds stand in a band of their own at the left edge,
    side by side, where the distance from the band's edge says nothing.
    """
    from matplotlib.colors import Normalize

    figure = output.start_figure(9.4, 5.6)
    axes = figure.add_subplot()
    found = [row["overlap_max"] for row in summary if row["overlap_max"] > 0.0]
    edge = math.floor(math.log10(min(found, default=1e-3)) - GAP)
    least, most = _densities(summary)
    colors = Normalize(least, most)
    points = None
    for method in dict.fromkeys(row["method"] for row in summary):
        rows = [row for row in summary if row["method"] == method]
        x = _places(rows, edge)
        y = [row["microseconds_a_sphere"] for row in rows]
        shade = [row["core_density"] if row["core_density"] is not None else math.nan for row in rows]
        axes.plot(x, y, color=output.FAINT, linewidth=0.8, zorder=1)
        points = axes.scatter(
            x, y, c=shade, norm=colors, cmap="viridis", marker=MARKERS[method], s=60, zorder=3,
            edgecolors="white", linewidths=0.7, plotnonfinite=True,
        )  # fmt: skip
        _label(axes, method, rows, x, y)
    _scales(axes, edge, found)
    if points is not None:
        bar = figure.colorbar(points, ax=axes, pad=0.01, aspect=30)
        bar.set_label("core density (solid fraction)")
        bar.outline.set_visible(False)
    axes.set_title("Time a sphere against the largest overlap left (lower left is better); small: setting")
    output.save_figure(figure, path, facts)


def _densities(summary: Sequence[Mapping[str, Any]]) -> tuple[float, float]:
    """Return the range of the colours: hundredths around the densities found."""
    found = [row["core_density"] for row in summary if row["core_density"] is not None] or [0.6]
    return math.floor(100 * min(found)) / 100, math.ceil(100 * max(found) + 0.01) / 100


def _places(rows: Sequence[Mapping[str, Any]], edge: int) -> list[float]:
    """Return where a method's cases stand on the axis; those without overlap share the band evenly."""
    without = [index for index, row in enumerate(rows) if row["overlap_max"] == 0.0]
    slot = {index: (place + 0.5) / len(without) for place, index in enumerate(without)}
    return [
        10.0 ** (edge - BAND * slot[index]) if index in slot else row["overlap_max"]
        for index, row in enumerate(rows)
    ]


def _label(
    axes: Any, method: str, rows: Sequence[Mapping[str, Any]], x: Sequence[float], y: Sequence[float]
) -> None:
    """Write the method to the right of its points, and each setting below its point."""
    right = max(range(len(rows)), key=lambda index: x[index])
    spot = {"xy": (x[right], y[right]), "textcoords": "offset points", "va": "center"}
    axes.annotate(method, **spot, xytext=(10, 5), fontweight="bold", zorder=4)
    count = f"{rows[0]['spheres']:,.0f} spheres"
    axes.annotate(count, **spot, xytext=(10, -6), fontsize=7.5, color=output.FAINT, zorder=4)
    for row, across, up in zip(rows, x, y, strict=True):
        axes.annotate(
            _short(row["setting"]), (across, up), xytext=(0, -14), textcoords="offset points", ha="center",
            fontsize=7.5, color=output.FAINT,
        )  # fmt: skip


def _short(setting: str) -> str:
    """Return a setting as the plot shows it: numbers as powers of ten."""
    text = setting.replace("tolerance ", "")
    return re.sub(r"(\d)e([+-]\d+)", lambda found: _power(found.group(1), int(found.group(2))), text)


def _power(digit: str, exponent: int) -> str:
    return f"${'' if digit == '1' else digit + ' '}10^{{{exponent}}}$".replace(" 10", r"\cdot 10")


def _scales(axes: Any, edge: int, found: Sequence[float]) -> None:
    from matplotlib.ticker import FixedLocator, NullLocator

    last = math.ceil(math.log10(max(found, default=1e-2)) + 0.8)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(10.0 ** (edge - BAND), 10.0**last)
    axes.axvspan(10.0 ** (edge - BAND), 10.0**edge, color="#eef2f5", zorder=0)
    decades = [10.0**power for power in range(edge + 1, last + 1)]
    axes.xaxis.set_major_locator(FixedLocator([10.0 ** (edge - BAND / 2), *decades]))
    axes.xaxis.set_minor_locator(NullLocator())
    names = [_percent(decade) if decade <= 1.0 else "" for decade in decades]
    axes.set_xticklabels(["no overlap", *names])
    axes.set_xlabel("largest overlap, of the smaller radius")
    axes.set_ylabel("time a sphere [µs]")
    output.plain_ticks(axes.yaxis)
    axes.grid(axis="y", color="#e3e3e3", linewidth=0.6, zorder=0)
    axes.margins(y=0.15)


def _percent(share: float) -> str:
    return f"{100 * share:g} %"
