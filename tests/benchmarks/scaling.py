"""How the cost of a sphere depends on their number, the layers, the threads, the sizes and a busy machine.

    python tests/benchmarks/scaling.py --out DIR [--large] [--repeats 3]

Every point is a fresh process that compiles nothing while it is timed, and the points take turns, so that a
noisy machine slows all of them; medians over the rounds make table and plot.

- spheres: the paper's column, 2 m by 2 m, equal spheres of radius 0.03 m; 10,000,000 of them with --large
- layer: thickness of the layers, by ``params.batch_size``
- threads: one thread to all cores; the bed has to be the same one
- sizes: a broad law and two sizes 1:20, against equal spheres
- busy: one core kept busy by another process
- first run: with nothing compiled (an empty folder as NUMBA_CACHE_DIR), against the second

Writes scaling.csv (every run), scaling.txt (medians) and scaling.png into DIR.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import Any

import machine
import output
import scaling_plot
from columns import RADIUS, WIDTH, column_document, sphere_volume

SPHERES = (10_000, 20_000, 50_000, 100_000, 200_000, 500_000, 1_000_000)
LARGE = 10_000_000
LAYERS = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0)  # diameters
LAYER_FRACTION = 0.6  # solid fraction by which packgen turns a batch size into a thickness
SIGMA = 0.5
SIZE_RATIO = 20.0
SMALL_SHARE = 0.3  # of the mass
LARGE_ACROSS = 8.0  # large radii across the column of two sizes
SERIES = ("spheres", "layer", "threads", "sizes", "busy", "first run")


SAME = ("series", "label", "value", "core_density", "overlap_max")  # in every round
MEASURED = (
    "spheres", "seconds", "seconds_in_all", "microseconds_a_sphere", "peak_memory_MB", "memory_before_MB",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Point:
    """A point of a curve.

    Attributes:
        series: The curve.
        label: What is said of the point.
        value: Where it stands on the curve's axis.
        scene: The scene.
        threads: As ``packgen --threads``; None: packgen's choice.
        busy: Whether another process keeps a core busy.
        compiled: Whether the loops are there, compiled; else the run begins with an empty cache.
        rounds: In how many rounds it runs at most.
    """

    series: str
    label: str
    value: float
    scene: dict[str, Any]
    threads: int | None = None
    busy: bool = False
    compiled: bool = True
    rounds: int = 1_000_000


@dataclass(frozen=True, slots=True)
class Plan:
    """What to measure: base scene size, column, and the numbers of spheres of the first curve."""

    spheres: int
    width: float
    counts: tuple[int, ...]
    seed: int
    sizes: tuple[str, ...] = field(default=("lognormal", "two sizes"))


def make_points(plan: Plan, series: Sequence[str]) -> list[Point]:
    """Return the points of some curves."""
    curves = {
        "spheres": _spheres,
        "layer": _layers,
        "threads": _threads,
        "sizes": _sizes,
        "busy": _busy,
        "first run": _first_run,
    }
    return [point for name in series for point in curves[name](plan)]


def _spheres(plan: Plan) -> Iterator[Point]:
    for count in plan.counts:
        scene = column_document(count, seed=plan.seed, width=plan.width)
        yield Point("spheres", f"{count:,}", count, scene, rounds=1 if count >= LARGE else 1_000_000)


def _layers(plan: Plan) -> Iterator[Point]:
    for thickness in LAYERS:
        volume = LAYER_FRACTION * plan.width**2 * thickness * 2.0 * RADIUS
        params = {"batch_size": max(1, round(volume / sphere_volume(RADIUS)))}
        scene = column_document(plan.spheres, seed=plan.seed, width=plan.width, params=params)
        yield Point("layer", f"{thickness:g} diameters", thickness, scene)
    yield Point("layer", "packgen's choice", math.nan, _narrow(plan))


def _threads(plan: Plan) -> Iterator[Point]:
    for threads in range(1, machine.usable_cores() + 1):
        yield Point("threads", str(threads), threads, _narrow(plan), threads)
    yield Point("threads", "packgen's choice", math.nan, _narrow(plan))


def _sizes(plan: Plan) -> Iterator[Point]:
    yield Point("sizes", "equal", 0, _narrow(plan))
    if "lognormal" in plan.sizes:
        middle = RADIUS * math.exp(-1.5 * SIGMA**2)  # the mean volume is that of the equal spheres
        law = {"radius_distribution": "lognormal", "radius_median": middle, "sigma": SIGMA}
        scene = column_document(plan.spheres, seed=plan.seed, width=plan.width, sizes=law)
        yield Point("sizes", f"lognormal, sigma {SIGMA:g}", 1, scene)
    if "two sizes" in plan.sizes:
        yield Point("sizes", f"two sizes 1:{SIZE_RATIO:g}", 2, two_sizes(3 * plan.spheres, plan.seed))


def two_sizes(spheres: int, seed: int) -> dict[str, Any]:
    """Return a scene of two sizes in a column as wide as some of the large ones."""
    law = {
        "radius_distribution": "discrete",
        "radii": [RADIUS / SIZE_RATIO, RADIUS],
        "fractions": [SMALL_SHARE, 1.0 - SMALL_SHARE],
        "by": "mass",
    }
    # Mean volume: mass over number, with the shares of the mass turned into shares of the number.
    number = [SMALL_SHARE * SIZE_RATIO**3, 1.0 - SMALL_SHARE]
    mean = RADIUS * ((number[0] / SIZE_RATIO**3 + number[1]) / sum(number)) ** (1.0 / 3.0)
    document = column_document(spheres, seed=seed, width=LARGE_ACROSS * RADIUS, radius=mean, sizes=law)
    document["container"]["box"]["max"][2] += 12.0 * RADIUS  # head room for the large ones
    return document


def _busy(plan: Plan) -> Iterator[Point]:
    yield Point("busy", "idle machine", 0, _narrow(plan))
    yield Point("busy", "one core busy", 1, _narrow(plan), busy=True)


def _first_run(plan: Plan) -> Iterator[Point]:
    scene = column_document(min(plan.spheres, 1000), seed=plan.seed, width=min(plan.width, 0.6))
    yield Point("first run", "first", 0, scene, compiled=False, rounds=1)


def _narrow(plan: Plan) -> dict[str, Any]:
    return column_document(plan.spheres, seed=plan.seed, width=plan.width)


def run_rounds(points: Sequence[Point], repeats: int, check_max: int) -> list[dict[str, Any]]:
    """Measure every point once a round; return a row a run."""
    rows = []
    for number in range(repeats):
        for point in points:
            if number >= point.rounds:
                continue
            for row in measured(point, check_max):
                rows.append({"round": number, **row})
                cost = f"{row['microseconds_a_sphere']:.1f} us a sphere"
                print(f"round {number + 1}/{repeats}  {row['series']}, {row['label']}: {cost}", flush=True)
    return rows


def measured(point: Point, check_max: int) -> Iterator[dict[str, Any]]:
    """Measure a point in a fresh process; a first run is followed by the second."""
    wanted = point.scene["zones"][0]["n_particles"]
    task = {
        "scene": point.scene, "threads": point.threads, "warm": point.compiled, "check": wanted <= check_max,
    }  # fmt: skip
    about = {"series": point.series, "label": point.label, "value": point.value, "asked": wanted}
    if point.compiled:
        with busy_core() if point.busy else _idle():
            yield about | run_point(task, {})
        return
    with tempfile.TemporaryDirectory(prefix="packgen_") as empty:
        yield about | run_point(task, {"NUMBA_CACHE_DIR": empty})
        yield about | {"label": "second", "value": 1} | run_point(task, {"NUMBA_CACHE_DIR": empty})


def run_point(task: dict[str, Any], environment: dict[str, str]) -> dict[str, Any]:
    """Return what ``point.py`` measures of a task in a fresh process."""
    script = Path(__file__).with_name("point.py")
    run = subprocess.run(
        [sys.executable, str(script), json.dumps(task)],
        env={**os.environ, **environment}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    if run.returncode != 0:
        raise RuntimeError(f"{script.name} failed:\n{run.stderr}")
    return dict(json.loads(run.stdout.splitlines()[-1]))


@contextmanager
def busy_core() -> Iterator[None]:
    """Keep a core busy with another process."""
    process = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        yield
    finally:
        process.kill()
        process.wait()


@contextmanager
def _idle() -> Iterator[None]:
    yield


def medians(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a row a point: medians over the rounds, and the range of the times."""
    grouped: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        grouped.setdefault((row["series"], row["label"]), []).append(row)
    result = []
    for runs in grouped.values():
        first = runs[0]
        middle = {name: first.get(name) for name in SAME}
        for name in MEASURED:
            middle[name] = median(run[name] for run in runs)
        times = [run["microseconds_a_sphere"] for run in runs]
        beds = {run["bed"] for run in runs}
        middle |= {"fastest": min(times), "slowest": max(times), "bed": " ".join(sorted(beds))}
        result.append(middle)
    return result


