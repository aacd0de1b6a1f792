"""Fig. 11: the shaft furnace, 32 m high and 6.5 m wide, with 430,062 pellets of 52 to 75 mm.

    python examples/studies/furnace.py [--full]

The scene is examples/furnace.yaml. The paper gives height, largest diameter, number and radii; the profile of
the shaft is that of examples/shells.py. Projection packs all of it. Adam packs the first pellets only, for
the time of one; ``--full`` packs all of it with adam too, for as long as that takes.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import study

from packgen.scene import load_scene

NAME = "furnace"
SCENE = study.EXAMPLES / "furnace.yaml"
ADAM_SPHERES = 1000


def measure(options: argparse.Namespace) -> list[study.Row]:
    """Return a row for each method, and keep the bed that projection makes."""
    rows = []
    some = {study.ADAM: None if options.full else ADAM_SPHERES, study.PROJECTION: None}
    for method, usual in some.items():
        study.warm_up(method)
        scene = load_scene(SCENE)
        spheres = options.spheres or usual
        if spheres is not None:
            scene = replace(scene, zones=(scene.zones[0].model_copy(update={"n_particles": spheres}),))
        bed, asked, seconds = study.pack_scene(scene, optimizer=method)
        options.bed = bed
        rows.append(
            {
                "method": method, "asked": asked[0], "spheres": bed.count, "seconds": round(seconds, 3),
                "ms_a_sphere": round(1e3 * seconds / bed.count, 5), **study.quality(bed),
            }
        )  # fmt: skip
        print(rows[-1], flush=True)
    return rows


def main() -> None:
    """Read the command line, run, write."""
    parser = study.make_parser(__doc__)
    parser.add_argument("--spheres", type=int, help="pellets of both methods (default: 1,000 and 430,062)")
    options = parser.parse_args()

    def draw(rows: list[study.Row], facts: dict[str, str], path: Path) -> None:
        drawing = study.figure(6.4, 5.4)
        axes: Any = drawing.subplots()
        study.show(axes, options.bed, half=True)
        axes.set_title(f"{rows[-1]['spheres']:,.0f} pellets", fontsize=9)
        study.save(drawing, path, facts)

    study.write(NAME, options, measure(options), draw)


if __name__ == "__main__":
    main()
