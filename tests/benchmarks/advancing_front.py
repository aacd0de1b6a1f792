"""Beds of an advancing front: time a sphere, solid fraction, contacts, for several sizes and vessels.

    python tests/benchmarks/advancing_front.py --out DIR [--spheres 10000 100000] [--rules lowest nearest]

Equal spheres, and uniform radii 1:2 and 1:5, fill a cube until it is full; then a vessel that is not convex
and the boundary of a mesh of tetrahedra. Cases take turns, so that a noisy machine slows all of them; medians
over the rounds make the table. Beside each round the column of 2 m by 2 m that the figures of speed refer to
is packed by ``projection``: its time a sphere tells how fast the machine is.

- fraction: solid volume over that of the vessel; core: away from the walls
- crystal: share of the spheres that sit in a crystal

Writes advancing_front.csv (every run) and advancing_front.txt (medians) into DIR.
"""

from __future__ import annotations

import argparse
import tempfile
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
from columns import arrange, column_document
from facets import write_mesh

from packgen.check import check_bed
from packgen.filling.pack import pack
from packgen.measure import core_of, solid_fraction
from packgen.measure.order import local_order

COLUMN = 5_000  # spheres of the column that tells how fast the machine is
FRACTION = 0.58  # solid fraction by which vessels are chosen for a number of spheres
RATIOS = {"equal": 1.0, "1:2": 2.0, "1:5": 5.0}
FACETS = 20_000  # of the vessel with a waist
LATTICE = 24  # cells along an edge of the block of tetrahedra; five tetrahedra each


@dataclass(frozen=True, slots=True)
class Run:
    """One run: a row of the table."""

    vessel: str
    sizes: str
    rule: str
    asked: int
    spheres: int
    seconds: float
    fraction: float
    core: float | None
    crystal: float
    overlap: float
    column_microseconds: float


def particle_set(ratio: float, solid: float, count: int) -> dict[str, Any]:
    """Return the set of spheres, so many of which have a solid volume [m3]."""
    # The mean of r^3 over uniform radii from 1 to the ratio.
    mean = 1.0 if ratio == 1.0 else (ratio**4 - 1.0) / (4.0 * (ratio - 1.0))
    least = (solid / (count * 4.0 / 3.0 * np.pi * mean)) ** (1.0 / 3.0)
    if ratio == 1.0:
        return {"radius_distribution": "constant", "radius": least}
    return {"radius_distribution": "uniform", "radius_min": least, "radius_max": ratio * least}


