"""Cylinders of equal spheres: mean porosity and its radial waves, next to published correlations.

    python tests/benchmarks/porosity.py --out DIR [--ratios 5 10 20] [--beds 4] [--friction 0.2 0.5]

Cylinders D/d = 5, 10 and 20 wide are filled; what lies three diameters above the floor and below its top
is measured, spheres cut exactly by the cylindrical shells. Published: mean porosity by Zou and Yu (Powder
Technology 88, 1996, 71), loose and dense; local porosity by Mueller (1992) and de Klerk (2003), see
``packgen.measure.radial``. Where LIGGGHTS is installed, it pours as many spheres into the same cylinders,
with frictions that stand beside.

Writes porosity.csv (local porosity, shell by shell), porosity.txt (means, extrema) and porosity.png into DIR.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import machine
import numpy as np
import output
from columns import YOUNGS_MODULUS, arrange
from pour import liggghts_installed, pour

from packgen.arrays import Float64Array
from packgen.bed import Bed
from packgen.measure.fraction import bed_top
from packgen.measure.radial import de_klerk_porosity, mueller_porosity, solid_in_cylinders

STEP = 0.02  # diameters: thickness of the shells
SMOOTH = 0.06  # diameters: to both sides, what a parabola is fitted to at an extremum
MARGIN = 3.0  # diameters left out above the floor and below the top
SPHERES = 6000  # about so many in a bed
RADIUS = 0.01  # m
EXTREMA = ("first minimum", "first maximum", "second minimum")
NEAR = ((0.3, 0.75), (0.75, 1.25), (1.2, 1.7))  # diameters: where they are looked for


@dataclass(frozen=True, eq=False)
class Waves:
    """Local porosity of some beds of one D/d, and their mean porosity, bed by bed."""

    ratio: float
    wall_distance: Float64Array
    porosity: Float64Array
    mean: tuple[float, ...]
    bulk: float


def zou_yu(ratio: float) -> tuple[float, float]:
    """Return the mean porosity of dense and of loose packings of equal spheres in a cylinder."""
    return 0.372 + 0.002 * (np.exp(15.306 / ratio) - 1.0), 0.400 + 0.010 * (np.exp(10.686 / ratio) - 1.0)


def cylinder_bed(ratio: float, seed: int) -> Bed:
    """Return a bed in a cylinder ``ratio`` sphere diameters wide."""
    diameter = 2.0 * RADIUS
    height = max(SPHERES / (0.88 * ratio**2), 4.0 * MARGIN) * diameter
    document = {
        "container": {"cylinder": {"radius": 0.5 * ratio * diameter, "height": height}},
        "seed": seed,
        "particle_sets": [{"radius_distribution": "constant", "radius": RADIUS}],
    }
    return arrange(document)[0]


def poured_bed(ratio: float, seed: int, friction: float) -> tuple[Float64Array, Float64Array]:
    """Return centres [m] and radii [m] of a bed that LIGGGHTS poured into the same cylinder."""
    poured = pour(
        SPHERES,
        width=2.0 * ratio * RADIUS,
        radius=RADIUS,
        youngs_modulus=YOUNGS_MODULUS,
        seed=seed,
        friction=friction,
        cylinder=True,
    )
    return poured.position, poured.radius


def mean_porosity(ratio: float, position: Float64Array, radius: Float64Array) -> float:
    """Return the porosity of a bed without its ends, three diameters at either."""
    low = MARGIN * 2.0 * RADIUS
    high = bed_top(position[:, 2], radius) - low
    width = np.array([ratio * RADIUS])
    solid = solid_in_cylinders(position, radius, np.zeros(3), np.array([0.0, 0.0, 1.0]), width, (low, high))
    return float(1.0 - solid[0] / (np.pi * width[0] ** 2 * (high - low)))


def measured(ratio: float, seeds: Sequence[int]) -> Waves:
    """Return the porosity of beds of one D/d."""
    diameter, width = 2.0 * RADIUS, ratio * RADIUS  # the cylinder's radius is D/2
    bounds = np.arange(0.0, 0.5 * ratio, STEP)
    bounds = np.append(bounds, 0.5 * ratio)
    cylinder = np.maximum(width - bounds * diameter, 0.0)
    solid, space, mean = np.zeros(len(bounds) - 1), np.zeros(len(bounds) - 1), []
    for seed in seeds:
        bed = cylinder_bed(ratio, seed)
        low = MARGIN * diameter
        high = bed_top(bed.position[:, 2], bed.radius) - low
        within = solid_in_cylinders(
            bed.position, bed.radius, np.zeros(3), np.array([0.0, 0.0, 1.0]), cylinder, (low, high)
        )
        volume = np.pi * cylinder**2 * (high - low)
        solid -= np.diff(within)
        space -= np.diff(volume)
        mean.append(float(1.0 - within[0] / volume[0]))
    middle = 0.5 * (bounds[1:] + bounds[:-1])
    deep = middle > min(2.5, 0.25 * ratio)
    bulk = float(1.0 - solid[deep].sum() / space[deep].sum())
    return Waves(ratio, middle, 1.0 - solid / space, tuple(mean), bulk)


def extrema(wall_distance: Float64Array, porosity: Float64Array) -> list[tuple[float, float]]:
    """Return place [diameters] and porosity of the first three extrema, by parabolas."""
    found = []
    for number, (low, high) in enumerate(NEAR):
        sign = -1.0 if number == 1 else 1.0
        near = np.flatnonzero((wall_distance > low) & (wall_distance < high))
        # A running mean first: a single shell is noise.
        smooth = np.convolve(porosity, np.ones(5) / 5.0, mode="same")
        at = wall_distance[near[np.argmin(sign * smooth[near])]]
        fit = np.abs(wall_distance - at) <= SMOOTH + 1e-9
        second, first, zeroth = np.polyfit(wall_distance[fit] - at, porosity[fit], 2)
        offset = float(np.clip(-first / (2.0 * second), -SMOOTH, SMOOTH))
        found.append((float(at + offset), float(zeroth + first * offset + second * offset**2)))
    return found


def published(waves: Waves) -> dict[str, Float64Array]:
    """Return the correlations at the same places."""
    return {
        "Mueller": mueller_porosity(waves.wall_distance, waves.ratio),
        "de Klerk": de_klerk_porosity(waves.wall_distance, waves.bulk),
    }


def mean_rows(all_waves: Sequence[Waves], poured: Sequence[Sequence[float]]) -> list[list[str]]:
    """Return a row a D/d: mean porosity, the correlations', and those of LIGGGHTS' beds."""
    rows = []
    for waves, beds in zip(all_waves, poured, strict=True):
        dense, loose = zou_yu(waves.ratio)
        mean = float(np.mean(waves.mean))
        spread = float(np.ptp(waves.mean))
        verdict = "yes" if dense <= mean <= loose else "no"
        rows.append(
            [f"{waves.ratio:g}", f"{mean:.4f}", f"{spread:.4f}", f"{dense:.4f}", f"{loose:.4f}", verdict]
            + [f"{each:.4f}" for each in beds]
        )
    return rows


def extremum_rows(all_waves: Sequence[Waves]) -> list[list[str]]:
    """Return a row an extremum: where it is and how deep, and by how much the correlations differ."""
    rows = []
    for waves in all_waves:
        here = extrema(waves.wall_distance, waves.porosity)
        there = {name: extrema(waves.wall_distance, curve) for name, curve in published(waves).items()}
        for number, name in enumerate(EXTREMA):
            place, depth = here[number]
            row = [f"{waves.ratio:g} {name}", f"{place:.3f}", f"{depth:.3f}"]
            for other in there.values():
                row += [f"{place - other[number][0]:+.3f}", f"{depth - other[number][1]:+.3f}"]
            rows.append(row)
    return rows


def plot(all_waves: Sequence[Waves], path: Path, facts: dict[str, str]) -> None:
    """Draw local porosity over the distance from the wall, a panel a D/d."""
    figure = output.start_figure(4.0 * len(all_waves), 3.8)
    panels = figure.subplots(1, len(all_waves), sharey=True, squeeze=False)[0]
    for panel, waves in zip(panels, all_waves, strict=True):
        shown = waves.wall_distance < min(4.0, 0.5 * waves.ratio - 0.2)
        place = waves.wall_distance[shown]
        panel.plot(place, waves.porosity[shown], color=output.INK, label="packgen")
        for (name, curve), style in zip(published(waves).items(), ("--", ":"), strict=True):
            panel.plot(place, curve[shown], style, color="#b04a2f", label=name)
        panel.set_title(f"D/d = {waves.ratio:g}, mean porosity {np.mean(waves.mean):.3f}")
        panel.set_xlabel("distance from the wall [d]")
        panel.set_ylim(0.0, 1.0)
    panels[0].set_ylabel("local porosity")
    panels[0].legend(frameon=False)
    output.save_figure(figure, path, facts)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--ratios", type=float, nargs="+", default=[5.0, 10.0, 20.0])
    parser.add_argument("--beds", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--friction", type=float, nargs="*", default=[0.2, 0.5], help="of LIGGGHTS' beds")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    seeds = range(options.seed, options.seed + options.beds)
    all_waves = [measured(ratio, seeds) for ratio in options.ratios]
    rows = [
        {
            "ratio": f"{waves.ratio:g}", "wall_distance": f"{place:.4f}", "porosity": f"{porosity:.5f}",
            "mueller": f"{curves['Mueller'][index]:.5f}", "de_klerk": f"{curves['de Klerk'][index]:.5f}",
        }
        for waves in all_waves
        for curves in (published(waves),)
        for index, (place, porosity) in enumerate(zip(waves.wall_distance, waves.porosity, strict=True))
    ]  # fmt: skip
    output.write_csv(options.out / "porosity.csv", rows, facts)
    frictions = options.friction if liggghts_installed() else []
    poured = [
        [mean_porosity(ratio, *poured_bed(ratio, options.seed, friction)) for friction in frictions]
        for ratio in options.ratios
    ]
    means = output.table(
        (
            "D/d", "mean", "spread", "Zou-Yu dense", "Zou-Yu loose", "between",
            *(f"LIGGGHTS, {friction:g}" for friction in frictions),
        ),
        mean_rows(all_waves, poured),
    )  # fmt: skip
    waves_table = output.table(
        ("D/d, extremum", "place [d]", "porosity", "less Mueller", "", "less de Klerk", ""),
        extremum_rows(all_waves),
    )
    notes = [
        "LIGGGHTS: one bed each, poured with that friction between spheres and at walls, E = 1e8 Pa.",
        f"{options.beds} beds of each D/d. Differences: place in diameters, then porosity. The correlations",
        "differ from each other by up to 0.1 in porosity in the first layer.",
    ]
    output.write_text(
        options.out / "porosity.txt",
        "Porosity of cylinders of equal spheres",
        facts,
        [means, waves_table],
        notes,
    )
    plot(all_waves, options.out / "porosity.png", facts)
    print(means, waves_table, sep="\n\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
