"""Voids filled by the largest spheres that fit: time a sphere, and how much of five bodies is covered.

    python tests/benchmarks/void_filling.py --out DIR [--spheres 5000] [--many 10000] [--facets 6]

Five bodies are filled with as many spheres each: box, cylinder, cone, a mesh in the shape of an L, and a
bumpy ball. The last one is filled with more spheres as a fine mesh, too: 20 x 4^K facets, 81,920 for K = 6.
Pairs and walls of each bed are checked by packgen's check, which shares nothing with the algorithm. Seconds
are those of the processor, of which one thread is used, so that others' work does not count.

Writes void_filling.csv (every run) and void_filling.txt into DIR.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import machine
import numpy as np
import output
from columns import read_scene
from jammed import solid

from packgen.check import check_bed
from packgen.filling.pack import pack

COARSE = 4  # times that the faces of the bumpy ball among the five bodies are divided


@dataclass(frozen=True, slots=True)
class Run:
    """One run: a row of the table."""

    body: str
    facets: int
    spheres: int
    seconds: float
    coverage: float
    radius_last: float
    overlap: float


def bumpy_ball(path: Path, divisions: int) -> int:
    """Write a ball with bumps and hollows; return its number of facets."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=divisions)
    x, y, z = ball.vertices.T
    radius = 1.0 + 0.25 * np.sin(3.0 * x + 1.0) * np.cos(4.0 * y) + 0.15 * np.sin(5.0 * z)
    ball.vertices = ball.vertices * radius[:, None]
    ball.export(path)
    return len(ball.faces)


def ell(path: Path) -> int:
    """Write an L of three cubes; return its number of facets."""
    import trimesh

    outline = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], np.float64)
    corners = np.concatenate([np.column_stack([outline, np.full(6, z)]) for z in (0.0, 1.0)])
    floor = [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 5, 4]]
    faces = floor + [[a + 6, c + 6, b + 6] for a, b, c in floor]
    for k in range(6):
        faces += [[k, (k + 1) % 6, (k + 1) % 6 + 6], [k, (k + 1) % 6 + 6, k + 6]]
    trimesh.Trimesh(corners, faces, process=False).export(path)
    return len(faces)


def bodies(folder: Path) -> dict[str, tuple[dict[str, Any], int]]:
    """Return the containers of the five bodies, and their facets."""
    facets = ell(folder / "ell.stl"), bumpy_ball(folder / "bumpy.stl", COARSE)
    return {
        "box": ({"box": {"min": [0, 0, 0], "max": [1.0, 0.9, 1.13]}}, 0),
        "cylinder": ({"cylinder": {"radius": 0.5, "height": 1.5}}, 0),
        "cone": ({"cone": {"radius_bottom": 0.3, "radius_top": 0.7, "height": 1.2}}, 0),
        "L": ({"path": str(folder / "ell.stl")}, facets[0]),
        "bumpy ball": ({"path": str(folder / "bumpy.stl")}, facets[1]),
    }


def filled(body: str, container: dict[str, Any], facets: int, spheres: int) -> Run:
    """Return the row of a body."""
    document = {
        "container": container,
        "algorithm": "VOID_FILLING",
        "particle_sets": [{"radius_distribution": "free", "radius_min": 1e-5}],
        "zones": [{"n_particles": spheres}],
    }
    scene, vessel = read_scene(document)
    start = time.process_time()
    bed = pack(scene, vessel).bed
    seconds = time.process_time() - start
    check = check_bed(bed)
    return Run(
        body, facets, bed.count, seconds, solid(bed.radius) / vessel.volume, float(bed.radius.min()),
        max(check.overlap_max, check.wall_overlap_max),
    )  # fmt: skip


HEAD = (
    "body", "facets", "spheres", "seconds", "ms a sphere", "coverage", "last radius, m", "overlap / r",
)  # fmt: skip


def row_of(run: Run) -> tuple[str, ...]:
    """Return a run as text."""
    each = 1e3 * run.seconds / run.spheres
    return (
        run.body, f"{run.facets:,}", f"{run.spheres:,}", f"{run.seconds:.1f}", f"{each:.2f}",
        f"{run.coverage:.4f}", output.number(run.radius_last), output.number(run.overlap, 2),
    )  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--spheres", type=int, default=5_000)
    parser.add_argument("--many", type=int, default=10_000)
    parser.add_argument("--facets", type=int, default=6)
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        five = bodies(folder)
        filled("box", *five["box"], 5)  # compiles
        runs: list[Run] = []
        for body, each in five.items():
            runs.append(filled(body, *each, options.spheres))
            print(runs[-1], flush=True)
        fine = folder / "fine.stl"
        facets = bumpy_ball(fine, options.facets)
        runs.append(filled("bumpy ball, fine", {"path": str(fine)}, facets, options.many))
    mean = float(np.mean([run.coverage for run in runs[: len(five)]]))
    output.write_csv(options.out / "void_filling.csv", [asdict(run) for run in runs], facts)
    output.write_text(
        options.out / "void_filling.txt",
        "Voids filled by the largest spheres that fit",
        facts,
        [output.table(HEAD, [row_of(run) for run in runs])],
        [f"Mean coverage of the five bodies: {mean:.4f}."],
    )
    print((options.out / "void_filling.txt").read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