def as_table(summary: Sequence[dict[str, Any]]) -> str:
    """Return the medians as a table."""
    head = (
        "curve", "point", "spheres", "us a sphere", "(range)", "seconds", "peak MB", "core density",
        "largest overlap", "bed",
    )  # fmt: skip
    rows = [
        (
            row["series"],
            row["label"],
            f"{row['spheres']:,.0f}",
            output.number(row["microseconds_a_sphere"]),
            f"{output.number(row['fastest'])} to {output.number(row['slowest'])}",
            output.number(row["seconds"]),
            f"{row['peak_memory_MB']:.0f}",
            "-" if row["core_density"] is None else f"{row['core_density']:.3f}",
            output.number(row["overlap_max"], 2),
            row["bed"],
        )
        for row in summary
    ]
    return output.table(head, rows)


def verdicts(summary: Sequence[dict[str, Any]]) -> list[str]:
    """Return what the curves come to: the ratios, in words."""
    by = {(row["series"], row["label"]): row for row in summary}
    found = []

    def ratio(text: str, top: tuple[str, str], bottom: tuple[str, str]) -> None:
        if top in by and bottom in by:
            cost = [by[each]["microseconds_a_sphere"] for each in (top, bottom)]
            found.append(f"{text}: {cost[0] / cost[1]:.2f}")

    ratio("cost a sphere, 1,000,000 to 50,000 spheres", ("spheres", "1,000,000"), ("spheres", "50,000"))
    ratio("cost a sphere, lognormal to equal", ("sizes", f"lognormal, sigma {SIGMA:g}"), ("sizes", "equal"))
    ratio("cost a sphere, two sizes to equal", ("sizes", f"two sizes 1:{SIZE_RATIO:g}"), ("sizes", "equal"))
    ratio("time with one core busy to idle", ("busy", "one core busy"), ("busy", "idle machine"))
    if ("first run", "first") in by and ("first run", "second") in by:
        first, second = (by["first run", each]["seconds_in_all"] for each in ("first", "second"))
        found.append(f"first run takes longer than the second by: {first - second:.1f} s")
    beds = {each for row in summary if row["series"] == "threads" for each in row["bed"].split()}
    if beds:
        found.append(
            f"beds for different numbers of threads: {'the same' if len(beds) == 1 else 'DIFFERENT'}"
        )
    return found


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the results; made when missing")
    parser.add_argument("--series", nargs="+", choices=SERIES, default=SERIES, help="default: all")
    parser.add_argument(
        "--spheres", type=int, default=100_000, help="of all curves but the first (default 100,000)"
    )
    parser.add_argument(
        "--counts",
        type=int,
        nargs="+",
        default=SPHERES,
        help="of the first curve (default 10,000 to 1,000,000)",
    )
    parser.add_argument("--large", action="store_true", help=f"add {LARGE:,} spheres, once")
    parser.add_argument("--width", type=float, default=WIDTH, help="side of the column [m] (default 2)")
    parser.add_argument("--repeats", type=int, default=3, help="rounds (default 3)")
    parser.add_argument("--seed", type=int, default=0, help="default 0")
    parser.add_argument(
        "--check-max", type=int, default=1_000_000, help="largest bed whose density and overlap are measured"
    )
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and write its results."""
    options = parse(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed) | {"rounds": str(options.repeats)}
    counts = (*options.counts, *([LARGE] if options.large else []))
    plan = Plan(options.spheres, options.width, counts, options.seed)
    rows = run_rounds(make_points(plan, options.series), options.repeats, options.check_max)
    summary = medians(rows)
    stem = options.out / "scaling"
    output.write_csv(stem.with_suffix(".csv"), rows, facts)
    table, lines = as_table(summary), verdicts(summary)
    notes = (
        *lines,
        "",
        "Medians over the rounds; every point a process of its own. Time: the arrangement alone. First and",
        "second run are counted from the start of the program, the loading of libraries included.",
        "Peak memory of the whole process, libraries included.",
        "Bed: digest of the positions.",
    )
    column = f"column {options.width:g} m by {options.width:g} m, radius {RADIUS:g} m"
    title = f"Scaling of the arrangement: {column}"
    output.write_text(stem.with_suffix(".txt"), title, facts, [table], notes)
    scaling_plot.draw(summary, facts, stem.with_suffix(".png"))
    print("\n".join(["", table, "", *lines, "", f"written to {options.out}"]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
