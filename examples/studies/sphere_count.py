"""Fig. 8: time over the number of spheres, in a tall box 2 m by 2 m, radius 0.03 m, adam in batches of 500.

    python examples/studies/sphere_count.py [--full]

The paper goes to 200,000 spheres, ten times each; so does ``--full``, which takes adam hours.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import study
from study import columns, output

NAME = "sphere_count"
COUNTS = {study.ADAM: (1000, 2000, 4000, 8000), study.PROJECTION: (1000, 10_000, 50_000, 100_000, 200_000)}
COUNTS_FULL = (1000, 10_000, 50_000, 100_000, 200_000)
PAPER_SPHERES, PAPER_SECONDS = 200_000, 77 * 60  # 1 hour and 17 minutes


def measure(options: argparse.Namespace) -> list[study.Row]:
    """Return a row for each method, number of spheres and seed."""
    rows = []
    for method, usual in COUNTS.items():
        study.warm_up(method)
        params = {"optimizer": method} | ({"batch_size": study.BATCH} if method == study.ADAM else {})
        for seed in study.seeds_of(options):
            for spheres in options.counts or (COUNTS_FULL if options.full else usual):
                document = columns.column_document(spheres, seed=seed, params=params)
                bed, seconds = columns.arrange(document)
                rows.append(
                    {
                        "method": method, "spheres": bed.count, "seed": seed, "seconds": round(seconds, 4),
                        **study.quality(bed),
                    }
                )  # fmt: skip
                print(rows[-1], flush=True)
    return rows


def draw(rows: list[study.Row], facts: dict[str, str], path: Path) -> None:
    """Draw time over the number of spheres, beside the one time that the paper's text states."""
    drawing = study.figure()
    axes: Any = drawing.subplots()
    for (method,), group in study.grouped(rows, "method").items():
        study.curve(axes, group, "spheres", "seconds", method, study.COLOURS[method])
    axes.plot([PAPER_SPHERES], [PAPER_SECONDS], "*", color="#111827", markersize=10, label="the paper")
    for axis in (axes.xaxis, axes.yaxis):
        output.plain_ticks(axis)
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        output.plain_ticks(axis)
    axes.set_xlabel("spheres")
    axes.set_ylabel("time [s]")
    axes.legend(fontsize=8, frameon=False)
    study.save(drawing, path, facts)


def main() -> None:
    """Read the command line, run, write."""
    parser = study.make_parser(__doc__)
    study.seeds_option(parser, 2)
    parser.add_argument("--counts", type=int, nargs="+", help="numbers of spheres of both methods")
    options = parser.parse_args()
    study.write(NAME, options, measure(options), draw)


if __name__ == "__main__":
    main()
