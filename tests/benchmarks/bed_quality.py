"""Is it a bed? What LIGGGHTS does to it, next to what it does to a bed of its own; and homogeneity.

    python tests/benchmarks/bed_quality.py --out DIR [--beds 3] [--columns 3] [--friction 0.5]

Displacement: a bed 35 radii deep in a box 21 radii wide runs in LIGGGHTS at E = 1e8 Pa for 20
times sqrt(2 r / g). The mark: the same bed settled by LIGGGHTS itself, each radius trimmed until
nothing overlaps, run again for as long. What moves no more than the mark cannot be told from a settled bed.
The radius matters: elastic settlement goes with E / (rho g r).

Homogeneity, in the paper's column (2 m by 2 m, radius 0.03 m): amplitude of the solid fraction along the
height at the layers' period, next to neighbouring periods (noise); and the share of crystalline spheres near
the side walls, next to a bed poured by LIGGGHTS.

Writes bed_quality.csv (every bed), bed_quality.txt and bed_quality.png into DIR. Needs LIGGGHTS, but for the
homogeneity of packgen's own columns.
"""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Sequence
from pathlib import Path
from statistics import mean
from typing import Any

import homogeneity
import machine
import numpy as np
import output
import quality_plot
from columns import FRICTION, RADIUS, WIDTH, YOUNGS_MODULUS, arrange, bed_of, column_document
from pour import liggghts_installed, pour
from settled import judge, settle, trimmed

from packgen.bed import Bed
from packgen.measure import contacts, solid_fraction

ACROSS = 21.0  # radii
SETTLE_TIMES = 2.0  # how much longer LIGGGHTS settles the mark than it runs a bed

Row = dict[str, Any]


def displacement_rows(options: argparse.Namespace) -> list[Row]:
    """Return what LIGGGHTS did to each bed and to its mark, two rows a bed."""
    rows = []
    for seed in range(options.seed, options.seed + options.beds):
        document = column_document(
            options.spheres,
            seed=seed,
            width=ACROSS * options.radius,
            radius=options.radius,
            friction=options.friction,
        )
        bed, _ = arrange(document)
        rows.append(_displacement("packgen", bed, seed, 0.0, options.free_fall_times))
        mark = trimmed(settle(bed, SETTLE_TIMES * options.free_fall_times))
        trim = float((1.0 - mark.radius / bed.radius).mean())
        rows.append(_displacement("the mark", mark, seed, trim, options.free_fall_times))
    return rows


def _displacement(name: str, bed: Bed, seed: int, trim: float, free_fall_times: float) -> Row:
    report = judge(bed, free_fall_times)
    run, fraction = report.gravity_run, solid_fraction(bed)
    row = {
        "part": "displacement",
        "bed": name,
        "seed": seed,
        "spheres": bed.count,
        "depth_radii": float((bed.position[:, 2] + bed.radius).max() / bed.radius.mean()),
        "core_density": fraction.core,
        "contacts_1_percent": next(each.mean for each in contacts(bed) if each.gap == 0.01),
        "mean_trim": trim,
        "displacement_mean": run.displacement_mean,
        "sinking": run.sinking,
        "force_max": report.step_zero.force_max,
        "lost": len(run.lost),
    }
    print(f"{name}, seed {seed}: moves by {run.displacement_mean:.3f} r, sinks by {100 * run.sinking:.2f} %")
    return row


def column_rows(options: argparse.Namespace) -> tuple[list[Row], list[homogeneity.Imprint]]:
    """Return the homogeneity of packgen's columns, a row each, and their imprints."""
    rows, imprints = [], []
    for seed in range(options.seed, options.seed + options.columns):
        document = column_document(
            options.column_spheres, seed=seed, width=options.width, friction=options.friction
        )
        bed, _ = arrange(document)
        found = homogeneity.imprint(bed, homogeneity.layer_period(bed))
        imprints += [found] if found is not None else []
        rows.append(_homogeneity("packgen", bed, seed, found))
    return rows, imprints


def poured_rows(options: argparse.Namespace, period: float) -> list[Row]:
    """Return the homogeneity of columns poured by LIGGGHTS, at packgen's layer period [m], a row each."""
    rows = []
    for seed in range(options.seed, options.seed + options.poured):
        poured = pour(
            options.poured_spheres,
            width=options.width,
            radius=RADIUS,
            youngs_modulus=YOUNGS_MODULUS,
            seed=seed,
            friction=options.friction,
        )
        bed = bed_of(poured.position, poured.radius, width=options.width, height=poured.height)
        rows.append(_homogeneity("LIGGGHTS", bed, seed, homogeneity.imprint(bed, period)))
    return rows


def _homogeneity(name: str, bed: Bed, seed: int, found: homogeneity.Imprint | None) -> Row:
    near, away = homogeneity.crystal_fractions(bed)
    print(f"{name}, seed {seed}: {100 * near:.2f} % crystalline near the walls, {100 * away:.2f} % elsewhere")
    row = {
        "part": "homogeneity",
        "bed": name,
        "seed": seed,
        "spheres": bed.count,
        "core_density": solid_fraction(bed).core,
        "crystal_walls": near,
        "crystal_inside": away,
    }
    if found is not None:
        row |= {
            "period_diameters": found.period / (2.0 * RADIUS),
            "amplitude": found.amplitude,
            "noise": found.noise,
            "noise_high": found.noise_high,
        }
    return row


