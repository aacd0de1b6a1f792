"""Does a bed that ``--settle`` has settled stay where it is? Beside it the bed as packed, and the mark.

    python tests/benchmarks/settling.py --out DIR [--spheres 5000] [--beds 1]

Beds are those of the furnace scene with fewer spheres. Each is settled by LIGGGHTS until it is still, and
runs again for 20 times sqrt(2 r / g): as LIGGGHTS left it, and trimmed, each radius as little smaller as
makes all overlaps vanish. The mark, as in ``bed_quality.py``, is the packed bed settled for twice as long as
it is run, trimmed, and run again.

Writes settling.csv (every run) and settling.txt into DIR. Needs LIGGGHTS.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import machine
import output
from settled import judge, settled, trimmed

from packgen.bed import Bed
from packgen.check import check_bed
from packgen.container import load_container
from packgen.filling.pack import pack
from packgen.measure import contacts, solid_fraction
from packgen.scene import load_scene

SCENE = Path(__file__).resolve().parents[2] / "examples" / "furnace.yaml"
SETTLE_TIMES = 2.0  # how much longer the mark is settled than a bed is run

Row = dict[str, Any]


def rows_of(seed: int, options: argparse.Namespace) -> list[Row]:
    """Return what becomes of a bed: as packed, settled, settled and trimmed, and the mark; a row each."""
    scene = load_scene(SCENE)
    zones = tuple(each.model_copy(update={"n_particles": options.spheres}) for each in scene.zones)
    scene = replace(scene, seed=seed, zones=zones)
    container = load_container(scene)
    start = time.perf_counter()
    packed = pack(scene, container).bed
    middle = time.perf_counter()
    still = settled(packed)
    end = time.perf_counter()
    print(f"seed {seed}: still after {still.free_fall_times:.3g} free-fall times", flush=True)
    marked = settled(packed, SETTLE_TIMES * options.free_fall_times)
    times = {"seconds": middle - start, "settled_times": 0.0}
    after = {"seconds": end - middle, "settled_times": still.free_fall_times}
    mark = {"seconds": time.perf_counter() - end, "settled_times": marked.free_fall_times}
    return [
        _row("packed", seed, packed, packed, options, times),
        _row("settled", seed, still.bed, packed, options, after),
        _row("settled, trimmed", seed, trimmed(still.bed), packed, options, after),
        _row("the mark", seed, trimmed(marked.bed), packed, options, mark),
    ]


def _row(
    name: str, seed: int, bed: Bed, packed: Bed, options: argparse.Namespace, known: dict[str, float]
) -> Row:
    run = judge(bed, options.free_fall_times).gravity_run
    check, fraction = check_bed(bed), solid_fraction(bed)
    print(f"{name}, seed {seed}: moves by {run.displacement_mean:.4f} r", flush=True)
    return {
        "bed": name,
        "seed": seed,
        "spheres": bed.count,
        **known,
        "fraction": fraction.filled,
        "core": fraction.core,
        "contacts_1_percent": next(each.mean for each in contacts(bed) if each.gap == 0.01),
        "overlap_max": max(check.overlap_max, check.wall_overlap_max),
        "mean_trim": float((1.0 - bed.radius / packed.radius).mean()),
        "displacement_mean": run.displacement_mean,
        "sinking": run.sinking,
        "lost": len(run.lost),
    }


def table(rows: Sequence[Row]) -> str:
    """Return all rows, and below them how the settled beds compare with the mark."""
    head = (
        "bed", "seed", "time [s]", "settled for [free-fall times]", "solid fraction", "core",
        "contacts (1 % r)", "largest overlap [r]", "mean trim [r]", "moves by [r]", "sinks by [%]", "lost",
    )  # fmt: skip
    keys = (
        "seconds", "settled_times", "fraction", "core", "contacts_1_percent", "overlap_max", "mean_trim",
        "displacement_mean",
    )  # fmt: skip
    lines = [
        (
            row["bed"], str(row["seed"]), *(output.number(row[key], 4) for key in keys),
            output.number(100.0 * row["sinking"]), output.number(row["lost"]),
        )
        for row in rows
    ]  # fmt: skip
    moved = {
        name: sum(row["displacement_mean"] for row in rows if row["bed"] == name)
        for name in ("settled, trimmed", "the mark")
    }
    ratio = ["" for _ in head]
    ratio[0], ratio[9] = "ratio to the mark", f"{moved['settled, trimmed'] / moved['the mark']:.2f}"
    return output.table(head, [*lines, tuple(ratio)])


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the results; made when missing")
    parser.add_argument("--seed", type=int, default=0, help="first seed (default 0)")
    parser.add_argument("--beds", type=int, default=1, help="beds (default 1)")
    parser.add_argument("--spheres", type=int, default=5000, help="spheres of a bed (default 5,000)")
    parser.add_argument("--free-fall-times", type=float, default=20.0, help="length of the run (default 20)")
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and write its results."""
    options = parse(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    rows = [
        row for seed in range(options.seed, options.seed + options.beds) for row in rows_of(seed, options)
    ]
    text = table(rows)
    output.write_csv(options.out / "settling.csv", rows, facts)
    notes = (
        f"The furnace of examples/furnace.yaml with {options.spheres:,} spheres; runs of "
        f"{options.free_fall_times:g} free-fall times.",
        "Settled: by LIGGGHTS until still. Trimmed: each radius smaller until nothing overlaps.",
        "The mark: the packed bed settled for twice as long as it is run, trimmed, run again.",
    )
    output.write_text(options.out / "settling.txt", "Settled beds", facts, [text], notes)
    print(f"\n{text}\n\nwritten to {options.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
