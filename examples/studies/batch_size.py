"""Fig. 2: how the batch size changes the time to pack a box, and the bed.

    python examples/studies/batch_size.py [--full]

The paper packs 10,000 equal spheres in "a box", sizes not given. Here the box is 2 m wide, and the radius is
the one of which 10,000 spheres fill its 2 m of height. Projection turns a batch size into a thickness of its
layers; its own choice, without a batch size, is the last point.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import study
from study import columns, output

NAME = "batch_size"
WIDTH, RADIUS = 2.0, 0.048  # m; 10,000 spheres at a solid fraction of 0.58
BATCHES = (125, 250, 500, 1000, 2000)
SPHERES = {study.ADAM: 2000, study.PROJECTION: 10_000}
SPHERES_FULL = 10_000


def measure(options: argparse.Namespace) -> list[study.Row]:
    """Return a row for each method, batch size and seed."""
    rows = []
    for method, usual in SPHERES.items():
        count = options.spheres or (SPHERES_FULL if options.full else usual)
        study.warm_up(method)
        sizes: list[int | None] = [*options.batches, None] if method == study.PROJECTION else options.batches
        for seed in study.seeds_of(options):
            for size in sizes:
                params = {"optimizer": method} | ({} if size is None else {"batch_size": size})
                document = columns.column_document(
                    count, seed=seed, params=params, width=options.width, radius=RADIUS
                )
                bed, seconds = columns.arrange(document)
                rows.append(
                    {
                        "method": method, "batch_size": size, "seed": seed, "spheres": bed.count,
                        "seconds": round(seconds, 4), "ms_a_sphere": round(1e3 * seconds / bed.count, 5),
                        **study.quality(bed),
                    }
                )  # fmt: skip
                print(rows[-1], flush=True)
    return rows


def draw(rows: list[study.Row], facts: dict[str, str], path: Path) -> None:
    """Draw time and solid fraction over the batch size."""
    drawing = study.figure()
    time, density = drawing.subplots(1, 2)
    for (method,), group in study.grouped(rows, "method").items():
        given = [row for row in group if row["batch_size"] is not None]
        count = round(given[0]["spheres"])
        label, colour = f"{method}, {count:,} spheres", study.COLOURS[method]
        study.curve(time, given, "batch_size", "ms_a_sphere", label, colour)
        study.curve(density, given, "batch_size", "core_density", label, colour)
        own = [row for row in group if row["batch_size"] is None]
        for axes, key in ((time, "ms_a_sphere"), (density, "core_density")):
            if own:
                value = study.spread(own, key)[0]
                axes.axhline(
                    value, color=colour, linewidth=1.0, linestyle=(0, (4, 3)), label="its own choice"
                )
    for axes in (time, density):
        axes.set_xscale("log")
        output.plain_ticks(axes.xaxis)
        axes.set_xlabel("batch size")
    time.axvspan(500, 1000, color="#e5e7eb", label="the paper's optimum")
    _time_axis(time)
    density.set_ylabel("solid fraction of the core")
    time.legend(fontsize=7, frameon=False)
    study.save(drawing, path, facts)


def _time_axis(axes: Any) -> None:
    axes.set_yscale("log")
    output.plain_ticks(axes.yaxis)
    axes.set_ylabel("time a sphere [ms]")


def main() -> None:
    """Read the command line, run, write."""
    parser = study.make_parser(__doc__)
    study.seeds_option(parser, 2)
    parser.add_argument("--spheres", type=int, help="spheres of every run (default: 2,000 and 10,000)")
    parser.add_argument("--batches", type=int, nargs="+", default=list(BATCHES), help="batch sizes")
    parser.add_argument("--width", type=float, default=WIDTH, help="side of the base [m] (default: 2)")
    options = parser.parse_args()
    study.write(NAME, options, measure(options), draw)


if __name__ == "__main__":
    main()
