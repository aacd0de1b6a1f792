"""Do the solvers agree? The examples' beds in LIGGGHTS, LAMMPS and YADE, their decks unedited.

    python tests/benchmarks/solver_agreement.py --out DIR [--spheres 5000] [--scenes box cone furnace tank]

Each scene is packed with its number of spheres cut to --spheres. Its bed is run twice: as it is, for the
forces at step 0 and the gravity run; and with all radii larger by half a percent, so that thousands of pairs
overlap, for the forces at step 0 alone. "off the law" is the largest difference of a pair's force from Hertz'
law at the overlap of the bed's own numbers, relative to the force or to a thousandth of a sphere's weight:
two solvers differ from each other by no more than the sum. LAMMPS has no walls for a container that is not
convex.

Writes solver_agreement.csv and solver_agreement.txt into DIR.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import machine
import output

import exporters
from packgen.bed import Bed
from packgen.container import load_container
from packgen.filling.pack import pack
from packgen.geometry import Mesh
from packgen.scene import Scene, load_scene
from packgen.validation import Limits, SolverReport, predicted_forces, validate
from packgen.validation.process import SOLVERS

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SCENES = ("box", "cone", "furnace", "tank")
GROWTH = 1.005  # of the radii, so that neighbours overlap
STEP_ZERO_ONLY = 0.01  # free-fall times

Row = dict[str, Any]


def packed(name: str, spheres: int) -> Bed:
    """Return the bed of an example, its zones cut to a number of spheres in all."""
    scene = load_scene(EXAMPLES / f"{name}.yaml")
    return pack(_cut(scene, spheres), load_container(scene)).bed


def _cut(scene: Scene, spheres: int) -> Scene:
    asked = [each.n_particles for each in scene.zones]
    if any(each is None for each in asked):
        return scene  # until full
    share = min(1.0, spheres / sum(each for each in asked if each is not None))
    counts = [{"n_particles": round(share * (each or 0))} for each in asked]
    zones = tuple(each.model_copy(update=count) for each, count in zip(scene.zones, counts, strict=True))
    return replace(scene, zones=zones)


def run(name: str, kind: str, bed: Bed, solver: str, limits: Limits) -> Row:
    """Return what a solver made of a bed, as a row of the table."""
    exporter = exporters.get(solver)
    with tempfile.TemporaryDirectory(prefix="packgen_") as folder:
        exporter.write(bed, Path(folder), exporter.Options())
        report = validate(bed, Path(folder), solver=solver, limits=limits)
    return _row(name, kind, bed, report)


def _row(name: str, kind: str, bed: Bed, report: SolverReport) -> Row:
    zero, gravity, predicted = report.step_zero, report.gravity_run, predicted_forces(bed)
    return {
        "scene": name,
        "bed": kind,
        "solver": report.version,
        "spheres": bed.count,
        "pairs": zero.pair_count,
        "pairs_by_geometry": predicted.pair_count,
        "pair_force_max": zero.pair_force_max,
        "pair_force_max_by_law": predicted.pair_force_max,
        "off_the_law": zero.law_error,
        "free_fall_times": gravity.free_fall_times,
        "lost": len(gravity.lost),
        "displacement": gravity.displacement_rest_mean,
        "sinking": gravity.sinking_rest,
    }


def measure(options: argparse.Namespace) -> list[Row]:
    """Return a row for each scene, bed and solver that can take it."""
    rows = []
    limits = Limits(free_fall_times=options.free_fall_times)
    for name in options.scenes:
        bed = packed(name, options.spheres)
        grown = replace(bed, radius=GROWTH * bed.radius)
        for solver in options.solvers:
            if solver == "lammps" and isinstance(bed.container.shape, Mesh):
                continue
            rows.append(run(name, "grown", grown, solver, replace(limits, free_fall_times=STEP_ZERO_ONLY)))
            rows.append(run(name, "as packed", bed, solver, limits))
            print(f"{name}, {solver}: lost {rows[-1]['lost']}", flush=True)
    return rows


def tables(rows: Sequence[Row]) -> list[str]:
    """Return the table of forces and that of the gravity runs."""
    forces = [
        (
            f"{row['scene']}, {row['spheres']} spheres, {row['bed']}", row["solver"], f"{row['pairs']}",
            f"{row['pairs_by_geometry']}", f"{row['pair_force_max']:.9g}",
            f"{row['pair_force_max_by_law']:.9g}", output.number(row["off_the_law"], 2),
        )
        for row in rows
    ]  # fmt: skip
    runs = [
        (
            f"{row['scene']}, {row['spheres']} spheres", row["solver"], f"{row['free_fall_times']:.1f}",
            f"{row['lost']}", f"{row['displacement']:.3f}", f"{100 * row['sinking']:.2f}",
        )
        for row in rows
        if row["bed"] == "as packed"
    ]  # fmt: skip
    head = ("bed", "solver", "pairs", "by geometry", "largest force [W]", "by the law", "off the law")
    return [
        "Forces at step 0:\n\n" + output.table(head, forces),
        "Gravity run (length in free-fall times; displacement in radii and sinking in percent of the height,"
        " without their elastic part):\n\n"
        + output.table(("bed", "solver", "length", "lost", "displacement", "sinking"), runs),
    ]


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write the results, and print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    there = [name for name, (program, _) in SOLVERS.items() if shutil.which(program)]
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    parser.add_argument("--spheres", type=int, default=5000)
    parser.add_argument("--scenes", nargs="+", choices=SCENES, default=SCENES)
    parser.add_argument("--solvers", nargs="+", choices=there, default=there)
    parser.add_argument("--free-fall-times", type=float, default=Limits().free_fall_times)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts, rows = machine.facts(0), measure(options)
    output.write_csv(options.out / "solver_agreement.csv", rows, facts)
    title = "The examples' beds in each solver, from decks as packgen writes them"
    output.write_text(options.out / "solver_agreement.txt", title, facts, tables(rows))
    print(*tables(rows), sep="\n\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
