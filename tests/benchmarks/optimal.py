"""The best arrangements of equal spheres in the unit cube and the unit sphere, against the best ones known.

    python tests/benchmarks/optimal.py --out DIR [--cube 1 2 ...] [--sphere 1 2 ...] [--seconds 60] [--proofs]

The radii known are Packomania's, to ten digits, and closed forms. A case ends where its radius is within 1e-8
of that, or at the time limit, which is that of the machine on which the column of figures of speed takes 17
us a sphere: it is longer here, as the column packed before each case tells. One process makes all starts.
With ``--proofs`` and the package pyscipopt a branch and bound proves up to six equal spheres, and four
choices among unequal ones.

- off: radius found less the one known
- s, column = 17 us: time until then, in that of this machine

Writes optimal.csv and optimal.txt into DIR.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import machine
import numpy as np
import output
from columns import arrange, column_document

from packgen.arrange.optimal import proof
from packgen.arrange.optimal.bounds import scale_bound
from packgen.arrange.optimal.chain import chain
from packgen.arrange.optimal.choose import search
from packgen.arrange.optimal.room import Room
from packgen.container.primitives import ball_surface, box_surface
from packgen.distributions import UNIT_VOLUME
from packgen.geometry import Ball, Box, Container

COLUMN = 5_000  # spheres of the column that tells how fast the machine is
WITHIN = 1.0e-8
CUBE = dict(
    enumerate(
        [
            0.5, 0.3169872981, 0.2928932188, 0.2928932188, 0.2639320225, 0.2573593129, 0.2501361539, 0.25,
            0.2320508076, 0.2142857143, 0.2076222384, 0.2071067855, 0.2071067812, 0.2071067812, 0.1923076923,
            0.1887967684, 0.1886852389, 0.1876806011, 0.1831853032, 0.1784071997, 0.1772190444, 0.1732731032,
            0.1718167834, 0.1705406887, 0.1678040756, 0.1669051673, 0.1666666667, 0.1601910059, 0.1601886205,
            0.1601886205, 0.1601886205, 0.1601886205,
        ],
        start=1,
    )
)  # fmt: skip
SPHERE = dict(
    enumerate(
        [
            1.0, 0.5, 2.0 * math.sqrt(3.0) - 3.0, math.sqrt(6.0) - 2.0, math.sqrt(2.0) - 1.0,
            math.sqrt(2.0) - 1.0, 0.3859135574, 0.3780248448, (math.sqrt(3.0) - 1.0) / 2.0, 0.3530,
            0.3445765168, 0.3445765168,
        ],
        start=1,
    )
)  # fmt: skip
CHOICES = {
    (0.3, 0.3, 0.25, 0.25, 0.2): 0.277507,
    (0.35, 0.25, 0.25, 0.2, 0.2, 0.2): 0.411025,
    (0.4, 0.2, 0.2, 0.15, 0.15, 0.15, 0.15): 0.391652,
    (0.3, 0.29, 0.28, 0.27, 0.26, 0.25): 0.361120,
}
HEAD = (
    "container",
    "spheres",
    "known",
    "found",
    "off",
    "starts",
    "s",
    "s, column = 17 us",
    "bound, by proof",
)


@dataclass(frozen=True, slots=True)
class Row:
    """One case."""

    container: str
    spheres: int
    known: float
    found: float
    starts: int
    seconds: float
    column_microseconds: float
    bound: float | None = None
    proven: str = ""
    proof_seconds: float | None = None

    def cells(self) -> tuple[str, ...]:
        """Return it as text."""
        told = "" if self.bound is None else f"{self.bound:.9f}, {self.proven}, {self.proof_seconds:.0f} s"
        return (
            self.container, str(self.spheres), f"{self.known:.10g}", f"{self.found:.10f}",
            f"{self.found - self.known:+.1e}", str(self.starts), f"{self.seconds:.1f}",
            f"{self.seconds * 17.0 / self.column_microseconds:.1f}", told,
        )  # fmt: skip


def room(name: str) -> Room:
    """Return the unit cube or the unit sphere."""
    if name == "sphere":
        ball = Ball(np.zeros(3), 1.0)
        bounds, volume = np.array([[-1.0] * 3, [1.0] * 3]), UNIT_VOLUME
        found = Room.of(Container(name, ball, ball_surface(ball), bounds, volume))
    else:
        box = Box(np.zeros(3), np.ones(3))
        found = Room.of(Container(name, box, box_surface(box), np.array([[0.0] * 3, [1.0] * 3]), 1.0))
    assert found is not None
    return found


def column_time(seed: int) -> float:
    """Return the time a sphere that ``projection`` takes for the column [us]."""
    _, seconds = arrange(column_document(COLUMN, seed=seed))
    return 1e6 * seconds / COLUMN


def equal_spheres(name: str, count: int, limit: float, seed: int, proofs: bool) -> Row:
    """Return the row of equal spheres in a container."""
    known = (SPHERE if name == "sphere" else CUBE)[count]
    column, inside, radius = column_time(seed), room(name), np.full(count, 0.1)
    began = time.time()
    until = began + limit * column / 17.0
    best, starts = 0.0, 0
    # Ten spheres in a sphere are known to four digits.
    enough = known - (0.5e-4 if (name, count) == ("sphere", 10) else WITHIN)
    for number, each in enumerate(np.random.SeedSequence(seed).spawn(100_000)):
        starts = number + 1
        best = max(best, 0.1 * chain(inside, radius, number, each, until).placed.factor)
        if best >= enough or time.time() > until:
            break
    seconds = time.time() - began
    row = Row(name, count, known, best, starts, seconds, column)
    if not (proofs and proof.is_installed() and 1 < count <= 6):
        return row
    began = time.time()
    most = scale_bound(inside, radius, is_box=name == "cube").value
    reached = 10.0 * best * (1.0 - 1e-9)
    told = proof.prove_scale(inside, radius, reached, most, 10.0 * limit, is_box=name == "cube")
    proven = "proven" if told.finished else "not proven"
    return Row(
        name, count, known, best, starts, seconds, column, 0.1 * told.bound, proven, time.time() - began
    )


def choice(radii: tuple[float, ...], limit: float, seed: int, proofs: bool) -> Row:
    """Return the row of a choice among unequal spheres in the cube: volumes in place of radii."""
    known, column, inside = CHOICES[radii], column_time(seed), room("cube")
    size, number = np.unique(-np.array(radii), return_counts=True)
    size, began = -size, time.time()
    volume, value, tries, seconds = UNIT_VOLUME * size**3, 0.0, 0, 0.0
    until = began + limit * column / 17.0
    for best in search(inside, size, number, np.random.SeedSequence(seed), until, 30, lambda _: None):
        if float(best.numbers @ volume) > value:
            value, tries, seconds = float(best.numbers @ volume), best.tries, time.time() - began
        if value > known - 1e-6:
            break
    name = f"cube, of {' '.join(f'{each:g}' for each in radii)}"
    row = Row(name, int(best.numbers.sum()), known, value, tries, seconds, column)
    if not (proofs and proof.is_installed()):
        return row
    began = time.time()
    told = proof.prove_volume(inside, np.array(radii), value / UNIT_VOLUME, 10.0 * limit, is_box=True)
    proven = "proven" if told.finished else "not proven"
    bound = told.bound * UNIT_VOLUME
    return Row(name, row.spheres, known, value, tries, seconds, column, bound, proven, time.time() - began)


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--cube", type=int, nargs="*", default=list(CUBE))
    parser.add_argument("--sphere", type=int, nargs="*", default=list(SPHERE))
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--choices", action=argparse.BooleanOptionalAction, default=True)
    parser.add_argument("--proofs", action="store_true")
    parser.add_argument("--seed", type=int, default=0)
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    chain(room("cube"), np.ones(2), 0, np.random.SeedSequence(0), time.time() + 60.0)  # compiles
    column_time(0)
    limit, seed, proofs = options.seconds, options.seed, options.proofs
    rows: list[Row] = []

    def add(row: Row) -> None:
        rows.append(row)
        print("  ".join(row.cells()), flush=True)
        output.write_csv(options.out / "optimal.csv", [asdict(each) for each in rows], facts)
        near = [each.container for each in rows if each.found > each.known - WITHIN]
        notes = [f"within 1e-8: {near.count('cube')} in the cube, {near.count('sphere')} in the sphere"]
        notes.append(f"Time limit {limit:g} s of the machine on which the column takes 17 us a sphere.")
        output.write_text(
            options.out / "optimal.txt", "Best arrangements of a few spheres", facts,
            [output.table(HEAD, [each.cells() for each in rows])], notes,
        )  # fmt: skip

    for count in options.sphere:
        add(equal_spheres("sphere", count, limit, seed, proofs))
    for radii in CHOICES if options.choices else ():
        add(choice(radii, limit, seed, proofs))
    for count in options.cube:
        add(equal_spheres("cube", count, limit, seed, proofs))


if __name__ == "__main__":
    main()
