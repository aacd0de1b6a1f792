"""Jammed beds in a periodic cell: time a sphere, solid fraction and proof, for several numbers and size laws.

    python tests/benchmarks/jammed.py --out DIR [--equal 1000 10000] [--mixed 4000] [--repeats 3]

Equal spheres of each number, then the size laws. Up to 2,000 equal spheres spheropack, an event-driven
Lubachevsky-Stillinger code, jams as many (``density="max"``) where it is installed. Cases take turns, so that
a noisy machine slows all of them; medians over the rounds make the table. Beside each round the column of 2 m
by 2 m that the figures of speed refer to is packed by ``projection``: its time a sphere tells how fast the
machine is.

- fraction: solid volume over the cell; below it what Farr and Groot's rods give for these sizes
- proof: whether a linear programme proves the bed, contacts beyond isostatic, residual of the forces

Writes jammed.csv (every run) and jammed.txt (medians) into DIR.
"""

from __future__ import annotations

import argparse
import importlib.util
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import machine
import numpy as np
import output
from columns import arrange, column_document, read_scene

from packgen.check import check_bed
from packgen.filling.pack import PackResult, pack
from packgen.supply.close_packing import EQUAL_SPHERES, close_packing_fraction

COLUMN = 5_000  # spheres of the column that tells how fast the machine is
EDGE = 10.0  # m, of the cell asked for; the spheres set the one reached
FEW = 2_000  # spheres up to which a peer that takes milliseconds a sphere has its turn


@dataclass(frozen=True, slots=True)
class Run:
    """One run: a row of the table."""

    method: str
    sizes: str
    spheres: int
    seconds: float
    fraction: float
    close_packing: float
    overlap: float
    proven: str
    excess: int | None
    residual: float | None
    column_microseconds: float


def laws() -> dict[str, tuple[list[dict[str, Any]], dict[str, Any]]]:
    """Return the size laws: particle sets and shares."""

    def constant(radius: float) -> dict[str, Any]:
        return {"radius_distribution": "constant", "radius": radius}

    def lognormal(sigma: float) -> dict[str, Any]:
        return {"radius_distribution": "lognormal", "radius_median": 0.5, "sigma": sigma}

    by_volume = {"set_proportions": [0.2, 0.8], "proportions_by": "volume"}
    passing = {"diameters": [0.2, 0.4, 0.8, 2.0], "passing": [0.0, 0.3, 0.6, 1.0]}
    return {
        "1:1.4": ([constant(0.5), constant(0.7)], {}),
        "1:2": ([constant(0.5), constant(1.0)], {}),
        "1:5, 20 vol% small": ([constant(0.2), constant(1.0)], by_volume),
        "lognormal 0.3": ([lognormal(0.3)], {}),
        "lognormal 0.5": ([lognormal(0.5)], {}),
        "sieve, a decade": ([{"radius_distribution": "sieve", **passing}], {}),
    }


def packed(sets: Sequence[dict[str, Any]], zone: dict[str, Any], seed: int) -> tuple[PackResult, float]:
    """Return packgen's bed and what the arrangement took [s]."""
    document = {
        "container": {"box": {"min": [0.0] * 3, "max": [EDGE] * 3}, "periodic": ["x", "y", "z"]},
        "algorithm": "JAMMED",
        "seed": seed,
        "particle_sets": list(sets),
        "zones": [zone],
    }
    scene, vessel = read_scene(document)
    start = time.perf_counter()
    result = pack(scene, vessel)
    return result, time.perf_counter() - start


def packgen_run(
    name: str, sets: Sequence[dict[str, Any]], zone: dict[str, Any], seed: int, column: float
) -> Run:
    """Return the row of a bed of packgen's."""
    result, seconds = packed(sets, zone, seed)
    bed, proof = result.bed, result.jamming
    assert proof is not None
    check = check_bed(bed)
    return Run(
        "packgen", name, bed.count, seconds, solid(bed.radius) / bed.container.volume,
        close_packing_fraction(bed.radius), check.overlap_max,
        ("yes" if proof.proven else "no") if proof.certificate == "programme" else "-",
        proof.isostatic_excess, proof.force_residual, column,
    )  # fmt: skip


