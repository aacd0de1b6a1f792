"""Figs. 6 and 7: time and speed-up over the number of threads, 10,000 spheres, batches of 500.

    python examples/studies/threads.py [--full]

The paper says "10,000 particles of size 0.3 in a container box of size 2x2x2", which holds about 40 spheres
of radius 0.3 m. The radius is read as 0.03 m, that of the paper's next study. Threads are torch's, and only
adam uses them: projection runs one thread whatever it is allowed, because its loops are too short to share
(tests/benchmarks/scaling.py).
"""

from __future__ import annotations

import argparse
import hashlib
from pathlib import Path
from typing import Any

import study
from study import columns, machine

NAME = "threads"
WIDTH, RADIUS = 2.0, 0.03  # m; the paper prints 0.3
SPHERES = {study.ADAM: 3000, study.PROJECTION: 10_000}
SPHERES_FULL = 10_000


def counts() -> list[int]:
    """Return the numbers of threads to try: the powers of two below the cores, and all cores."""
    cores = machine.usable_cores()
    return sorted({*(2**power for power in range(cores.bit_length()) if 2**power < cores), cores})


def measure(options: argparse.Namespace) -> list[study.Row]:
    """Return a row for each method, number of threads and seed."""
    rows = []
    for method, usual in SPHERES.items():
        spheres = options.spheres or (SPHERES_FULL if options.full else usual)
        params = {"optimizer": method} | ({"batch_size": study.BATCH} if method == study.ADAM else {})
        study.warm_up(method)
        for seed in study.seeds_of(options):
            # The numbers of threads take turns, so that a noisy machine slows all of them.
            for threads in options.threads or counts():
                document = study.box_document(WIDTH, RADIUS, spheres, seed, params)
                bed, seconds = columns.arrange(document, threads=threads)
                rows.append(
                    {
                        "method": method, "threads": threads, "seed": seed, "spheres": bed.count,
                        "seconds": round(seconds, 4),
                        "bed": "b" + hashlib.sha256(bed.position.tobytes()).hexdigest()[:11],
                    }
                )  # fmt: skip
                print(rows[-1], flush=True)
    return rows


def speedups(rows: list[study.Row]) -> dict[float, float]:
    """Return the mean time with one thread over the mean time with each number of threads."""
    times = {
        key[0]: study.spread(group, "seconds")[0] for key, group in study.grouped(rows, "threads").items()
    }
    return {threads: times[min(times)] / seconds for threads, seconds in times.items()}


def draw(rows: list[study.Row], facts: dict[str, str], path: Path) -> None:
    """Draw time a sphere and speed-up over the threads."""
    from matplotlib.ticker import MaxNLocator

    drawing = study.figure()
    time, gain = drawing.subplots(1, 2)
    for (method,), group in study.grouped(rows, "method").items():
        colour, label = study.COLOURS[method], f"{method}, {group[0]['spheres']:,.0f} spheres"
        each = [row | {"ms": 1e3 * row["seconds"] / row["spheres"]} for row in group]
        study.curve(time, each, "threads", "ms", label, colour)
        found = speedups(group)
        gain.plot(list(found), list(found.values()), "o-", color=colour, label=label)
    most = max(row["threads"] for row in rows)
    gain.plot([1, most], [1, most], color="#9ca3af", linewidth=1.0, label="ideal")
    for axes in (time, gain):
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_xlabel("threads")
        axes.set_ylim(bottom=0.0)
    _label(time, gain)
    study.save(drawing, path, facts)


def _label(time: Any, gain: Any) -> None:
    time.set_ylabel("time a sphere [ms]")
    gain.set_ylabel("speed-up")
    gain.legend(fontsize=8, frameon=False)


def main() -> None:
    """Read the command line, run, write."""
    parser = study.make_parser(__doc__)
    study.seeds_option(parser, 3)
    parser.add_argument("--spheres", type=int, help="spheres of every run (default: 3,000 and 10,000)")
    parser.add_argument(
        "--threads", type=int, nargs="+", help="numbers of threads (default: up to all cores)"
    )
    options = parser.parse_args()
    study.write(NAME, options, measure(options), draw)


if __name__ == "__main__":
    main()
