"""Rigid clumps: time a sphere, core fractions of known shapes, and what LAMMPS does to the beds.

    python tests/benchmarks/clumps.py --out DIR [--parts speed curve gravity] [--clumps 20000] [--judged 2000]

- speed: clumps of 3, 8 and 20 spheres in a cylinder: processor time of one thread, and the largest overlap of
  two of them. Beside them the column of 2 m by 2 m that the figures of speed refer to, by the same clock.
- curve: rods with round ends and pairs of spheres, of aspect 1 to 5, in a box that wraps around sideways,
  poured without friction as in the literature, and with that of stones.
- gravity: the bed in LAMMPS: step-0 force, displacement, sinking, clumps lost. The mark is the same clumps
  poured by LAMMPS from apart, each then made thinner until none overlaps, and run again alike.

Writes clumps_<part>.csv for each part, clumps.txt, and clumps.png of the curve into DIR. A part that is not
run keeps the rows that its CSV in DIR has; ``--parts`` without any makes table and plot of them again.
``gravity`` needs LAMMPS.
"""

from __future__ import annotations

import argparse
import csv
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import clumps_beds as beds
import machine
import output
from clumps_plot import draw
from clumps_poured import mark_of
from columns import column_document, read_scene

from packgen.bed import Bed
from packgen.check import check_bed
from packgen.filling.pack import pack
from packgen.measure import solid_fraction

COLUMN = 5_000  # spheres of the column that tells how fast the machine is
LENGTHS = {"rod": (1.0, 1.1, 1.2, 1.4, 1.6, 2.0, 3.0, 4.0, 5.0), "pair": (1.2, 1.4, 1.6, 1.8, 2.0)}
FRICTIONS = (0.0, 0.5)
MARKED = ("dimer",)  # shapes that LAMMPS pours: it takes long

Row = dict[str, Any]
HEADS: dict[str, tuple[str, ...]] = {
    "speed": (
        "clump", "spheres each", "clumps", "us a sphere", "column [us]", "the same, column = 17 us", "core",
        "overlap / r",
    ),
    "curve": ("shape", "aspect", "friction", "clumps", "core"),
    "gravity": (
        "clump", "bed", "clumps", "core", "step-0 force [weights]", "displacement [equivalent r]",
        "sinking [%]", "elastic part [%]", "lost",
    ),
}  # fmt: skip


def timed(document: Row) -> tuple[Bed, float]:
    """Return the bed of a scene, and the processor time of its arrangement by one thread [s]."""
    scene, container = read_scene(document)
    start = time.process_time()
    bed = pack(scene, container, threads=1).bed
    return bed, time.process_time() - start


def largest_overlap(bed: Bed) -> float:
    """Return the largest overlap of two clumps or with a wall, as a share of the smaller radius."""
    check = check_bed(bed)
    return max(check.overlap_max, check.wall_overlap_max)


def core(bed: Bed) -> float:
    """Return the solid fraction away from walls, floor and surface; nan: there is no such place."""
    found = solid_fraction(bed).core
    return float("nan") if found is None else found


def speed_rows(options: argparse.Namespace) -> list[Row]:
    """Return a row a shape."""
    for shape in beds.TIMED.values():
        timed(beds.in_cylinder(shape, 50, options.seed))  # compiles
    timed(column_document(100, seed=0))
    rows = []
    for name, shape in beds.TIMED.items():
        column = 1e6 * timed(column_document(COLUMN, seed=options.seed))[1] / COLUMN
        bed, seconds = timed(beds.in_cylinder(shape, options.clumps, options.seed))
        each = 1e6 * seconds / bed.count
        rows.append(
            dict(
                zip(
                    HEADS["speed"],
                    (
                        name, beds.sphere_count(bed), beds.body_count(bed), each, column,
                        each * 17.0 / column, core(bed), largest_overlap(bed),
                    ),
                    strict=True,
                )
            )
        )  # fmt: skip
        print(rows[-1], flush=True)
    return rows


def curve_rows(options: argparse.Namespace) -> list[Row]:
    """Return a row a shape, aspect and friction."""
    rows = []
    for shape, aspects in LENGTHS.items():
        for aspect in aspects:
            for friction in FRICTIONS:
                document = beds.in_periodic_box(shape, aspect, friction, options.judged, options.seed)
                bed, _ = timed(document)
                found = (shape, aspect, friction, beds.body_count(bed), core(bed))
                rows.append(dict(zip(HEADS["curve"], found, strict=True)))
                print(rows[-1], flush=True)
    return rows


def gravity_rows(options: argparse.Namespace) -> list[Row]:
    """Return a row a bed that LAMMPS judges."""
    rows: list[Row] = []
    for name, shape in beds.JUDGED.items():
        bed, _ = timed(beds.in_cylinder(shape, options.judged, options.seed, beds.NARROW))
        rows.append(judged_row(name, "packgen", bed))
        if name in MARKED:
            rows.append(judged_row(name, "LAMMPS, trimmed", mark_of(bed, options.seed)))
    return rows


def judged_row(name: str, kind: str, bed: Bed) -> Row:
    """Return what LAMMPS makes of a bed."""
    report = beds.judge(bed)
    run, zero = report.gravity_run, report.step_zero
    force = max(zero.pair_force_max, zero.wall_force_max)
    found = (
        name, kind, beds.body_count(bed), core(bed), force, run.displacement_mean, 100.0 * run.sinking,
        100.0 * run.sinking_elastic, len(run.lost),
    )  # fmt: skip
    row: Row = dict(zip(HEADS["gravity"], found, strict=True))
    print(row, flush=True)
    return row


PARTS: dict[str, Callable[[argparse.Namespace], list[Row]]] = {
    "speed": speed_rows,
    "curve": curve_rows,
    "gravity": gravity_rows,
}


def rows_of(part: str, options: argparse.Namespace, facts: dict[str, str]) -> list[Row]:
    """Return the rows of a part: run now, or those that an earlier run has left."""
    path = options.out / f"clumps_{part}.csv"
    if part in options.parts:
        rows = PARTS[part](options)
        output.write_csv(path, rows, facts)
        return rows
    if not path.exists():
        return []
    with path.open(encoding="utf-8", newline="") as file:
        lines = [line for line in file if not line.startswith("#")]
    return [{key: value_of(text) for key, text in row.items()} for row in csv.DictReader(lines)]


def value_of(text: str) -> float | str:
    """Return a cell as a number, where it is one."""
    try:
        return float(text)
    except ValueError:
        return text


def cell(value: float | str) -> str:
    """Return a value as tables show it."""
    if isinstance(value, str):
        return value
    return f"{value:,.0f}" if value >= 1000 and value == round(value) else output.number(value, 4)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--parts", nargs="*", choices=list(PARTS), default=list(PARTS))
    parser.add_argument("--clumps", type=int, default=20_000, help="of the beds that are timed")
    parser.add_argument("--judged", type=int, default=2_000, help="clumps of all other beds")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    found = {part: rows_of(part, options, facts) for part in PARTS}
    tables = [
        f"{part}\n\n" + output.table(HEADS[part], [[cell(each) for each in row.values()] for row in rows])
        for part, rows in found.items()
        if rows
    ]
    if found["curve"]:
        draw(found["curve"], facts, options.out / "clumps.png")
    output.write_text(options.out / "clumps.txt", "Rigid clumps", facts, tables, beds.NOTES)
    print((options.out / "clumps.txt").read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