def write_tetrahedra(path: Path, lattice: int) -> int:
    """Write an L-shaped block of tetrahedra, five in each cubic cell; return how many there are."""
    import meshio

    number = np.arange((lattice + 1) ** 3).reshape(lattice + 1, lattice + 1, lattice + 1)
    points = np.stack(np.meshgrid(*[np.arange(lattice + 1) / lattice] * 3, indexing="ij"), axis=-1)
    i, j, k = (each.ravel() for each in np.meshgrid(*[np.arange(lattice)] * 3, indexing="ij"))
    kept = (i < lattice // 2) | (k < lattice // 2)
    i, j, k = i[kept], j[kept], k[kept]
    corner = [number[i + a, j + b, k + c] for a in (0, 1) for b in (0, 1) for c in (0, 1)]
    # Cells take turns between the two ways of cutting a cube in five, so that their faces match.
    ways = (
        ((0, 3, 5, 6), (1, 0, 3, 5), (2, 0, 3, 6), (4, 0, 5, 6), (7, 3, 5, 6)),
        ((1, 2, 4, 7), (0, 1, 2, 4), (3, 1, 2, 7), (5, 1, 4, 7), (6, 2, 4, 7)),
    )
    odd = (i + j + k) % 2 == 1
    cells = [np.stack([corner[c][odd == way] for c in four], axis=1) for way in (0, 1) for four in ways[way]]
    tetrahedra = np.concatenate(cells)
    meshio.write_points_cells(path, points.reshape(-1, 3), [("tetra", tetrahedra)])
    return len(tetrahedra)


def run(
    vessel: str, container: dict[str, Any], volume: float, sizes: str, rule: str, count: int, seed: int,
    column: float,
) -> Run:  # fmt: skip
    """Fill a vessel of a volume [m3] and return its row."""
    document = {
        "container": container,
        "algorithm": "ADVANCING_FRONT",
        "params": {"rule": rule},
        "seed": seed,
        "particle_sets": [particle_set(RATIOS[sizes], FRACTION * volume, count)],
        "zones": [{}],
    }
    start = time.perf_counter()
    bed = pack(document).bed
    seconds = time.perf_counter() - start
    check = check_bed(bed)
    return Run(
        vessel, sizes, rule, count, bed.count, seconds,
        float((4.0 / 3.0 * np.pi * bed.radius**3).sum()) / bed.container.volume,
        solid_fraction(bed).core, local_order(bed, core_of(bed)).crystal,
        max(check.overlap_max, check.wall_overlap_max), column,
    )  # fmt: skip


def cases(
    folder: Path, counts: Sequence[int], rules: Sequence[str], meshed: int, facets: int, lattice: int
) -> list[Callable[[int, float], Run]]:
    """Return what makes each row, from seed and time of the column."""
    cube = {"box": {"min": [0.0] * 3, "max": [1.0] * 3}}
    found: list[Callable[[int, float], Run]] = [
        partial(run, "cube", cube, 1.0, sizes, rule, count)
        for count in counts
        for sizes in RATIOS
        for rule in rules
    ]
    if meshed:
        number = write_mesh(folder / "waist.stl", facets, 0.2)
        cells = write_tetrahedra(folder / "block.vtu", lattice)
        for rule in rules:
            waist = {"path": str(folder / "waist.stl")}
            found.append(partial(run, f"waist, {number:,} facets", waist, 1.6, "1:2", rule, meshed))
            block = {"path": str(folder / "block.vtu")}
            found.append(partial(run, f"L, {cells:,} tetrahedra", block, 0.75, "1:2", rule, meshed))
    return found


HEAD = (
    "vessel", "sizes", "rule", "spheres", "us a sphere", "the same, column = 17 us", "fraction", "core",
    "crystal", "overlap / r",
)  # fmt: skip


def rows_of(runs: Sequence[Run]) -> list[tuple[str, ...]]:
    """Return the medians of equal cases as rows of text."""
    kinds = list(dict.fromkeys((each.vessel, each.sizes, each.rule, each.asked) for each in runs))
    rows = []
    for kind in kinds:
        own = [each for each in runs if (each.vessel, each.sizes, each.rule, each.asked) == kind]
        time_each = median(1e6 * each.seconds / each.spheres for each in own)
        column = median(each.column_microseconds for each in own)
        cores = [each.core for each in own if each.core is not None]
        rows.append(
            (
                *kind[:3],
                f"{median(each.spheres for each in own):,.0f}",
                f"{time_each:.1f}",
                f"{time_each * 17.0 / column:.1f}",
                f"{median(each.fraction for each in own):.4f}",
                f"{median(cores):.4f}" if cores else "-",
                f"{median(each.crystal for each in own):.3f}",
                output.number(max(each.overlap for each in own), 2),
            )
        )
    return rows


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--spheres", type=int, nargs="*", default=[10_000, 100_000])
    parser.add_argument("--rules", nargs="+", default=["lowest", "nearest"])
    parser.add_argument(
        "--meshed", type=int, default=20_000, help="spheres of the meshes; 0: none are filled"
    )
    parser.add_argument("--facets", type=int, default=FACETS)
    parser.add_argument("--lattice", type=int, default=LATTICE)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    runs = []
    with tempfile.TemporaryDirectory(prefix="packgen_") as name:
        folder = Path(name)
        small = cases(
            folder, [100], options.rules, 100 if options.meshed else 0, options.facets, options.lattice
        )
        for case in small:
            case(0, 1.0)  # compiles
        arrange(column_document(COLUMN, seed=0))
        every = cases(folder, options.spheres, options.rules, options.meshed, options.facets, options.lattice)
        for number in range(options.repeats):
            _, seconds = arrange(column_document(COLUMN, seed=options.seed + number))
            for case in every:
                runs.append(case(options.seed + number, 1e6 * seconds / COLUMN))
                print(runs[-1], flush=True)
    output.write_csv(options.out / "advancing_front.csv", [asdict(each) for each in runs], facts)
    output.write_text(
        options.out / "advancing_front.txt",
        "Beds of an advancing front",
        {**facts, "rounds": str(options.repeats)},
        [output.table(HEAD, rows_of(runs))],
        ["Medians over the rounds; overlap is the largest. Times are those of packing alone."],
    )
    print((options.out / "advancing_front.txt").read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
