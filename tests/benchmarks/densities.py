"""Solid fractions on demand under gravity: what is reached, what it costs, and what LIGGGHTS makes of it.

    python tests/benchmarks/densities.py --out DIR [--spheres 20000] [--spheres-run 3000]

Columns of equal spheres, 20 diameters wide, are asked for core fractions from 0.55 to 0.63; the plain column
without a fraction, timed beside them, is the measure of their cost. Smaller beds of 0.58 to 0.63 are run in
LIGGGHTS at the friction that goes with each, and so is the mark: the plain bed of that friction, settled by
LIGGGHTS for twice as long and trimmed to no overlap.

Writes densities.csv (every bed) and densities.txt into DIR. The runs need LIGGGHTS.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import machine
import output
from columns import arrange, column_document
from pour import liggghts_installed
from settled import judge, settle, trimmed

from packgen.bed import Bed
from packgen.measure import contacts, solid_fraction, standing
from packgen.measure.fraction import core_of
from packgen.measure.order import local_order

ACROSS, ACROSS_RUN = 20.0, 10.5  # diameters
RADIUS, RADIUS_RUN = 0.03, 0.003  # m
ASKED = (0.55, 0.56, 0.57, 0.58, 0.59, 0.60, 0.61, 0.62, 0.63)
RUNS = ((0.9, 0.58), (0.5, 0.60), (0.2, 0.62), (0.05, 0.63))  # friction, core fraction
SETTLE_TIMES = 2.0

Row = dict[str, Any]


def column(
    spheres: int, seed: int, *, across: float, radius: float, friction: float, asked: float | None
) -> tuple[Bed, float]:
    """Return a bed in a column, whose core has a fraction where one is asked, and the seconds it took."""
    width = 2.0 * across * radius
    document = column_document(spheres, seed=seed, width=width, radius=radius, friction=friction)
    if asked is not None:
        document["zones"][0]["solid_fraction"] = {"value": asked, "of": "core"}
    return arrange(document)


def reached(options: argparse.Namespace) -> list[Row]:
    """Return a row for each fraction asked for; the plain column is the first and the last."""
    rows = []
    # The loops are compiled before anything is timed.
    column(500, options.seed, across=5.0, radius=RADIUS, friction=0.5, asked=0.58)
    for asked in (None, *ASKED, None):
        bed, seconds = column(
            options.spheres, options.seed, across=ACROSS, radius=RADIUS, friction=0.5, asked=asked
        )
        rows.append(row_of("column", bed, 0.5, asked) | {"microseconds_a_sphere": 1e6 * seconds / bed.count})
        print(f"asked {asked}, core {rows[-1]['core']:.4f}, {seconds:.1f} s", flush=True)
    return rows


def row_of(name: str, bed: Bed, friction: float, asked: float | None) -> Row:
    """Return what is measured of a bed."""
    solid, stands, found = solid_fraction(bed), standing(bed), local_order(bed, core_of(bed))
    at = {each.gap: each.mean for each in contacts(bed)}
    return {
        "bed": name, "spheres": bed.count, "friction": friction, "asked": asked, "core": solid.core,
        "contacts": at[0.01], "not_carried": None if stands is None else stands.not_carried,
        "friction_least": None if stands is None else stands.friction_least,
        "crystal_wall": found.crystal_wall, "crystal_core": found.crystal_core,
    }  # fmt: skip


def run(options: argparse.Namespace) -> list[Row]:
    """Return a row for each bed that LIGGGHTS runs, and for its mark."""
    rows = []
    for friction, asked in RUNS:
        for name, fraction in (("asked", asked), ("plain", None), ("the mark", None)):
            bed, _ = column(
                options.spheres_run, options.seed, across=ACROSS_RUN, radius=RADIUS_RUN, friction=friction,
                asked=fraction,
            )  # fmt: skip
            if name == "the mark":
                bed = trimmed(settle(bed, SETTLE_TIMES * options.free_fall_times))
            found = judge(bed, options.free_fall_times).gravity_run
            rows.append(
                row_of(name, bed, friction, fraction)
                | {
                    "displacement_mean": found.displacement_mean,
                    "sinking": found.sinking,
                    "lost": len(found.lost),
                }
            )
            print(f"friction {friction}, {name}: {found.displacement_mean:.3f} r", flush=True)
    return rows


def tables(rows: Sequence[Row]) -> list[str]:
    """Return the beds, and those that LIGGGHTS ran, as tables."""
    plain = [row["microseconds_a_sphere"] for row in rows if row["bed"] == "column" and row["asked"] is None]
    columns = [
        (
            "-" if row["asked"] is None else f"{row['asked']:.2f}", f"{row['core']:.4f}",
            output.number(row["microseconds_a_sphere"]),
            output.number(row["microseconds_a_sphere"] * len(plain) / sum(plain)),
            output.number(row["contacts"]), output.number(100 * row["not_carried"]),
            output.number(row["friction_least"]),
            output.number(100 * (row["crystal_wall"] or 0.0)),
            output.number(100 * (row["crystal_core"] or 0.0)),
        )
        for row in rows
        if row["bed"] == "column"
    ]  # fmt: skip
    head = (
        "asked", "core", "us a sphere", "times plain", "contacts (1 % r)", "not carried at 0.5 [%]",
        "stands from friction", "crystal at walls [%]", "inside [%]",
    )  # fmt: skip
    ran = [
        (
            row["bed"], f"{row['friction']:g}", "-" if row["asked"] is None else f"{row['asked']:.2f}",
            f"{row['core']:.4f}", output.number(row["contacts"]), output.number(100 * row["not_carried"]),
            output.number(row["displacement_mean"]), output.number(100 * row["sinking"]), f"{row['lost']}",
        )
        for row in rows
        if row["bed"] != "column"
    ]  # fmt: skip
    head_run = (
        "bed", "friction", "asked", "core", "contacts (1 % r)", "not carried [%]", "mean displacement [r]",
        "sinks [%]", "lost",
    )  # fmt: skip
    return [output.table(head, columns), *([output.table(head_run, ran)] if ran else [])]


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the results; made when missing")
    parser.add_argument("--seed", type=int, default=0, help="of all beds (default 0)")
    parser.add_argument("--spheres", type=int, default=20_000, help="of a column (default 20,000)")
    parser.add_argument("--spheres-run", type=int, default=3_000, help="of a bed in LIGGGHTS (default 3,000)")
    parser.add_argument("--free-fall-times", type=float, default=20.0, help="length of a run (default 20)")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and write its results."""
    options = parse(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    rows = reached(options)
    if liggghts_installed():
        rows += run(options)
    stem = options.out / "densities"
    output.write_csv(stem.with_suffix(".csv"), rows, facts)
    notes = (
        f"Columns: r = {RADIUS:g} m, {ACROSS:g} diameters wide, several beds where the first is off.",
        f"Runs: r = {RADIUS_RUN:g} m, {ACROSS_RUN:g} diameters wide, E = 1e8 Pa, {options.free_fall_times:g} "
        "free-fall times.",
        "The mark: the plain bed settled by LIGGGHTS for twice as long, trimmed to no overlap, then run.",
    )
    output.write_text(stem.with_suffix(".txt"), "Solid fractions on demand", facts, tables(rows), notes)
    print("\n" + "\n\n".join(tables(rows)) + f"\n\nwritten to {options.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
