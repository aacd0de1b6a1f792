"""How long each format takes to write a large bed, and how much memory.

    python tests/benchmarks/export_speed.py --out DIR [--spheres 500000] [--repeats 3] [--formats csv vtk ...]

The bed is a lattice of spheres of two sets in a box, shaken so that no two numbers are alike. Every format is
written in a process of its own, several times; the median counts. Processor time is what this process worked,
whatever else ran; wall time has the disk in it. Memory is the peak above what the process held with the bed
and its libraries loaded and a small bed written.

Writes export_speed.csv (every single run), export_speed.txt and export_speed.png into DIR.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

import machine
import numpy as np
import output

import exporters
from packgen.bed import Bed, Material, ParticleSet
from packgen.geometry import Box, Container, Surface

SECONDS_MAX = 2.0  # what a format may take for 500,000 spheres
RADIUS = 0.01  # m
MEGABYTE = 1.0e6
# A format and its options, by the name in the table.
VARIANTS = {
    "vtk with vtu": ("vtk", {"unstructured": True}),
    "liggghts, facets": ("liggghts", {"walls": "mesh"}),
    "fraction, hexahedra": ("fraction", {"mesh": "hexahedron"}),
    "fraction, tetrahedra": ("fraction", {"mesh": "tetra"}),
}
MESH_CELLS = 30  # hexahedra along each side of the box; each makes six tetrahedra

Row = dict[str, Any]
# Without these the bed is refused: each of its radii is a shape, and voxels are very many.
USUAL = {"phasicflow": {"shapes_max": 10_000_000}, "voxels": {"size": RADIUS / 2}}


def lattice(count: int, seed: int) -> Bed:
    """Return a bed of ``count`` spheres that nearly touch, of two sets, in a box with its walls."""
    rng = np.random.default_rng(seed)
    side = int(np.ceil(count ** (1 / 3)))
    steps = np.arange(side)
    grid = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)[:count]
    position = (2 * grid + 1 + rng.uniform(-0.05, 0.05, grid.shape)) * RADIUS
    high = np.full(3, 2 * side * RADIUS)
    corners = np.array([[x, y, z] for x in (0, high[0]) for y in (0, high[1]) for z in (0, high[2])])
    faces = np.array(
        [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6],
         [0, 6, 4], [1, 5, 7], [1, 7, 3]]
    )  # fmt: skip
    container = Container(
        "box",
        Box(np.zeros(3), high),
        Surface(corners, faces),
        np.stack((np.zeros(3), high)),
        float(high.prod()),
    )
    return Bed(
        position,
        rng.uniform(0.9, 0.95, count) * RADIUS,
        (np.arange(count) % 2).astype(np.int32),
        np.zeros(count, dtype=np.int32),
        (np.arange(count) // 4000).astype(np.int32),
        (ParticleSet("pellets", 3500.0, "ore"), ParticleSet("lumps", 1100.0, "coke")),
        (Material("ore"), Material("coke", friction=0.4)),
        "ore",
        container,
        np.array([0.0, 0.0, -9.81]),
    )


def measure(task: dict[str, Any]) -> list[Row]:
    """Return what writing one format took, one row a repetition; for a process that does nothing else."""
    name, options = VARIANTS.get(task["format"], (task["format"], USUAL.get(task["format"], {})))
    exporter = exporters.get(name)
    bed, small = lattice(task["spheres"], task["seed"]), lattice(1000, task["seed"])
    rows = []
    with tempfile.TemporaryDirectory(prefix="packgen_") as scratch:
        if "mesh" in options:
            options = {"mesh": cfd_mesh(bed, options["mesh"], Path(scratch) / "mesh.vtu")}
        _write(exporter, small, Path(scratch) / "small", options)
        for repeat in range(task["repeats"]):
            _forget_peak()
            held = _peak()
            folder = Path(scratch) / str(repeat)
            wall, worked = time.perf_counter(), time.process_time()
            _write(exporter, bed, folder, options)
            wall, worked = time.perf_counter() - wall, time.process_time() - worked
            size = sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
            rows.append(
                {
                    "format": task["format"],
                    "spheres": bed.count,
                    "seconds": wall,
                    "processor_seconds": worked,
                    "bytes": size,
                    "extra_memory_MB": max(0.0, _peak() - held),
                    "bed_MB": _bed_bytes(bed) / MEGABYTE,
                }
            )
    return rows


def cfd_mesh(bed: Bed, kind: str, path: Path) -> Path:
    """Write a mesh of the bed's box, of cells of one kind; return its path."""
    import meshio

    low, high = bed.container.bounds
    sides = [np.linspace(low[axis], high[axis], MESH_CELLS + 1) for axis in range(3)]
    points = np.stack(np.meshgrid(*sides, indexing="ij"), axis=-1).reshape(-1, 3)
    corner = np.array(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    )
    cells = np.stack(np.meshgrid(*[np.arange(MESH_CELLS)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    cells = (cells + corner) @ [(MESH_CELLS + 1) ** 2, MESH_CELLS + 1, 1]
    if kind == "tetra":
        around = [1, 2, 3, 7, 4, 5, 1]  # the way round the diagonal from corner 0 to corner 6
        cells = np.concatenate([cells[:, [0, first, second, 6]] for first, second in pairwise(around)])
    meshio.Mesh(points, [(kind, cells)]).write(path)
    return path


def _write(exporter: Any, bed: Bed, folder: Path, options: dict[str, Any]) -> None:
    folder.mkdir()
    exporter.write(bed, folder, exporter.Options(**options))


def _bed_bytes(bed: Bed) -> int:
    return sum(
        each.nbytes for each in (bed.position, bed.radius, bed.set_index, bed.zone_index, bed.batch_index)
    )


def _forget_peak() -> None:
    """Let the peak begin anew at what is held now, where the system can do that (Linux)."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")


def _peak() -> float:
    """Return the largest memory since the peak was forgotten, else since the start of the process [MB]."""
    try:
        status = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        unit = 1.0 if sys.platform == "darwin" else 1024.0
        return unit * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / MEGABYTE
    peak = next(line for line in status.splitlines() if line.startswith("VmHWM"))
    return 1024.0 * int(peak.split()[1]) / MEGABYTE


def medians(rows: Sequence[Row]) -> list[Row]:
    """Return one row a format: medians of the times, the largest memory."""
    found = []
    for name in dict.fromkeys(row["format"] for row in rows):
        of_format = [row for row in rows if row["format"] == name]
        times = {key: median(row[key] for row in of_format) for key in ("seconds", "processor_seconds")}
        peak = max(row["extra_memory_MB"] for row in of_format)
        found.append(of_format[0] | times | {"extra_memory_MB": peak})
    return found


def summary(rows: Sequence[Row]) -> str:
    """Return the table of the medians."""
    head = ("format", "processor s", "wall s", "MB written", "extra MB", "MB of the bed")
    return output.table(
        head,
        [
            (
                row["format"],
                f"{row['processor_seconds']:.2f}",
                f"{row['seconds']:.2f}",
                f"{row['bytes'] / MEGABYTE:.1f}",
                f"{row['extra_memory_MB']:.0f}",
                f"{row['bed_MB']:.0f}",
            )
            for row in medians(rows)
        ],
    )


def plot(rows: Sequence[Row], path: Path, facts: dict[str, str]) -> None:
    """Draw the processor time of each format beside the limit."""
    found = medians(rows)[::-1]
    figure = output.start_figure(7.0, 1.0 + 0.3 * len(found))
    axes = figure.subplots()
    axes.barh([row["format"] for row in found], [row["processor_seconds"] for row in found], color="#4878a8")
    axes.axvline(SECONDS_MAX, color=output.FAINT, linestyle="--")
    axes.set_xlabel("processor time [s]")
    axes.set_title(f"Writing {found[0]['spheres']:,} spheres")
    output.save_figure(figure, path, facts)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write the results, and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    names = [*exporters.BUILTIN, *VARIANTS]
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    parser.add_argument("--spheres", type=int, default=500_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--formats", nargs="+", choices=names, default=names, metavar="FORMAT")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts, rows = machine.facts(options.seed), []
    for name in options.formats:
        task = {
            "format": name, "spheres": options.spheres, "repeats": options.repeats, "seed": options.seed,
        }  # fmt: skip
        command = [sys.executable, str(Path(__file__).resolve()), "--task", json.dumps(task)]
        done = subprocess.run(command, capture_output=True, text=True, check=True)
        rows += json.loads(done.stdout)
    text = summary(rows)
    slow = [row["format"] for row in medians(rows) if row["processor_seconds"] > SECONDS_MAX]
    notes = [f"more than {SECONDS_MAX:g} s of processor time: {', '.join(slow) or 'none'}"]
    output.write_csv(options.out / "export_speed.csv", rows, facts)
    output.write_text(
        options.out / "export_speed.txt",
        "Time and memory to write a bed, by format: median times, largest memory",
        facts,
        [text],
        notes,
    )
    plot(rows, options.out / "export_speed.png", facts)
    print(text, *notes, sep="\n")
    return 0


if __name__ == "__main__":
    if sys.argv[1:2] == ["--task"]:
        print(json.dumps(measure(json.loads(sys.argv[2]))))
    else:
        sys.exit(main())