def spheropack_run(count: int, seed: int, column: float) -> Run:
    """Return the row of a bed of equal spheres that spheropack jams."""
    import spheropack

    start = time.perf_counter()
    packing = spheropack.pack(n=count, density="max", seed=seed)
    seconds = time.perf_counter() - start
    return Run(
        "spheropack",
        "equal",
        count,
        seconds,
        float(packing.density),
        EQUAL_SPHERES,
        0.0,
        "-",
        None,
        None,
        column,
    )


def solid(radius: np.ndarray) -> float:
    """Return the volume of spheres [m3]."""
    return float((4.0 / 3.0 * np.pi * radius**3).sum())


def column_time(seed: int) -> float:
    """Return the time a sphere that ``projection`` takes for the column [us]."""
    _, seconds = arrange(column_document(COLUMN, seed=seed))
    return 1e6 * seconds / COLUMN


def cases(equal: Sequence[int], mixed: int) -> list[Callable[[int, float], Run]]:
    """Return what makes each row, from seed and time of the column."""
    one_size = [{"radius_distribution": "constant", "radius": 0.5}]
    found: list[Callable[[int, float], Run]] = []
    for count in equal:
        found.append(partial(packgen_run, "equal", one_size, {"n_particles": count}))
        if count <= FEW and importlib.util.find_spec("spheropack") is not None:
            found.append(partial(spheropack_run, count))
    for name, (sets, shares) in (laws() if mixed else {}).items():
        found.append(partial(packgen_run, name, sets, {"n_particles": mixed, **shares}))
    return found


HEAD = (
    "sizes", "method", "spheres", "ms a sphere", "the same, column = 17 us", "fraction", "close packing",
    "overlap / r", "proven", "beyond isostatic", "residual",
)  # fmt: skip


def rows_of(runs: Sequence[Run]) -> list[tuple[str, ...]]:
    """Return the medians of equal cases as rows of text."""
    kinds = list(dict.fromkeys((run.sizes, run.method, run.spheres) for run in runs))
    rows = []
    for kind in kinds:
        own = [run for run in runs if (run.sizes, run.method, run.spheres) == kind]
        each = median(1e3 * run.seconds / run.spheres for run in own)
        column = median(run.column_microseconds for run in own)
        excess = [run.excess for run in own if run.excess is not None]
        residual = [run.residual for run in own if run.residual is not None]
        cells = [f"{kind[2]:,}", f"{each:.3f}", f"{each * 17.0 / column:.3f}"]
        cells += [
            f"{median(getattr(run, name) for run in own):.4f}" for name in ("fraction", "close_packing")
        ]
        cells += [output.number(max(run.overlap for run in own), 2), "/".join(run.proven for run in own)]
        cells += ["/".join(f"{value:+d}" for value in excess) or "-"]
        cells += [output.number(max(residual, default=None), 2)]
        rows.append((*kind[:2], *cells))
    return rows


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--equal", type=int, nargs="*", default=[1_000, 10_000])
    parser.add_argument("--mixed", type=int, default=4_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    packed([{"radius_distribution": "constant", "radius": 0.5}], {"n_particles": 50}, 0)  # compiles
    column_time(0)
    runs = []
    for number in range(options.repeats):
        column = column_time(options.seed + number)
        for case in cases(options.equal, options.mixed):
            runs.append(case(options.seed + number, column))
            print(runs[-1], flush=True)
    output.write_csv(options.out / "jammed.csv", [asdict(run) for run in runs], facts)
    output.write_text(
        options.out / "jammed.txt",
        "Jammed beds in a periodic cell",
        {**facts, "rounds": str(options.repeats)},
        [output.table(HEAD, rows_of(runs))],
        [
            "Medians over the rounds; overlap and residual are the largest. Residuals of beds with a proof "
            "are the largest sum of forces upon a sphere, of others the root mean square of all."
        ],
    )
    print((options.out / "jammed.txt").read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
