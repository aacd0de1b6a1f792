"""What processes that share a bed bring, and what they take: time, memory, files, and the scheduler's cost.

    python tests/benchmarks/workers.py --out DIR [--spheres 400000] [--diameters 120] [--repeats 2]

A box on a square base is filled by one process and by two of this machine, in turn, one thread each. They are
started, and have worked on a small bed, before time is taken. Their beds have to be the same, bit for bit.

- time: of the arrangement, and of its units alone: the last layers are made as one piece, by all cores
- memory: the most that any of the processes held, of which importing the libraries takes a part by itself
- files: what a unit writes
- scheduler: the time of a call that does nothing, handed to two processes, many at a time

Writes workers.csv (every run) and workers.txt (medians) into DIR.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import resource
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

import machine
import numpy as np
import output
from columns import sphere_volume

from packgen.arrange.crew import Alone, Crew
from packgen.arrange.task import Listener
from packgen.bed import Bed
from packgen.container import load_container
from packgen.filling.pack import pack
from packgen.scene import load_scene
from packgen.workers.cluster import Cluster, local_cluster

RADIUS = 0.5  # m
LOOSEST = 0.5  # solid fraction by which the height is chosen
SMALL = (40, 2_000)  # width in diameters, and spheres, of the bed before time is taken
CALLS = 500
WORKERS = (1, 2)


class Weighed(Alone):
    """One process that weighs the files which each call leaves.

    Attributes:
        written: Bytes of each unit's files.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__(folder, 1)
        self.written: list[int] = []

    def next_done(self) -> Any:
        """Make the next call."""
        before = self._sizes()
        done = super().next_done()
        after = self._sizes()
        self.written.append(sum(size for name, size in after.items() if name not in before))
        return done

    def _sizes(self) -> dict[str, int]:
        assert self.folder is not None
        return {path.name: path.stat().st_size for path in self.folder.glob("layer_*")}


def box_document(spheres: int, diameters: float, tile: float | str = "auto") -> dict[str, Any]:
    """Return a scene of equal spheres in a box on a square base so many diameters wide."""
    side = 2.0 * RADIUS * diameters
    height = spheres * sphere_volume(RADIUS) / (LOOSEST * side**2) + 10.0 * RADIUS
    return {
        "container": {"box": {"min": [0.0, 0.0, 0.0], "max": [side, side, height]}},
        "particle_sets": [{"radius_distribution": "constant", "radius": RADIUS}],
        "materials": {"default": {"youngs_modulus": 1.0e9}},
        "params": {"tile": tile},
        "zones": [{"n_particles": spheres}],
    }


def packed(document: dict[str, Any], crew: Crew, on_progress: Listener | None = None) -> Bed:
    """Return the bed of a scene; progress is told after each unit, and each of the last layers."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "box.yaml"
        path.write_text(json.dumps(document), encoding="utf-8")
        scene = load_scene(path)
        return pack(scene, load_container(scene), crew=crew, on_progress=on_progress).bed


def digest(bed: Bed) -> str:
    """Return what tells beds apart that differ in a bit."""
    arrays = (bed.position, bed.radius, bed.set_index, bed.batch_index)
    return hashlib.sha256(b"".join(np.ascontiguousarray(each).tobytes() for each in arrays)).hexdigest()


def peak_memory() -> int:
    """Return the most memory that this process has held [bytes]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def note(moments: list[float]) -> None:
    """Note the time."""
    moments.append(time.perf_counter())


def nothing(number: int) -> int:
    """Do nothing."""
    return number


