"""What the studies share: runs through packgen's Python interface, result files, the command line.

How scenes are built, machines described and figures drawn is the benchmarks' own code (tests/benchmarks).
"""

from __future__ import annotations

import argparse
import csv
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from statistics import mean
from typing import Any

sys.path.append(str(Path(__file__).resolve().parents[2] / "tests" / "benchmarks"))

import columns
import machine
import output

from packgen import pack
from packgen.arrange.collective.params import Params
from packgen.bed import Bed
from packgen.bedfile import save_bed
from packgen.check import check_bed
from packgen.container import load_container
from packgen.errors import PackgenError
from packgen.measure import solid_fraction
from packgen.page import write_pictures
from packgen.scene import Scene

RESULTS = Path(__file__).resolve().parent / "results"
EXAMPLES = Path(__file__).resolve().parent.parent
BATCH = 500  # the paper's batch size
ADAM, PROJECTION = "adam", "projection"
COLOURS = {ADAM: "#d97706", PROJECTION: "#2563eb"}
THIRD_COLOUR = "#7c3aed"

Row = dict[str, Any]


def box_document(width: float, radius: float, spheres: int | None, seed: int, params: Row) -> Row:
    """Return a scene, as its file would say it: equal spheres in a cube.

    Args:
        width: Side of the cube [m].
        radius: Radius of the spheres [m].
        spheres: How many; None: until it is full.
        seed: The scene's seed.
        params: The scene's ``params``.
    """
    document: Row = {
        "container": {"box": {"min": [0, 0, 0], "max": [width, width, width]}},
        "seed": seed,
        "params": params,
        "particle_sets": [{"radius_distribution": "constant", "radius": radius}],
    }
    if spheres is not None:
        document["zones"] = [{"n_particles": spheres, "set_proportions": [1.0]}]
    return document


def warm_up(method: str) -> None:
    """Arrange a few spheres, so that nothing is loaded or compiled while the clock runs."""
    columns.arrange(columns.column_document(60, seed=0, width=0.4, params={"optimizer": method}))


def pack_scene(scene: Scene, **params: Any) -> tuple[Bed, list[int | None], float]:
    """Pack a scene with some other settings.

    Args:
        scene: The scene.
        **params: Keys of ``params`` that differ from the scene's.

    Returns:
        (the bed, the spheres asked for zone by zone, wall time of the arrangement alone [s]).
    """
    scene = replace(scene, params=Params(**(scene.params.model_dump() | params)))
    container = load_container(scene)
    start = time.perf_counter()
    result = pack(scene, container)
    return result.bed, [zone.asked for zone in result.zones], time.perf_counter() - start


def quality(bed: Bed) -> Row:
    """Return solid fraction of the core and overlaps of a bed, by the code that judges every bed."""
    check, solid = check_bed(bed), solid_fraction(bed)
    return {
        "core_density": "" if solid.core is None else round(solid.core, 5),
        "overlap_mean": float(f"{check.overlap_mean:.3g}"),
        "overlap_max": float(f"{max(check.overlap_max, check.wall_overlap_max):.3g}"),
    }


def make_parser(description: str | None) -> argparse.ArgumentParser:
    """Return a parser with the options of every study; the script's docstring is the description."""
    parser = argparse.ArgumentParser(
        description=description, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder to write into (default: results)")
    parser.set_defaults(facts=machine.facts(seed=0))  # the load of the machine is that before the study
    parser.add_argument("--full", action="store_true", help="the paper's own size, for as long as it takes")
    return parser


def seeds_option(parser: argparse.ArgumentParser, default: int) -> None:
    """Add ``--seeds``: how often each point is run, with the seeds 0, 1, ..."""
    parser.add_argument(
        "--seeds", type=int, default=None, help=f"runs of each point (default: {default}; 10 with --full)"
    )
    parser.set_defaults(seeds_default=default)


def seeds_of(options: argparse.Namespace) -> range:
    """Return the seeds of a study: the paper repeats everything ten times."""
    chosen = options.seeds if options.seeds is not None else 10 if options.full else options.seeds_default
    return range(chosen)


def write(name: str, options: argparse.Namespace, rows: Sequence[Row], draw: Callable[..., None]) -> None:
    """Write the rows of a study as CSV and its plot, ``draw(rows, facts, path)``, and say where."""
    options.out.mkdir(parents=True, exist_ok=True)
    output.write_csv(options.out / f"{name}.csv", rows, options.facts)
    # Drawn from the file, so that a plot never shows more than the file holds.
    facts, rows = read(options.out / f"{name}.csv")
    draw(rows, facts, options.out / f"{name}.png")
    print(f"written: {options.out / name}.csv, {name}.png", file=sys.stderr)


def read(path: Path) -> tuple[dict[str, str], list[Row]]:
    """Return the facts and the rows of a study's CSV; numbers as floats, empty cells as None."""
    lines = path.read_text(encoding="utf-8").splitlines()
    head = [line[2:].split(": ", 1) for line in lines if line.startswith("# ")]
    rows = csv.DictReader(line for line in lines if not line.startswith("# "))
    return dict(head), [{key: _value(value) for key, value in row.items()} for row in rows]


def _value(text: str) -> Any:
    if text == "":
        return None
    try:
        return float(text)
    except ValueError:
        return text


def spread(rows: Iterable[Row], key: str) -> tuple[float, float, float]:
    """Return mean, least and most of a column."""
    values = [row[key] for row in rows]
    return mean(values), min(values), max(values)


def grouped(rows: Iterable[Row], *keys: str) -> dict[tuple[Any, ...], list[Row]]:
    """Return rows by the values of some columns, in the order of their first appearance."""
    groups: dict[tuple[Any, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(tuple(row[key] for key in keys), []).append(row)
    return groups


def curve(axes: Any, rows: Sequence[Row], x: str, y: str, label: str, colour: str) -> None:
    """Draw means over the seeds with bars from the least to the most, as the paper's figures do."""
    groups = grouped(rows, x)
    places = [key[0] for key in groups]
    spreads = [spread(group, y) for group in groups.values()]
    middle = [each[0] for each in spreads]
    below = [each[0] - each[1] for each in spreads]
    above = [each[2] - each[0] for each in spreads]
    axes.errorbar(
        places, middle, yerr=[below, above], marker="o", capsize=3, markersize=4, color=colour, label=label
    )


def figure(width: float = 8.0, height: float = 3.6) -> Any:
    """Return an empty figure in the benchmarks' look."""
    return output.start_figure(width, height)


def save(drawing: Any, path: Path, facts: dict[str, str]) -> None:
    """Write a figure with the machine and the date below it, small enough for a repository."""
    from PIL import Image

    output.save_figure(drawing, path, facts)
    with Image.open(path) as picture:
        few_colours = picture.convert("RGB").quantize(128)
    few_colours.save(path, optimize=True)


def show(axes: Any, bed: Bed, *, half: bool) -> None:
    """Show a bed as ``packgen --picture`` draws it, whole or cut in half; else say in words why not."""
    from matplotlib.image import imread

    axes.set_axis_off()
    with tempfile.TemporaryDirectory(prefix="packgen_") as folder:
        save_bed(bed, Path(folder) / "bed.npz")
        try:
            whole, cut = write_pictures(Path(folder))
        except PackgenError as error:
            axes.text(0.5, 0.5, str(error), ha="center", wrap=True, fontsize=7)
            return
        axes.imshow(imread(cut if half else whole))
