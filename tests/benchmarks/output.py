"""What every benchmark writes: a CSV of every single run, a table of medians, a plot."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from matplotlib.figure import Figure

INK = "#222222"
FAINT = "#8a8a8a"


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]], facts: Mapping[str, str]) -> None:
    """Write runs as CSV, one row a run, the machine's facts as comment lines above."""
    columns = list(dict.fromkeys(key for row in rows for key in row))
    with path.open("w", encoding="utf-8", newline="") as file:
        file.writelines(f"# {name}: {value}\n" for name, value in facts.items())
        writer = csv.DictWriter(file, columns, restval="", lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def write_text(
    path: Path, title: str, facts: Mapping[str, str], parts: Iterable[str], notes: Iterable[str] = ()
) -> None:
    """Write a title, the machine's facts, tables, and notes below."""
    lines = [title, "", *(f"{name}: {value}" for name, value in facts.items())]
    for part in parts:
        lines += ["", part]
    notes = list(notes)
    if notes:
        lines += ["", *notes]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return rows below a head in aligned columns: the first flush left, the others flush right."""
    cells = [tuple(head), *(tuple(row) for row in rows)]
    width = [max(len(row[column]) for row in cells) for column in range(len(head))]
    lines = []
    for row in cells:
        first = row[0].ljust(width[0])
        lines.append("  ".join([first, *(cell.rjust(w) for cell, w in zip(row[1:], width[1:], strict=True))]))
    lines.insert(1, "  ".join("-" * each for each in width))
    return "\n".join(line.rstrip() for line in lines)


def number(value: float | None, digits: int = 3) -> str:
    """Return a number as tables show it; a dash for none."""
    if value is None or math.isnan(value):
        return "-"
    return "0" if value == 0 else f"{value:.{digits}g}"


def start_figure(width: float, height: float) -> Figure:
    """Return an empty figure [inches] in the benchmarks' look."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    plt.rcParams.update(
        {
            "font.size": 10,
            "axes.spines.top": False,
            "axes.spines.right": False,
            "axes.edgecolor": FAINT,
            "axes.labelcolor": INK,
            "xtick.color": INK,
            "ytick.color": INK,
            "text.color": INK,
            "axes.titlelocation": "left",
            "axes.titlesize": 11,
        }
    )
    return plt.figure(figsize=(width, height), layout="constrained")


def save_figure(figure: Figure, path: Path, facts: Mapping[str, str]) -> None:
    """Write a figure with the machine and the date below it."""
    figure.supxlabel(
        f"{facts['cpu']}, {facts['cores']} cores, {facts['date']}, {facts['versions']}",
        fontsize=7,
        color=FAINT,
        x=0.01,
        ha="left",
    )
    figure.savefig(path, dpi=160)


def plain_ticks(axis: Any) -> None:
    """Label a logarithmic axis with plain numbers at 1, 2 and 5 of each decade."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:,g}"))
    axis.set_minor_formatter(NullFormatter())