def one_run(workers: int, document: dict[str, Any]) -> dict[str, Any]:
    """Fill the box by some processes; return time, memory and the bed's digest."""
    with tempfile.TemporaryDirectory() as folder, local_cluster(workers, Path(folder), 1) as crew:
        before = max(crew.client.run(peak_memory).values())
        for number, each in enumerate((box_document(SMALL[1], SMALL[0], 20.0), document)):
            own = Path(folder) / str(number)
            own.mkdir()
            moments: list[float] = []
            begin = time.perf_counter()
            bed = packed(each, Cluster(lambda: crew.client, own, 1), lambda _: note(moments))  # noqa: B023
            seconds = time.perf_counter() - begin
        units = len(list(own.glob("layer_*_tile_*[0-9].npz")))
        memory = max(crew.client.run(peak_memory).values())
    return {
        "what": f"{workers} processes" if workers > 1 else "1 process",
        "spheres": bed.count,
        "seconds": seconds,
        "seconds_units": moments[units - 1] - begin,
        "units": units,
        "memory_MB": memory / 1e6,
        "memory_before_MB": before / 1e6,
        "digest": digest(bed)[:16],
    }


def cost_of_calls() -> dict[str, Any]:
    """Return the time of a call that does nothing."""
    with tempfile.TemporaryDirectory() as folder, local_cluster(2, Path(folder), 1) as crew:
        for count in (10, CALLS):
            begin = time.perf_counter()
            for number in range(count):
                crew.hand_out((count, number), nothing, number)
            for _ in range(count):
                crew.next_done()
            seconds = time.perf_counter() - begin
    return {"what": "call", "seconds": seconds / CALLS}


def weights(document: dict[str, Any]) -> dict[str, Any]:
    """Return how much a unit writes, in the middle of a bed."""
    with tempfile.TemporaryDirectory() as folder:
        crew = Weighed(Path(folder))
        packed(document, crew)
    return {"what": "unit", "written_MB": median(crew.written) / 1e6}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--spheres", type=int, default=400_000)
    parser.add_argument("--diameters", type=float, default=120.0)
    parser.add_argument("--repeats", type=int, default=2)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args(arguments)
    facts = machine.facts(given.seed)
    document = box_document(given.spheres, given.diameters) | {"seed": given.seed}
    rows = [cost_of_calls(), weights(document)]
    for number in range(given.repeats):
        order = WORKERS if number % 2 == 0 else WORKERS[::-1]
        rows += [one_run(workers, document) for workers in order]
    given.out.mkdir(parents=True, exist_ok=True)
    output.write_csv(given.out / "workers.csv", rows, facts)
    write_summary(given.out / "workers.txt", rows, facts, given.diameters)


def write_summary(path: Path, rows: list[dict[str, Any]], facts: dict[str, str], diameters: float) -> None:
    """Write the medians."""
    runs = [row for row in rows if "spheres" in row]
    lines, seconds, of_units = [], [], []
    for what in dict.fromkeys(row["what"] for row in runs):
        own = [row for row in runs if row["what"] == what]
        seconds.append(median(row["seconds"] for row in own))
        of_units.append(median(row["seconds_units"] for row in own))
        lines.append(
            (
                what,
                f"{own[0]['spheres']:,}",
                output.number(seconds[-1]),
                output.number(of_units[-1]),
                output.number(1e6 * seconds[-1] / own[0]["spheres"]),
                output.number(max(row["memory_MB"] for row in own)),
                output.number(median(row["memory_before_MB"] for row in own)),
            )
        )
    head = (
        "processes",
        "spheres",
        "time [s]",
        "of units [s]",
        "us a sphere",
        "peak memory [MB]",
        "of it before [MB]",
    )
    one_bed = len({row["digest"] for row in runs}) == 1
    notes = [
        f"two processes against one: {seconds[0] / seconds[1]:.2f} times as fast, "
        f"their units {of_units[0] / of_units[1]:.2f} times",
        f"all beds are {'the same one, bit for bit' if one_bed else 'DIFFERENT'}",
        f"units a bed: {runs[0]['units']}; a unit writes {output.number(rows[1]['written_MB'])} MB",
        f"a call that does nothing: {1e3 * rows[0]['seconds']:.2f} ms",
    ]
    title = f"A bed made by processes that share the work, in a box {diameters:g} diameters wide"
    output.write_text(path, title, facts, [output.table(head, lines)], notes)


if __name__ == "__main__":
    main()