def means(rows: Sequence[Row], part: str, name: str) -> dict[str, float]:
    """Return the means of all numbers over the beds of one part and name; without those that no bed has."""
    chosen = [row for row in rows if row["part"] == part and row["bed"] == name]
    result = {}
    for key in dict.fromkeys(key for row in chosen for key in row):
        values = [row[key] for row in chosen if isinstance(row.get(key), int | float)]
        numbers = [value for value in values if not np.isnan(value)]
        if numbers:
            result[key] = mean(numbers)
    return result


def displacement_table(rows: Sequence[Row]) -> str:
    """Return the beds' displacements as a table: every bed, then the means and their ratio."""
    head = (
        "bed", "seed", "depth [r]", "core density", "contacts (1 % r)", "mean trim [r]",
        "mean displacement [r]", "centre of mass sinks [%]", "step-0 force", "lost",
    )  # fmt: skip

    def cells(row: dict[str, Any], seed: str) -> tuple[str, ...]:
        figures = (row.get(key) for key in ("depth_radii", "core_density", "contacts_1_percent"))
        return (
            row.get("bed", ""),
            seed,
            *(output.number(each) for each in figures),
            output.number(row["mean_trim"], 2),
            output.number(row["displacement_mean"]),
            output.number(100 * row["sinking"]),
            output.number(row["force_max"], 2),
            output.number(row["lost"]),
        )

    chosen = [row for row in rows if row["part"] == "displacement"]
    lines = [cells(row, str(row["seed"])) for row in chosen]
    both = {name: means(rows, "displacement", name) for name in ("packgen", "the mark")}
    lines += [cells(middle | {"bed": name}, "mean") for name, middle in both.items()]
    ratios = ["" for _ in head]
    ratios[0] = "ratio"
    for column, key in ((6, "displacement_mean"), (7, "sinking")):
        ratios[column] = f"{both['packgen'][key] / both['the mark'][key]:.2f}"
    return output.table(head, [*lines, tuple(ratios)])


def homogeneity_table(rows: Sequence[Row]) -> str:
    """Return the columns' homogeneity as a table: every column, then the means."""
    head = (
        "column", "seed", "spheres", "core density", "period [diameters]", "amplitude", "noise",
        "noise, 95 %", "crystal at walls [%]", "inside [%]",
    )  # fmt: skip

    def cells(row: dict[str, Any], seed: str) -> tuple[str, ...]:
        shares = (row.get(key) for key in ("crystal_walls", "crystal_inside"))
        figures = ("core_density", "period_diameters", "amplitude", "noise", "noise_high")
        return (
            row["bed"],
            seed,
            f"{row['spheres']:,.0f}",
            *(output.number(row.get(key)) for key in figures),
            *(output.number(None if share is None else 100 * share) for share in shares),
        )

    chosen = [row for row in rows if row["part"] == "homogeneity"]
    lines = [cells(row, str(row["seed"])) for row in chosen]
    for name in dict.fromkeys(row["bed"] for row in chosen):
        middle = means(rows, "homogeneity", name) | {"bed": name}
        lines += [cells(middle, "mean")]
    return output.table(head, lines)


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the results; made when missing")
    parser.add_argument("--seed", type=int, default=0, help="first seed (default 0)")
    parser.add_argument("--beds", type=int, default=3, help="beds that LIGGGHTS runs (default 3)")
    parser.add_argument("--spheres", type=int, default=2050, help="spheres of such a bed (default 2,050)")
    parser.add_argument("--radius", type=float, default=0.003, help="radius of theirs [m] (default 0.003)")
    parser.add_argument("--friction", type=float, default=FRICTION, help="of all spheres (default 0.5)")
    parser.add_argument("--free-fall-times", type=float, default=20.0, help="length of the run (default 20)")
    parser.add_argument("--columns", type=int, default=3, help="packgen's columns (default 3)")
    parser.add_argument(
        "--column-spheres", type=int, default=100_000, help="spheres of such a column (default 100,000)"
    )
    parser.add_argument("--poured", type=int, default=2, help="columns poured by LIGGGHTS (default 2)")
    parser.add_argument(
        "--poured-spheres", type=int, default=40_000, help="spheres of such a column (default 40,000)"
    )
    parser.add_argument("--width", type=float, default=WIDTH, help="side of all columns [m] (default 2)")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and write its results."""
    options = parse(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    rows, imprints = column_rows(options)
    tables = []
    if liggghts_installed():
        rows += poured_rows(options, mean(each.period for each in imprints) if imprints else math.nan)
        moved = displacement_rows(options)
        tables.append(displacement_table(moved))
        rows = moved + rows
    else:
        print("LIGGGHTS is not installed (apt-get install liggghts): only packgen's columns are measured")
    tables.append(homogeneity_table(rows))
    stem = options.out / "bed_quality"
    output.write_csv(stem.with_suffix(".csv"), rows, facts)
    notes = (
        f"Friction {options.friction:g}. Displacement: box {ACROSS:g} r wide, r = {options.radius:g} m,",
        f"E = 1e8 Pa, 2500 kg/m3, {options.free_fall_times:g} free-fall times.",
        "The mark: the same bed settled by LIGGGHTS for twice as long, trimmed to no overlap, then run.",
        f"Columns: {options.width:g} m by {options.width:g} m, r = {RADIUS:g} m. Amplitude of the solid",
        "fraction at packgen's layer period; noise: mean and 95 % quantile at neighbouring periods.",
        "Crystalline: eight or more neighbours whose own neighbours lie alike (q6, see homogeneity.py).",
    )
    output.write_text(stem.with_suffix(".txt"), "Bed quality", facts, tables, notes)
    quality_plot.draw(rows, imprints, facts, stem.with_suffix(".png"))
    print("\n" + "\n\n".join(tables) + f"\n\nwritten to {options.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
