"""The plot of bed quality: displacement beside the mark, crystals, solid fraction along the height."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import output
from columns import RADIUS
from homogeneity import Imprint

COLORS = {"packgen": "#1f6fb2", "the mark": "#8a98a5", "LIGGGHTS": "#8a98a5"}
GOAL = "#c8641b"
IMPRINT_GOAL = 0.004

Rows = Sequence[Mapping[str, Any]]


def draw(rows: Rows, imprints: Sequence[Imprint], facts: Mapping[str, str], path: Path) -> None:
    """Draw four panels, as far as there is something to draw."""
    figure = output.start_figure(10.5, 6.8)
    panels = [figure.add_subplot(2, 2, place) for place in (1, 2, 3, 4)]
    moved = [row for row in rows if row["part"] == "displacement"]
    columns = [row for row in rows if row["part"] == "homogeneity"]
    _displacement(panels[0], moved)
    _crystals(panels[1], columns)
    _profile(panels[2], imprints)
    _spectrum(panels[3], imprints)
    output.save_figure(figure, path, facts)


def _displacement(axes: Any, rows: Rows) -> None:
    """One dot a bed: mean displacement over the sinking, packgen's and the mark's."""
    axes.set_title("What LIGGGHTS does to the bed")
    if not rows:
        _nothing(axes)
        return
    axes.axvline(1.0, color=GOAL, linewidth=0.9, linestyle=(0, (4, 3)))
    axes.axhline(0.12, color=GOAL, linewidth=0.9, linestyle=(0, (4, 3)))
    for name in dict.fromkeys(row["bed"] for row in rows):
        x = [100 * row["sinking"] for row in rows if row["bed"] == name]
        y = [row["displacement_mean"] for row in rows if row["bed"] == name]
        axes.scatter(x, y, s=45, color=COLORS[name], zorder=3, edgecolors="white")
        label = name if name == "packgen" else "the mark, settled by LIGGGHTS"
        axes.annotate(
            label, (max(x), np.mean(y)), xytext=(9, 0), textcoords="offset points", va="center",
            color=COLORS[name], fontweight="bold",
        )  # fmt: skip
    axes.annotate("goal", (1.0, 1.0), xycoords=("data", "axes fraction"), xytext=(3, -9),
                  textcoords="offset points", fontsize=8, color=GOAL)  # fmt: skip
    axes.set_xlim(0.0, 1.5 * max(1.0, *(100 * row["sinking"] for row in rows)))
    axes.set_ylim(0.0, 1.3 * max(0.12, *(row["displacement_mean"] for row in rows)))
    axes.set_xlabel("centre of mass sinks by [% of its height]")
    axes.set_ylabel("mean displacement [r]")


def _crystals(axes: Any, rows: Rows) -> None:
    """One dot a column: share of crystalline spheres at the walls and inside."""
    axes.set_title("Crystalline spheres")
    names = list(dict.fromkeys(row["bed"] for row in rows))
    places = {"near the walls": "crystal_walls", "inside": "crystal_inside"}
    for group, key in enumerate(places.values()):
        for index, name in enumerate(names):
            y = [100 * row[key] for row in rows if row["bed"] == name]
            x = group + 0.28 * (index - 0.5 * (len(names) - 1))
            axes.scatter([x] * len(y), y, s=45, color=COLORS[name], zorder=3, edgecolors="white")
            known = [each for each in y if not np.isnan(each)]
            if known:
                axes.annotate(
                    f"{name}\n{np.mean(known):.2g} %", (x, max(known)), xytext=(0, 7), ha="center",
                    textcoords="offset points", fontsize=8.5, color=COLORS[name],
                )  # fmt: skip
    axes.set_xticks(range(len(places)), places)
    axes.set_xlim(-0.5, len(places) - 0.5)
    shares = [100 * row[key] for row in rows for key in places.values() if not np.isnan(row[key])]
    axes.set_ylim(0.0, 1.4 * max(shares, default=1.0) + 0.1)
    axes.set_ylabel("share of the spheres [%]")


def _profile(axes: Any, imprints: Sequence[Imprint]) -> None:
    axes.set_title("Solid fraction along the height, one column")
    if not imprints:
        _nothing(axes)
        return
    found = imprints[0]
    axes.plot(found.height / (2.0 * RADIUS), found.fraction, color=COLORS["packgen"], linewidth=0.7)
    axes.set_xlabel("height [diameters]")
    axes.set_ylabel("solid fraction of the slice")


def _spectrum(axes: Any, imprints: Sequence[Imprint]) -> None:
    axes.set_title("Amplitude of the solid fraction over the period")
    if not imprints:
        _nothing(axes)
        return
    for found in imprints:
        order = np.argsort(found.periods)
        across = found.periods[order] / found.period
        axes.plot(across, found.amplitudes[order], color=COLORS["packgen"], linewidth=0.9, alpha=0.7)
        axes.scatter([1.0], [found.amplitude], color=COLORS["packgen"], s=35, zorder=3, edgecolors="white")
    axes.axhline(IMPRINT_GOAL, color=GOAL, linewidth=0.9, linestyle=(0, (4, 3)))
    axes.annotate("goal, at the layers' period", (1.0, IMPRINT_GOAL), xycoords=("axes fraction", "data"),
                  xytext=(0, 3), textcoords="offset points", ha="right", fontsize=8, color=GOAL)  # fmt: skip
    axes.axvline(1.0, color=output.FAINT, linewidth=0.8, zorder=0)
    axes.set_ylim(0.0, 1.3 * max(IMPRINT_GOAL, *(float(found.amplitudes.max()) for found in imprints)))
    axes.set_xlabel("period [of the layers' own]")
    axes.set_ylabel("amplitude")


def _nothing(axes: Any) -> None:
    axes.text(0.5, 0.5, "not measured", ha="center", color=output.FAINT, transform=axes.transAxes)
    axes.set_axis_off()
