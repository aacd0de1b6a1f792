"""How well spheres stand for stones: packgen's clumps, inscribed and best fitting, beside those of CLUMP.

    python tests/benchmarks/clump_makers.py --out DIR [--spheres 60] [--peer FOLDER]

The stones are those that come with the examples. All clumps are measured by the same code: volume and inertia
of the union of the spheres are exact, each place counted once. CLUMP (PyPI: clump-python) is run where it is
installed, or found in FOLDER, by two of its ways; where one fails its row says so. The last row is 50 spheres
in the pebble with four times as many facets.

Times are processor times; the column's is beside them, for the speed of the machine. Writes clump_makers.csv
and clump_makers.txt into DIR.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import machine
import numpy as np
import output
from columns import column_document, read_scene

from packgen.arrays import Float64Array
from packgen.clumps import Wanted, make_clump
from packgen.clumps.body import Body
from packgen.clumps.fit import Fit, fit_of
from packgen.clumps.stone import read_stone
from packgen.errors import PackgenError
from packgen.filling.pack import pack
from packgen.geometry import Surface

STONES = Path(__file__).resolve().parents[2] / "examples" / "stones"
NAMES = ("crushed", "pebble", "shard")
COLUMN = 5_000
HEAD = (
    "stone", "facets", "made by", "spheres", "volume [%]", "missing or outside [%]", "inertia [%]",
    "centre [equivalent d]", "time [s]",
)  # fmt: skip
PEER_NOTES = (
    "CLUMP 0.3.3: Favier's way by the least distance, the Euclidean one at 102 divisions, overlap 0.6.",
    "Its Euclidean clump of the shard is as CLUMP places it, beside the stone.",
)
Row = dict[str, Any]


def row(stone: str, facets: int, maker: str, count: int, fit: Fit | None, seconds: float) -> Row:
    """Return a row of the table; a maker that failed has no fit."""
    errors = (np.nan,) * 4
    if fit is not None:
        errors = (
            100.0 * fit.volume_error, 100.0 * fit.misplaced, 100.0 * fit.inertia_error, fit.centre_error
        )  # fmt: skip
    found = dict(zip(HEAD, (stone, facets, maker, count, *errors, seconds), strict=True))
    print(found, flush=True)
    return found


def own_rows(name: str, stone: Path, spheres: int) -> list[Row]:
    """Return the rows of packgen's two clumps of a stone."""
    rows = []
    for best_fit in (False, True):
        start = time.process_time()
        made = make_clump(stone, Wanted(spheres=spheres, best_fit=best_fit))
        seconds = time.process_time() - start
        facets = 0 if made.surface is None else len(made.surface.faces)
        maker = "packgen, best fit" if best_fit else "packgen, inscribed"
        rows.append(row(name, facets, maker, made.template.count, made.fit, seconds))
    return rows


def peers() -> dict[str, Callable[[str, int], Any]]:
    """Return CLUMP's ways of making a clump of a number of spheres; none where it is not installed."""
    try:
        import CLUMP  # type: ignore[import-not-found]
    except ImportError:
        return {}
    return {
        "CLUMP, Favier": lambda path, count: CLUMP.GenerateClump_Favier(path, count, chooseDistance="min"),
        "CLUMP, Euclidean": lambda path, count: CLUMP.GenerateClump_Euclidean_3D(path, count, 0.0, 102, 0.6),
    }


def peer_rows(name: str, stone: Path, body: Body, spheres: int) -> list[Row]:
    """Return the rows of CLUMP's clumps of a stone."""
    rows = []
    facets = len(body.surface.faces)
    for maker, make in peers().items():
        start = time.process_time()
        try:
            _, clump = make(str(stone), spheres)
        except (ValueError, IndexError) as error:
            print(f"{maker}, {name}: {error}")
            rows.append(row(name, facets, f"{maker}: fails", 0, None, np.nan))
            continue
        seconds = time.process_time() - start
        made = np.column_stack([np.reshape(clump.positions, (-1, 3)), np.ravel(clump.radii)])
        made[:, :3] -= body.properties.centre
        rows.append(row(name, facets, maker, len(made), fit_of(body, made, inscribed=False), seconds))
    return rows


def finer(surface: Surface) -> Surface:
    """Return a surface each of whose facets is cut into four."""
    corner: Float64Array = surface.vertices[surface.faces]
    middle = 0.5 * (corner + np.roll(corner, -1, axis=1))
    a, b, c = (corner[:, k] for k in range(3))
    ab, bc, ca = (middle[:, k] for k in range(3))
    parts = [np.stack(each, axis=1) for each in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    points, index = np.unique(np.concatenate(parts).reshape(-1, 3), axis=0, return_inverse=True)
    return Surface(points, index.reshape(-1, 3))


def column_time(seed: int) -> float:
    """Return the processor time of the column by one thread [us a sphere]."""
    pack(*read_scene(column_document(100, seed=0)), threads=1)
    scene = read_scene(column_document(COLUMN, seed=seed))
    start = time.process_time()
    pack(*scene, threads=1)
    return 1e6 * (time.process_time() - start) / COLUMN


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--spheres", type=int, default=60)
    parser.add_argument("--peer", type=Path, help="folder that CLUMP and what it needs are installed in")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    if options.peer is not None:
        sys.path.append(str(options.peer))
    facts = machine.facts(0)
    make_clump(STONES / "crushed.stl", Wanted(spheres=5))  # compiles
    rows: list[Row] = []
    for name in NAMES:
        stone = STONES / f"{name}.stl"
        body = read_stone(stone, "m", print)
        rows += [*own_rows(name, stone, options.spheres), *peer_rows(name, stone, body, options.spheres)]
    fine = finer(read_stone(STONES / "pebble.stl", "m", print).surface)
    start = time.process_time()
    try:
        made = make_clump(fine, Wanted(spheres=50), name="pebble, finer")
    except PackgenError as error:
        raise SystemExit(str(error)) from error
    seconds = time.process_time() - start
    rows.append(row("pebble", len(fine.faces), "packgen, inscribed", 50, made.fit, seconds))
    output.write_csv(options.out / "clump_makers.csv", rows, facts)
    lines = [
        [each if isinstance(each, str) else output.number(each) for each in found.values()] for found in rows
    ]
    notes = (
        f"The column of 5,000 spheres took {column_time(0):.1f} us a sphere in the same run: 17 where the",
        "figures of speed are from. Missing or outside: volume that the spheres miss and put outside.",
        *(PEER_NOTES if peers() else ()),
    )
    output.write_text(
        options.out / "clump_makers.txt", "Clumps of stones", facts, [output.table(HEAD, lines)], notes
    )
    print((options.out / "clump_makers.txt").read_text(encoding="utf-8"))


if __name__ == "__main__":
    main()
