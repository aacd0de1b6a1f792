"""The curve of the benchmark of clumps: core fraction over aspect, beside published densest packings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import output

COLORS = {"rod": "#1f6fb2", "pair": "#c8641b"}
NAMES = {"rod": "rods with round ends", "pair": "pairs of spheres"}
# (aspect, fraction, what it is, colour): see the notes of the benchmark's table.
PUBLISHED = (
    (1.0, 0.64, "spheres, random close packing", output.FAINT),
    (1.45, 0.721, "rods, densest disordered (2023)", COLORS["rod"]),
    (1.45, 0.707, "pairs, theory (2013)", COLORS["pair"]),
)


def draw(rows: Sequence[Mapping[str, Any]], facts: Mapping[str, str], path: Path) -> None:
    """Draw core fractions over the aspect, a line a shape and friction."""
    figure = output.start_figure(7.5, 4.8)
    axes = figure.add_subplot(1, 1, 1)
    axes.set_title("Core fraction of clumps poured by packgen")
    for shape, color in COLORS.items():
        for friction in sorted({float(row["friction"]) for row in rows}):
            own = sorted(
                (float(row["aspect"]), float(row["core"]))
                for row in rows
                if float(row["friction"]) == friction
                and (row["shape"] == shape or (row["shape"] == "rod" and float(row["aspect"]) == 1.0))
            )
            aspects, cores = zip(*own, strict=True)
            style = "-" if friction == 0.0 else "--"
            axes.plot(aspects, cores, style, color=color, marker="o", markersize=4, linewidth=1.2)
            at, offset, side = (-1, (6, -3), "left")
            if shape == "rod":
                at, offset, side = (-1, (-12, -3), "right") if friction == 0.0 else (-2, (6, 6), "left")
            axes.annotate(
                f"{NAMES[shape]}, friction {friction:g}", (aspects[at], cores[at]), xytext=offset,
                textcoords="offset points", color=color, fontsize=8.5, ha=side,
            )  # fmt: skip
    for aspect, fraction, name, color in PUBLISHED:
        axes.scatter([aspect], [fraction], marker="x", s=45, color=color, zorder=4, label=name)
    axes.legend(loc="upper right", frameon=False, fontsize=8.5)
    axes.set_xlabel("length over width")
    axes.set_ylabel("core fraction")
    output.save_figure(figure, path, facts)
