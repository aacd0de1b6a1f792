"""How much time buys how little error: time a sphere against overlap, density and force, for several methods.

    python tests/benchmarks/speed_against_error.py --out DIR [--spheres 20000] [--repeats 3]

All methods fill the paper's column, 2 m by 2 m unless told, with equal spheres of radius 0.03 m, and all beds
are judged by the same code. The methods take turns, so that a noisy machine slows all of them: one round runs
every case once, with another seed each round, and medians over the rounds make the table and the plot.

- projection, adam: packgen, at each tolerance; the arrangement alone, compilation not included
- the paper's: its Algorithm 1 as printed, all pairs, whatever overlap Adam leaves
- spheropack: a box with walls at one solid fraction, growth rate 0.1 (skipped where it is not installed)
- LIGGGHTS: random insertion, then gravity until at rest (skipped where it is not installed)

Writes speed_against_error.csv (every run), .txt (medians) and .png into DIR.
"""

from __future__ import annotations

import argparse
import importlib.util
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import machine
import numpy as np
import output
import torch
import tradeoff_plot
from columns import RADIUS, WIDTH, arrange, bed_of, column_document, column_height, read_scene
from pour import liggghts_installed, pour
from quality import quality

from packgen.arrange.adam.batch import AdamSettings
from packgen.arrange.adam.objective import PlaneWalls
from packgen.arrange.adam.zone import Surroundings, ZoneSpace, pack_zone_adam
from packgen.arrays import Float64Array
from packgen.bed import Bed
from packgen.supply.supply import Supply

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)
SPHEROPACK_FRACTIONS = (0.58, 0.60)
SPHEROPACK_GROWTH = 0.1
LIGGGHTS_MODULI = (5.0e6, 1.0e8)
MEASURED = (
    "spheres", "depth", "microseconds_a_sphere", "overlap_max", "overlap_mean", "core_density", "force_max",
    "outside",
)  # fmt: skip
METHODS = ("projection", "adam", "the paper's", "spheropack", "LIGGGHTS")


@dataclass(frozen=True, eq=False, slots=True)
class Outcome:
    """A bed, the seconds it took, and what has to be said of it."""

    bed: Bed
    seconds: float
    remark: str = ""


@dataclass(frozen=True, slots=True)
class Case:
    """A method with one setting.

    Attributes:
        method: Name of the method.
        setting: What makes this case differ from the method's others.
        spheres: Number of spheres.
        run: Takes a seed.
    """

    method: str
    setting: str
    spheres: int
    run: Callable[[int], Outcome]


def packgen_case(optimizer: str, tolerance: float, spheres: int, width: float) -> Case:
    """Return packgen with one of its optimisers at a tolerance."""
    params = {"optimizer": optimizer, "tolerance": tolerance}

    def run(seed: int) -> Outcome:
        return Outcome(*arrange(column_document(spheres, seed=seed, params=params, width=width)))

    return Case(optimizer, f"tolerance {tolerance:.0e}", spheres, run)


def paper_case(spheres: int, width: float) -> Case:
    """Return the paper's Algorithm 1 as printed: all pairs, no end game, the paper's settings."""
    return Case("the paper's", "all pairs", spheres, lambda seed: _by_the_paper(spheres, width, seed))


def _by_the_paper(spheres: int, width: float, seed: int) -> Outcome:
    scene, container = read_scene(column_document(spheres, seed=seed, width=width))
    supply = Supply(scene.zones[0], scene.particle_sets, np.random.default_rng(seed))
    height = float(container.bounds[1, 2])
    inward = torch.cat([torch.eye(3), -torch.eye(3)]).to(torch.float64)
    walls = PlaneWalls(inward, torch.tensor([width, width, height, 0.0, 0.0, 0.0], dtype=torch.float64))
    none = torch.empty(0, dtype=torch.float64)

    def sample(rng: np.random.Generator, count: int, low: float, thickness: float) -> Float64Array:
        return np.array([0.0, 0.0, low]) + rng.random((count, 3)) * [width, width, thickness]

    start = time.perf_counter()
    packed = pack_zone_adam(
        supply,
        Surroundings(
            walls,
            ZoneSpace(0.0, height, lambda _: width**2, lambda _: 1.0, sample),
            torch.tensor([0.0, 0.0, -1.0], dtype=torch.float64),
            none.reshape(0, 3),
            none,
        ),
        AdamSettings(),
        np.random.default_rng(seed),
        all_pairs=True,
    )
    seconds = time.perf_counter() - start
    return Outcome(bed_of(packed.position, packed.radius, width=width, height=height), seconds)


