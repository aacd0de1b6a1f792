"""Fig. 3: the objective of one batch of 500 spheres over the steps of adam, for five learning rates.

    python examples/studies/learning_rate.py

The paper gives neither box nor radius; here the base is 2 m wide and the radius 0.1 m, as in its density
experiment. Patience is 50 and the most steps are 10,000, as in the paper. The bed that projection makes of
500 such spheres has no steps to show: its value of the same objective is a line across.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import study
import torch
from study import columns

from packgen.arrange.adam.batch import AdamSettings, arrange_batch
from packgen.arrange.adam.objective import PlaneWalls, Weights, all_pairs_objective

NAME = "learning_rate"
WIDTH, RADIUS = 2.0, 0.1  # m
SPHERES, STEPS = 500, 10_000
POINTS = 150  # of a curve, evenly spread over the logarithm of the steps
SETTINGS = {
    f"{kind} {rate:g}": (rate, factor)
    for kind, factor in (("fixed", 1.0), ("scheduled", 0.1))
    for rate in ((1e-2, 1e-3, 1e-4) if kind == "fixed" else (1e-2, 1e-3))
}
COLOURS = dict(zip(SETTINGS, ("#dc2626", "#d97706", "#ca8a04", "#7c3aed", "#0891b2"), strict=True))
DOWN = torch.tensor([0.0, 0.0, -1.0], dtype=torch.float64)


def walls() -> PlaneWalls:
    """Return the six planes of the box, 2 m wide and high."""
    normal = np.concatenate([np.eye(3), -np.eye(3)])
    offset = np.repeat([WIDTH, 0.0], 3)
    return PlaneWalls(torch.from_numpy(normal), torch.from_numpy(offset))


def measure(options: argparse.Namespace) -> list[study.Row]:
    """Return points of each curve, with the time of the whole batch at its last point."""
    torch.set_num_threads(1)
    settings = AdamSettings(n_epoch=options.steps, patience=50)
    # The start of a batch in packgen: uniform, at a solid fraction of 0.3.
    radius = torch.full((options.spheres,), RADIUS, dtype=torch.float64)
    solid = options.spheres * columns.sphere_volume(RADIUS)
    thickness = solid / (settings.start_fraction * WIDTH**2)
    rng = np.random.default_rng(0)
    start = torch.from_numpy(rng.random((options.spheres, 3)) * [WIDTH, WIDTH, thickness])
    nothing = torch.empty((0, 3), dtype=torch.float64), torch.empty(0, dtype=torch.float64)
    study.warm_up(study.ADAM)
    rows = []
    for name, (rate, factor) in SETTINGS.items():
        chosen = replace(settings, lr=rate, plateau_factor=factor)
        taken: list[tuple[int, float, float]] = []
        begin = time.perf_counter()
        result = arrange_batch(
            start, radius, *nothing, walls(), DOWN, chosen,
            lambda *step, kept=taken: kept.append(step),
        )  # fmt: skip
        seconds = time.perf_counter() - begin
        shown = np.unique(np.geomspace(1, len(taken), POINTS).astype(int)) - 1
        rows += [
            {"setting": name, "step": step, "objective": round(value, 4), "rate": at}
            for step, value, at in (taken[index] for index in shown)
        ]
        rows[-1] |= {
            "best": round(result.objective, 4), "seconds": round(seconds, 3),
            "overlap_mean": float(f"{result.overlap_mean:.3g}"),
        }  # fmt: skip
        print(rows[-1], flush=True)
    return [*rows, projection(options.spheres)]


def projection(spheres: int) -> study.Row:
    """Return the objective of the bed that projection makes of as many spheres."""
    study.warm_up(study.PROJECTION)
    bed, seconds = columns.arrange(study.box_document(WIDTH, RADIUS, spheres, 0, {}))
    position, radius = torch.tensor(bed.position), torch.tensor(bed.radius)
    value = all_pairs_objective(position, radius, position[:0], radius[:0], walls(), DOWN, Weights()).value
    return {
        "setting": study.PROJECTION, "step": None, "best": round(float(value), 4),
        "seconds": round(seconds, 4), "overlap_mean": study.quality(bed)["overlap_mean"],
    }  # fmt: skip


def draw(rows: list[study.Row], facts: dict[str, str], path: Path) -> None:
    """Draw the objective over the steps, each curve with the time of its batch at its end."""
    drawing = study.figure(8.0, 4.2)
    axes: Any = drawing.subplots()
    for (name,), group in study.grouped(rows, "setting").items():
        last = group[-1]
        if name == study.PROJECTION:
            axes.axhline(
                last["best"], color=study.COLOURS[name], linestyle=(0, (4, 3)), linewidth=1.2,
                label=f"projection, {1e3 * last['seconds']:.0f} ms",
            )  # fmt: skip
            continue
        steps, values = [row["step"] for row in group], [row["objective"] for row in group]
        label = f"{name}, {last['seconds']:.1f} s"
        axes.plot(steps, values, color=COLOURS[name], linewidth=1.3, label=label)
        axes.plot(steps[-1:], values[-1:], "o", color=COLOURS[name], markersize=4)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("step")
    axes.set_ylabel("objective, eq. 5 [m]")
    axes.legend(fontsize=8, frameon=False)
    study.save(drawing, path, facts)


def main() -> None:
    """Read the command line, run, write."""
    parser = study.make_parser(__doc__)
    parser.add_argument("--spheres", type=int, default=SPHERES, help="spheres of the batch (default: 500)")
    parser.add_argument("--steps", type=int, default=STEPS, help="most steps (default: 10,000)")
    options = parser.parse_args()
    study.write(NAME, options, measure(options), draw)


if __name__ == "__main__":
    main()
