"""The densest periodic cells of a few spheres: how many starts lead to the best value known, and how fast.

    python tests/benchmarks/shrinking_cell.py --out DIR [--starts 50] [--cases NaCl XY11 ...]

Each case is a list of radii and the solid fraction of the densest structure known: a closed form, or the best
of hundreds of starts elsewhere. Starts follow each other in one process, cases too. Before each case the
column of 2 m by 2 m that the figures of speed refer to is packed by ``projection``: the median of its times a
sphere tells how fast the machine is.

- off: the densest cell found less the value known
- hits: share of the starts that end within 1e-6 of that value

Writes shrinking_cell.csv (every start) and shrinking_cell.txt (a row a case) into DIR.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import mean, median

import machine
import numpy as np
import output
from columns import arrange, column_document

from packgen.arrange.shrinking_cell.arrange import cell_from
from packgen.arrange.shrinking_cell.shrink import Reach

COLUMN = 5_000  # spheres of the column that tells how fast the machine is
FCC = math.pi / math.sqrt(18.0)
NACL, ALB2 = math.sqrt(2.0) - 1.0, math.sqrt(7.0 / 3.0) - 1.0
CSCL, HOLE = math.sqrt(3.0) - 1.0, math.sqrt(1.5) - 1.0
CSCL_FRACTION = math.pi * math.sqrt(3.0) / 2.0 * (1.0 + CSCL**3) / (1.0 + CSCL) ** 3
ALB2_FRACTION = math.pi * (1.0 + 2.0 * ALB2**3) / (3.0 * math.sqrt(3.0))
CASES = {
    "1 equal": ([1.0], FCC),
    "2 equal": ([1.0] * 2, FCC),
    "4 equal": ([1.0] * 4, FCC),
    "8 equal": ([1.0] * 8, FCC),
    "NaCl": ([1.0, NACL], (5.0 / 3.0 - math.sqrt(2.0)) * math.pi),
    "AlB2": ([1.0, ALB2, ALB2], ALB2_FRACTION),
    "2 AlB2": ([1.0] * 2 + [ALB2] * 4, ALB2_FRACTION),
    "1:2, ratio 0.5": ([1.0, 0.5, 0.5], 0.75811369),
    "tetrahedral holes": ([1.0, HOLE, HOLE], FCC * (1.0 + 2.0 * HOLE**3)),
    "all holes": ([1.0] + [HOLE] * 3, FCC * (1.0 + 3.0 * HOLE**3)),
    "CsCl": ([1.0, CSCL], CSCL_FRACTION),
    "1:1, ratio 0.5": ([1.0, 0.5], 0.71244625),
    "1:4, ratio 0.29": ([1.0] + [0.29] * 4, 0.76987998),
    "1:6, ratio 0.35": ([1.0] + [0.35] * 6, 0.76796157),
    "XY11": ([1.0] + [0.2] * 11, 0.80564277),
    "XY11, ratio 0.2195": ([1.0] + [0.2195] * 11, 0.81865332),
}
HEAD = (
    "cell",
    "spheres",
    "known",
    "off",
    "hits",
    "median",
    "s a start",
    "the same, column = 17 us",
    "programmes",
)


@dataclass(frozen=True, slots=True)
class Start:
    """One start: a row of the file."""

    cell: str
    spheres: int
    known: float
    fraction: float
    seconds: float
    programmes: int
    column_microseconds: float


def starts_of(name: str, count: int, seed: int) -> list[Start]:
    """Return the starts of a case."""
    _, seconds = arrange(column_document(COLUMN, seed=seed))
    column, (radii, known) = 1e6 * seconds / COLUMN, CASES[name]
    found = []
    for each in np.random.SeedSequence(seed).spawn(count):
        began = time.perf_counter()
        cell = cell_from(np.array(radii), Reach(), each)
        took = time.perf_counter() - began
        found.append(Start(name, len(radii), known, cell.fraction, took, cell.steps, column))
    return found


def row_of(starts: Sequence[Start], column: float) -> tuple[str, ...]:
    """Return what a case's starts led to, as text; ``column`` is the machine's time a sphere [us]."""
    first = starts[0]
    seconds = mean(each.seconds for each in starts)
    return (
        first.cell,
        str(first.spheres),
        f"{first.known:.8f}",
        f"{max(each.fraction for each in starts) - first.known:+.1e}",
        f"{mean(each.fraction > first.known - 1e-6 for each in starts):.0%} of {len(starts)}",
        f"{median(each.fraction for each in starts):.4f}",
        f"{seconds:.2f}",
        f"{seconds * 17.0 / column:.2f}",
        f"{mean(each.programmes for each in starts):.0f}",
    )


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--starts", type=int, default=50)
    parser.add_argument("--cases", nargs="*", default=list(CASES), choices=list(CASES))
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    starts_of("1 equal", 1, 0)  # compiles
    found: dict[str, list[Start]] = {}
    for name in options.cases:
        found[name] = starts_of(name, options.starts, options.seed)
        column = median(own[0].column_microseconds for own in found.values())
        rows = [row_of(own, column) for own in found.values()]
        print("  ".join(rows[-1]), flush=True)
        runs = [asdict(each) for own in found.values() for each in own]
        output.write_csv(options.out / "shrinking_cell.csv", runs, facts)
        title = "Densest periodic cells of a few spheres, their shape free"
        output.write_text(options.out / "shrinking_cell.txt", title, facts, [output.table(HEAD, rows)])


if __name__ == "__main__":
    main()