def spheropack_case(fraction: float, spheres: int, width: float) -> Case:
    """Return spheropack growing spheres in a box of just the volume for a solid fraction."""

    def run(seed: int) -> Outcome:
        import spheropack

        height = column_height(spheres, width=width, radius=RADIUS, fraction=fraction)
        box = spheropack.Box((width, width, height), periodic=False)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # that it stops early is told by its status
            start = time.perf_counter()
            packing = spheropack.pack(spheres, RADIUS, box, growth_rate=SPHEROPACK_GROWTH, seed=seed)
            seconds = time.perf_counter() - start
        bed = bed_of(np.asarray(packing.positions), np.asarray(packing.radii), width=width, height=height)
        jammed = f"jams at {packing.density:.3f}"
        return Outcome(bed, seconds, "" if packing.success else jammed)

    return Case("spheropack", f"fraction {fraction:.2f}", spheres, run)


def liggghts_case(modulus: float, spheres: int, width: float) -> Case:
    """Return LIGGGHTS' insertion and settling at a Young's modulus."""

    def run(seed: int) -> Outcome:
        poured = pour(spheres, width=width, radius=RADIUS, youngs_modulus=modulus, seed=seed)
        bed = bed_of(poured.position, poured.radius, width=width, height=poured.height)
        return Outcome(bed, poured.seconds)

    return Case("LIGGGHTS", f"E {modulus:.0e} Pa", spheres, run)


def make_cases(
    methods: Sequence[str], count: dict[str, int], tolerances: Sequence[float], width: float
) -> list[Case]:
    """Return the cases of the methods that are installed, and say which are not."""
    cases: list[Case] = []
    for method in methods:
        spheres = count[method]
        if method in ("projection", "adam"):
            cases += [packgen_case(method, tolerance, spheres, width) for tolerance in tolerances]
        elif method == "the paper's":
            cases.append(paper_case(spheres, width))
        elif method == "spheropack":
            if importlib.util.find_spec("spheropack") is None:
                print("spheropack is not installed (pip install spheropack): left out")
                continue
            cases += [spheropack_case(fraction, spheres, width) for fraction in SPHEROPACK_FRACTIONS]
        elif not liggghts_installed():
            print("LIGGGHTS is not installed (apt-get install liggghts): left out")
        else:
            cases += [liggghts_case(modulus, spheres, width) for modulus in LIGGGHTS_MODULI]
    return cases


def run_rounds(cases: Sequence[Case], repeats: int, seed: int) -> list[dict[str, Any]]:
    """Run every case once a round; return a row a run."""
    for optimizer in {case.method for case in cases} & {"projection", "adam"}:
        packgen_case(optimizer, 1e-2, 30, 0.3).run(seed)  # compiles
    rows = []
    for number in range(repeats):
        for case in cases:
            outcome = case.run(seed + number)
            bed, seconds = outcome.bed, outcome.seconds
            row = {
                "method": case.method,
                "setting": case.setting,
                "spheres": bed.count,
                "asked": case.spheres,
                "round": number,
                "seed": seed + number,
                "microseconds_a_sphere": 1e6 * seconds / max(bed.count, 1),
                **quality(bed).as_row(),
                "remark": outcome.remark,
            }
            print(
                f"round {number + 1}/{repeats}  {case.method}, {case.setting}: {1e3 * seconds:.0f} ms",
                flush=True,
            )
            rows.append(row)
    return rows


