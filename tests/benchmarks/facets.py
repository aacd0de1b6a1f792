"""What a mesh of many facets costs, against a plain cylinder of the same spheres: the whole command.

    python tests/benchmarks/facets.py --out DIR [--facets 100000] [--spheres 100000]

Three vessels of about the same volume, 1 m wide and 2 m high: the primitive; the same cylinder as a mesh,
which is convex and is packed by its planes; and a mesh with a waist 4 % narrower, which is not convex and is
packed by its triangles. Each run is ``packgen SCENE --export liggghts`` in a fresh process with everything
compiled, the vessels in turn; times by stage are those of ``report.json``.

Writes facets.csv (every run), facets.txt (medians) and facets.png into DIR.
"""

from __future__ import annotations

import argparse
import json
import math
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

import machine
import numpy as np
import output
from columns import DENSITY

RADIUS, HEIGHT = 0.5, 2.0  # m
WAIST = 0.02  # of the radius, inwards and outwards
FILLED, FRACTION = 0.8, 0.6  # of the height, and of its volume
PLAIN = "plain cylinder"
STAGES = ("container", "arrange", "check", "measure", "write", "export", "page")


def write_mesh(path: Path, facets: int, waist: float) -> int:
    """Write a closed round vessel, wider at its ends and narrower half way up; return its number of facets.

    Args:
        path: An STL file.
        facets: About how many facets it gets.
        waist: How far its radius departs from `RADIUS`, as a fraction of it.
    """
    import trimesh

    around = max(8, round(math.sqrt(facets)))
    up = max(2, round(facets / (2 * around)))
    angle = 2.0 * np.pi * np.arange(around) / around
    height = np.linspace(0.0, HEIGHT, up + 1)
    radius = RADIUS * (1.0 + waist * np.cos(2.0 * np.pi * height / HEIGHT))
    # Circumscribed, so that the cylinder's spheres fit.
    radius = radius / math.cos(math.pi / around)
    rings = np.stack(
        [
            np.outer(radius, np.cos(angle)),
            np.outer(radius, np.sin(angle)),
            np.repeat(height[:, None], around, 1),
        ],
        axis=-1,
    )
    vertices = np.concatenate([rings.reshape(-1, 3), [[0, 0, 0], [0, 0, HEIGHT]]])
    low = (np.arange(up)[:, None] * around + np.arange(around)).ravel()
    turned = (np.arange(up)[:, None] * around + (np.arange(around) + 1) % around).ravel()
    first, last = np.arange(around), up * around + np.arange(around)
    bottom, top = np.full(around, len(vertices) - 2), np.full(around, len(vertices) - 1)
    faces = np.concatenate(
        [
            np.stack([low, turned, turned + around], axis=1),
            np.stack([low, turned + around, low + around], axis=1),
            np.stack([np.roll(first, -1), first, bottom], axis=1),
            np.stack([last, np.roll(last, -1), top], axis=1),
        ]
    )
    trimesh.Trimesh(vertices, faces, process=False).export(path)
    return len(faces)


def vessels(folder: Path, facets: int) -> dict[str, dict[str, Any]]:
    """Return the container of each vessel, as a scene says it, by name; meshes are written to a folder."""
    found: dict[str, dict[str, Any]] = {
        PLAIN: {"cylinder": {"radius": RADIUS, "height": HEIGHT}},
    }
    for name, waist in (("straight", 0.0), ("waisted", WAIST)):
        count = write_mesh(folder / f"{name}.stl", facets, waist)
        found[f"{name}, {count:,} facets"] = {"path": f"{name}.stl"}
    return found


def scene_of(container: dict[str, Any], spheres: int, seed: int) -> dict[str, Any]:
    """Return a scene of equal spheres that fill a vessel to `FILLED` of its height."""
    volume = FRACTION * FILLED * math.pi * RADIUS**2 * HEIGHT
    radius = (3.0 * volume / (4.0 * math.pi * spheres)) ** (1.0 / 3.0)
    return {
        "container": container,
        "seed": seed,
        "particle_sets": [{"radius_distribution": "constant", "radius": radius, "density": DENSITY}],
        "zones": [{"n_particles": spheres}],
    }


