"""Does a bed stand? What its contacts can carry by computation, next to what LIGGGHTS does to it.

    python tests/benchmarks/standing_beds.py --out DIR [--spheres 1000] [--frictions 0.9 0.5 0.2 0.1 0.05]

Beds are packed at each friction and run in LIGGGHTS at that friction and at all lower ones. Beside them are
the same beds settled by LIGGGHTS at their own friction and trimmed to no overlap, and one with a tenth of its
spheres taken out. ``packgen.measure.standing`` says what share of a bed's weight its contacts cannot carry at
the friction of the run; LIGGGHTS says how far the spheres move and by how much the bed sinks.

Writes standing_beds.csv (every run), standing_beds.txt and standing_beds.png into DIR. Needs LIGGGHTS.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import machine
import numpy as np
import output
from columns import arrange, column_document
from pour import liggghts_installed
from settled import judge, settle, trimmed

from packgen.bed import Bed
from packgen.measure import standing

ACROSS = 15.0  # radii
TRIMMED_GAP = 5.0e-3  # radii: trimming opens the contacts of soft spheres by as much
SETTLE_TIMES = 2.0  # how much longer LIGGGHTS settles a bed than it runs one
TAKEN = 10  # every so many spheres one is taken out

Row = dict[str, Any]


def with_friction(bed: Bed, friction: float) -> Bed:
    """Return a bed whose materials all have one friction."""
    return replace(bed, materials=tuple(replace(each, friction=friction) for each in bed.materials))


def thinned(bed: Bed) -> Bed:
    """Return a bed without every tenth of its spheres."""
    kept = np.arange(bed.count) % TAKEN != 0
    arrays = {each.name: getattr(bed, each.name) for each in fields(bed)}
    names = ("position", "radius", "set_index", "zone_index", "batch_index")
    return replace(bed, **{name: arrays[name][kept] for name in names})


def row_of(name: str, bed: Bed, packed_at: float, friction: float, options: argparse.Namespace) -> Row:
    """Return what is computed of a bed at a friction, and what LIGGGHTS measures."""
    bed = with_friction(bed, friction)
    found = standing(bed, **({"gap": TRIMMED_GAP} if name == "LIGGGHTS" else {}))
    if found is None:
        raise RuntimeError("a bed under gravity was expected")
    run = judge(bed, options.free_fall_times).gravity_run
    row = {
        "bed": name,
        "packed_at": packed_at,
        "run_at": friction,
        "spheres": bed.count,
        "gap": found.gap,
        "stands": found.stands,
        "not_carried": found.not_carried,
        "falling": found.falling,
        "friction_least": found.friction_least,
        "displacement_mean": run.displacement_mean,
        "sinking": run.sinking,
        "lost": len(run.lost),
    }
    print(
        f"{name} {packed_at:g} at {friction:g}: {100 * found.not_carried:.2f} % not carried, "
        f"moves by {run.displacement_mean:.3f} r",
        flush=True,
    )
    return row


def rows_of(options: argparse.Namespace) -> list[Row]:
    """Return a row for each bed at each friction."""
    rows = []
    for packed_at in sorted(options.frictions, reverse=True):
        document = column_document(
            options.spheres,
            seed=options.seed,
            width=ACROSS * options.radius,
            radius=options.radius,
            friction=packed_at,
        )
        bed, _ = arrange(document)
        lower = [each for each in sorted(options.frictions, reverse=True) if each <= packed_at]
        rows += [row_of("packgen", bed, packed_at, friction, options) for friction in lower]
        if packed_at == max(options.frictions):
            rows.append(row_of("a tenth taken out", thinned(bed), packed_at, packed_at, options))
        mark = trimmed(settle(bed, SETTLE_TIMES * options.free_fall_times))
        rows += [row_of("LIGGGHTS", mark, packed_at, friction, options) for friction in lower[:2]]
    return rows


def table(rows: Sequence[Row]) -> str:
    """Return all runs as a table."""
    head = (
        "bed", "packed at", "run at", "not carried [%]", "falling", "stands", "least friction",
        "mean displacement [r]", "sinks [%]", "lost",
    )  # fmt: skip
    lines = [
        (
            row["bed"],
            f"{row['packed_at']:g}",
            f"{row['run_at']:g}",
            output.number(100 * row["not_carried"]),
            f"{row['falling']}",
            "yes" if row["stands"] else "no",
            output.number(row["friction_least"]),
            output.number(row["displacement_mean"]),
            output.number(100 * row["sinking"]),
            f"{row['lost']}",
        )
        for row in rows
    ]
    return output.table(head, lines)


def draw(rows: Sequence[Row], facts: dict[str, str], path: Path) -> None:
    """Draw LIGGGHTS' mean displacement over the share of the weight that is not carried."""
    figure = output.start_figure(6.5, 4.5)
    axes = figure.add_subplot()
    for name, marker in (("packgen", "o"), ("LIGGGHTS", "s"), ("a tenth taken out", "^")):
        chosen = [row for row in rows if row["bed"] == name]
        share = [max(100 * row["not_carried"], 1e-2) for row in chosen]
        axes.plot(share, [row["displacement_mean"] for row in chosen], marker, label=name, alpha=0.8)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("weight that the contacts cannot carry [%]")
    axes.set_ylabel("mean displacement in LIGGGHTS [radii]")
    axes.legend(frameon=False)
    output.save_figure(figure, path, facts)


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the results; made when missing")
    parser.add_argument("--seed", type=int, default=0, help="of all beds (default 0)")
    parser.add_argument("--spheres", type=int, default=1000, help="spheres of a bed (default 1,000)")
    parser.add_argument("--radius", type=float, default=0.003, help="radius of theirs [m] (default 0.003)")
    parser.add_argument(
        "--frictions", type=float, nargs="+", default=[0.9, 0.5, 0.2, 0.1, 0.05], help="of beds and runs"
    )
    parser.add_argument("--free-fall-times", type=float, default=10.0, help="length of a run (default 10)")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and write its results."""
    options = parse(arguments)
    if not liggghts_installed():
        print("LIGGGHTS is not installed (apt-get install liggghts)")
        return 1
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    rows = rows_of(options)
    stem = options.out / "standing_beds"
    output.write_csv(stem.with_suffix(".csv"), rows, facts)
    notes = (
        f"{options.spheres} spheres, r = {options.radius:g} m, in a box {ACROSS:g} r wide, E = 1e8 Pa,",
        f"{options.free_fall_times:g} free-fall times. LIGGGHTS: settled by it for twice as long,",
        f"trimmed; its contacts are those with gaps up to {TRIMMED_GAP:g} r.",
    )
    output.write_text(stem.with_suffix(".txt"), "Standing beds", facts, [table(rows)], notes)
    draw(rows, facts, stem.with_suffix(".png"))
    print(f"\n{table(rows)}\n\nwritten to {options.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