def medians(rows: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a row a case: medians over the rounds, and the range of the times."""
    grouped: dict[tuple[str, str], list[dict[str, Any]]] = {}
    for row in rows:
        grouped.setdefault((row["method"], row["setting"]), []).append(row)
    result = []
    for (method, setting), runs in grouped.items():
        times = [run["microseconds_a_sphere"] for run in runs]
        middle: dict[str, Any] = {"method": method, "setting": setting, "asked": runs[0]["asked"]}
        for name in MEASURED:
            found = [run[name] for run in runs if run[name] is not None]
            middle[name] = median(found) if found else None
        remarks = "; ".join(dict.fromkeys(run["remark"] for run in runs if run["remark"]))
        result.append(middle | {"fastest": min(times), "slowest": max(times), "remark": remarks})
    return result


def as_table(summary: Iterable[dict[str, Any]]) -> str:
    """Return the medians as a table."""
    head = (
        "method", "setting", "spheres", "depth", "us a sphere", "(range)", "largest overlap", "mean overlap",
        "core density", "step-0 force", "",
    )  # fmt: skip
    rows = [
        (
            row["method"],
            row["setting"],
            f"{row['spheres']:,.0f}",
            output.number(row["depth"]),
            output.number(row["microseconds_a_sphere"]),
            f"{output.number(row['fastest'])} to {output.number(row['slowest'])}",
            output.number(row["overlap_max"], 2),
            output.number(row["overlap_mean"], 2),
            "-" if row["core_density"] is None else f"{row['core_density']:.3f}",
            output.number(row["force_max"], 2),
            row["remark"],
        )
        for row in summary
    ]
    return output.table(head, rows)


def parse(arguments: Sequence[str] | None) -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the results; made when missing")
    parser.add_argument("--spheres", type=int, default=20_000, help="spheres (default 20,000)")
    parser.add_argument(
        "--spheres-slow", type=int, default=5000, help="of adam and of the paper's, at most (default 5,000)"
    )
    parser.add_argument("--width", type=float, default=WIDTH, help="side of the column [m] (default 2)")
    parser.add_argument("--repeats", type=int, default=3, help="rounds (default 3)")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first round (default 0)")
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=METHODS, help="default: all")
    parser.add_argument(
        "--tolerances", nargs="+", type=float, default=TOLERANCES, help="default: 1e-2 to 1e-8"
    )
    return parser.parse_args(arguments)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark and write its results."""
    options = parse(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed) | {"rounds": str(options.repeats)}
    count = dict.fromkeys(METHODS, options.spheres)
    for method in ("adam", "the paper's"):
        count[method] = min(options.spheres, options.spheres_slow)
    cases = make_cases(options.methods, count, options.tolerances, options.width)
    rows = run_rounds(cases, options.repeats, options.seed)
    summary = medians(rows)
    stem = options.out / "speed_against_error"
    output.write_csv(stem.with_suffix(".csv"), rows, facts)
    column = f"column {options.width:g} m by {options.width:g} m, equal spheres of radius {RADIUS:g} m"
    notes = (
        "Medians over the rounds. Depth of the bed in diameters: shallow beds are less dense.",
        "Overlaps in radii, of pairs and walls; mean over the pairs that overlap.",
        "Step-0 force: largest contact force in sphere weights, Hertz' law at E = 1e8 Pa, 2500 kg/m3.",
        "Core density: solid fraction of the inner two thirds of the filled box.",
        "packgen: the arrangement alone. LIGGGHTS: the program from start to end.",
        "spheropack has neither floor nor gravity: nothing carries anything, and no bed results.",
    )
    table = as_table(summary)
    output.write_text(stem.with_suffix(".txt"), f"Speed against error: {column}", facts, [table], notes)
    tradeoff_plot.draw(summary, facts, stem.with_suffix(".png"))
    print(f"\n{table}\n\nwritten to {options.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