def run(folder: Path, name: str, scene: dict[str, Any]) -> dict[str, Any]:
    """Run the command on a scene once; return its row."""
    path = folder / "scene.yaml"
    path.write_text(json.dumps(scene), encoding="utf-8")  # JSON is YAML
    program = [sys.executable, "-m", "packgen", str(path), "--export", "liggghts", "--quiet", "--force"]
    start = time.perf_counter()
    subprocess.run([*program, "--output", str(folder / "bed")], check=True)
    seconds = time.perf_counter() - start
    report = json.loads((folder / "bed" / "report.json").read_text(encoding="utf-8"))
    stages = {stage: report["timings"].get(stage, 0.0) for stage in STAGES}
    return {
        "vessel": name, "spheres": report["sphere_count"], "seconds": seconds, **stages,
        "core_density": report["solid_fraction"]["core"], "overlap_max": report["overlap"]["overlap_max"],
        "peak_memory_MB": report["peak_memory"] / 1e6,
    }  # fmt: skip


def medians(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a row a vessel: medians over the rounds, and times as ratios to the plain cylinder's."""
    found = []
    for name in dict.fromkeys(row["vessel"] for row in rows):
        mine = [row for row in rows if row["vessel"] == name]
        middle = {key: median(row[key] for row in mine) for key in mine[0] if key not in {"vessel", "round"}}
        found.append({"vessel": name, **middle})
    for row in found:
        for key in ("seconds", "arrange"):
            row[f"{key}_ratio"] = row[key] / found[0][key]
    return found


def as_table(summary: Sequence[dict[str, Any]]) -> str:
    """Return the medians as a table."""
    head = ("vessel", "spheres", "command s", "ratio", "arrange s", "ratio", "core density", "peak MB")
    keys = ("seconds", "seconds_ratio", "arrange", "arrange_ratio", "core_density", "peak_memory_MB")
    return output.table(
        head,
        [
            (row["vessel"], f"{row['spheres']:,.0f}", *(output.number(row[key]) for key in keys))
            for row in summary
        ],
    )


def plot(summary: Sequence[dict[str, Any]], path: Path, facts: dict[str, str]) -> None:
    """Draw the stages of each vessel's run one after the other."""
    figure = output.start_figure(9.0, 3.2)
    axes = figure.subplots()
    end = np.zeros(len(summary))
    rest = [row["seconds"] - sum(row[stage] for stage in STAGES) for row in summary]
    for stage, width in [("start", rest), *((stage, [row[stage] for row in summary]) for stage in STAGES)]:
        axes.barh([row["vessel"] for row in summary], width, left=end, label=stage)
        end += width
    axes.axvline(2.0 * summary[0]["seconds"], color=output.FAINT, linestyle="--")
    axes.invert_yaxis()
    axes.set_xlabel("time of the whole command [s]; dashed: twice the plain cylinder's")
    axes.set_title(f"{summary[0]['spheres']:,.0f} spheres in vessels of a form and of facets")
    axes.legend(frameon=False, ncols=4, loc="upper center", bbox_to_anchor=(0.5, -0.25))
    output.save_figure(figure, path, facts)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write the results, and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the results; made when missing")
    parser.add_argument("--facets", type=int, default=100_000, help="of each mesh, about (default 100,000)")
    parser.add_argument("--spheres", type=int, default=100_000, help="default 100,000")
    parser.add_argument("--repeats", type=int, default=3, help="rounds (default 3)")
    parser.add_argument("--seed", type=int, default=0, help="default 0")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed) | {"rounds": str(options.repeats)}
    rows = []
    with tempfile.TemporaryDirectory(prefix="packgen_") as name:
        folder = Path(name)
        scenes = {
            vessel: scene_of(container, options.spheres, options.seed)
            for vessel, container in vessels(folder, options.facets).items()
        }
        for scene in scenes.values():  # whatever is not compiled yet
            run(folder, "", {**scene, "zones": [{"n_particles": min(1000, options.spheres)}]})
        for number in range(options.repeats):
            for vessel, scene in scenes.items():
                rows.append({"round": number, **run(folder, vessel, scene)})
    summary = medians(rows)
    stem, text = options.out / "facets", as_table(summary)
    output.write_csv(stem.with_suffix(".csv"), rows, facts)
    notes = [
        "Medians over the rounds. Ratio: to the plain cylinder. Command: packgen SCENE --export liggghts."
    ]
    output.write_text(stem.with_suffix(".txt"), "What facets cost", facts, [text], notes)
    plot(summary, stem.with_suffix(".png"), facts)
    print(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
