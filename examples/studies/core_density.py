"""Fig. 5: solid fraction of the core of a full box, 2 m wide, spheres of radius 0.1 m, for several seeds.

    python examples/studies/core_density.py [--full]

Three methods: adam as it leaves a bed (``tolerance: null``, the paper's case), adam brought to the default
tolerance, and projection. The core is the paper's: the inner box, a third smaller.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import study
from study import columns

NAME = "core_density"
WIDTH, RADIUS = 2.0, 0.1  # m, the paper's
METHODS: dict[str, study.Row] = {
    "adam, as it leaves the bed": {"optimizer": study.ADAM, "tolerance": None},
    "adam, tolerance 1e-6": {"optimizer": study.ADAM},
    "projection, tolerance 1e-6": {"optimizer": study.PROJECTION},
}
COLOURS = dict(
    zip(METHODS, (study.COLOURS["adam"], study.THIRD_COLOUR, study.COLOURS["projection"]), strict=True)
)
PAPER_LOW, PAPER_MEAN, PAPER_HIGH = 0.571, 0.597, 0.619


def measure(options: argparse.Namespace) -> list[study.Row]:
    """Return a row for each method and seed."""
    rows = []
    for seed in study.seeds_of(options):
        for method, params in METHODS.items():
            bed, _ = columns.arrange(study.box_document(options.width, RADIUS, None, seed, params))
            rows.append({"method": method, "seed": seed, "spheres": bed.count, **study.quality(bed)})
            print(rows[-1], flush=True)
    return rows


def draw(rows: list[study.Row], facts: dict[str, str], path: Path) -> None:
    """Draw the solid fractions over the seeds, in the band that the paper reports."""
    drawing = study.figure()
    axes: Any = drawing.subplots()
    axes.axhspan(PAPER_LOW, PAPER_HIGH, color="#e5e7eb", label="the paper: 0.571 to 0.619")
    axes.axhline(PAPER_MEAN, color="#6b7280", linewidth=1.0, label="the paper's mean: 0.597")
    for (method,), group in study.grouped(rows, "method").items():
        places = [row["seed"] for row in group]
        axes.plot(places, [row["core_density"] for row in group], "o-", color=COLOURS[method], label=method)
    axes.set_xlabel("seed")
    axes.set_ylabel("solid fraction of the core")
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)
    study.save(drawing, path, facts)


def main() -> None:
    """Read the command line, run, write."""
    parser = study.make_parser(__doc__)
    study.seeds_option(parser, 3)
    parser.add_argument("--width", type=float, default=WIDTH, help="side of the box [m] (default: 2)")
    options = parser.parse_args()
    study.write(NAME, options, measure(options), draw)


if __name__ == "__main__":
    main()
