"""Figs. 9 and 10: the paper's cone with a sphere zone below and a slice above it, by both optimisers.

    python examples/studies/cone.py

The scene is examples/cone.yaml, the paper's Fig. 9 word for word. The two surfaces are not part of the
paper; examples/shells.py makes them so that the spheres of the upper zone rest on those of the lower. For
adam the first zone is the sphere itself, not its mesh: one wall in place of two thousand facets, each looked
at in every step.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import study

from packgen.scene import LocationSpec, Scene, SphereSpec, load_scene

sys.path.append(str(study.EXAMPLES))

import shells

NAME = "cone"
SCENE = study.EXAMPLES / "cone.yaml"
METHODS = (study.ADAM, study.PROJECTION)


def scene_of(method: str, seed: int, share: float) -> Scene:
    """Return the scene, with a share of its spheres, as a method packs it."""
    scene = replace(load_scene(SCENE), seed=seed)
    counts = [round(share * (zone.n_particles or 0)) for zone in scene.zones]
    zones = [each.model_copy(update={"n_particles": n}) for each, n in zip(scene.zones, counts, strict=True)]
    scene = replace(scene, zones=tuple(zones))
    if method != study.ADAM:
        return scene
    ball = LocationSpec(
        sphere=SphereSpec(radius=shells.SPHERE_RADIUS, center=(0.0, 0.0, shells.SPHERE_HEIGHT))
    )
    first = scene.zones[0].model_copy(update={"location": ball})
    return replace(scene, zones=(first, *scene.zones[1:]))


def measure(options: argparse.Namespace) -> list[study.Row]:
    """Return a row for each method, seed and zone, and keep the bed of each method's first seed."""
    rows = []
    for method in METHODS:
        study.warm_up(method)
        for seed in study.seeds_of(options):
            bed, asked, seconds = study.pack_scene(scene_of(method, seed, options.share), optimizer=method)
            options.beds.setdefault(method, bed)
            for zone, wanted in enumerate(asked):
                inside = bed.zone_index == zone
                height = bed.position[inside, 2]
                rows.append(
                    {
                        "method": method, "seed": seed, "zone": zone, "asked": wanted,
                        "placed": int(inside.sum()), "lowest_centre": round(float(height.min()), 4),
                        "highest_centre": round(float(height.max()), 4), "seconds": round(seconds, 4),
                        "overlap_max": study.quality(bed)["overlap_max"],
                    }
                )  # fmt: skip
                print(rows[-1], flush=True)
    return rows


def main() -> None:
    """Read the command line, run, write."""
    parser = study.make_parser(__doc__)
    study.seeds_option(parser, 2)
    parser.add_argument("--share", type=float, default=1.0, help="of the scene's spheres (default: all)")
    options = parser.parse_args()
    options.beds = {}

    def draw(rows: list[study.Row], facts: dict[str, str], path: Path) -> None:
        drawing = study.figure(6.4, 3.9)
        for axes, method in zip(drawing.subplots(1, len(METHODS)), METHODS, strict=True):
            study.show(axes, options.beds[method], half=False)
            placed = sum(row["placed"] for row in rows if row["method"] == method and row["seed"] == 0)
            axes.set_title(f"{method}: {placed:.0f} spheres")
        study.save(drawing, path, facts)

    study.write(NAME, options, measure(options), draw)


if __name__ == "__main__":
    main()
