"""Cylinders of equal spheres: mean porosity and its radial waves, next to published correlations.

    python tests/benchmarks/porosity.py --out DIR [--ratios 5 10 20] [--beds 4] [--friction 0.1 0.5]

Cylinders D/d = 5, 10 and 20 wide are filled; what lies three diameters above the floor and below its top
is measured, spheres cut exactly by the cylindrical shells. Published: mean porosity by Zou and Yu (Powder
Technology 88, 1996, 71), loose and dense; local porosity by Mueller (1992) and de Klerk (2003), see
``packgen.measure.radial``. Where LIGGGHTS is installed, it pours as many spheres of the same friction, walls
alike, into the same cylinders.

Writes porosity.csv (local porosity, shell by shell), porosity.txt (means, extrema) and porosity.png into DIR.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import machine
import numpy as np
import output
from columns import YOUNGS_MODULUS, arrange
from pour import liggghts_installed, pour

from packgen.arrays import Float64Array
from packgen.measure.fraction import bed_top
from packgen.measure.radial import de_klerk_porosity, mueller_porosity, solid_in_cylinders

STEP = 0.02  # diameters: thickness of the shells
SMOOTH = 0.06  # diameters: to both sides, what a parabola is fitted to at an extremum
MARGIN = 3.0  # diameters left out above the floor and below the top
SPHERES = 6000  # about so many in a bed
RADIUS = 0.01  # m
EXTREMA = ("first minimum", "first maximum", "second minimum")
MEANS = ("friction", "D/d", "mean", "spread", "Zou-Yu dense", "Zou-Yu loose", "between", "bulk", "de Klerk")
NEAR = ((0.3, 0.75), (0.75, 1.25), (1.2, 1.7))  # diameters: where they are looked for


Positions = tuple[Float64Array, Float64Array]  # centres [m], shape (N, 3), and radii [m], shape (N,)


@dataclass(frozen=True, eq=False)
class Waves:
    """Local porosity of some beds of one D/d and one friction, and their mean porosity, bed by bed."""

    ratio: float
    friction: float
    wall_distance: Float64Array
    porosity: Float64Array
    mean: tuple[float, ...]
    bulk: float


def zou_yu(ratio: float) -> tuple[float, float]:
    """Return the mean porosity of dense and of loose packings of equal spheres in a cylinder."""
    return 0.372 + 0.002 * (np.exp(15.306 / ratio) - 1.0), 0.400 + 0.010 * (np.exp(10.686 / ratio) - 1.0)


def arranged_bed(ratio: float, friction: float, seed: int) -> Positions:
    """Return packgen's bed in a cylinder ``ratio`` sphere diameters wide."""
    diameter = 2.0 * RADIUS
    height = max(SPHERES / (0.88 * ratio**2), 4.0 * MARGIN) * diameter
    document = {
        "container": {"cylinder": {"radius": 0.5 * ratio * diameter, "height": height}},
        "seed": seed,
        "particle_sets": [{"radius_distribution": "constant", "radius": RADIUS}],
        "materials": {"ball": {"friction": friction}},
    }
    bed, _ = arrange(document)
    return bed.position, bed.radius


def poured_bed(ratio: float, friction: float, seed: int) -> Positions:
    """Return a bed that LIGGGHTS poured into the same cylinder."""
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


def measured(ratio: float, friction: float, beds: Iterable[Positions]) -> Waves:
    """Return the porosity of beds of one D/d, without their ends, three diameters at either."""
    diameter, width = 2.0 * RADIUS, ratio * RADIUS  # the cylinder's radius is D/2
    bounds = np.append(np.arange(0.0, 0.5 * ratio, STEP), 0.5 * ratio)
    cylinder = np.maximum(width - bounds * diameter, 0.0)
    solid, space, mean = np.zeros(len(bounds) - 1), np.zeros(len(bounds) - 1), []
    for position, radius in beds:
        low = MARGIN * diameter
        high = bed_top(position[:, 2], radius) - low
        within = solid_in_cylinders(
            position, radius, np.zeros(3), np.array([0.0, 0.0, 1.0]), cylinder, (low, high)
        )
        volume = np.pi * cylinder**2 * (high - low)
        solid -= np.diff(within)
        space -= np.diff(volume)
        mean.append(float(1.0 - within[0] / volume[0]))
    middle = 0.5 * (bounds[1:] + bounds[:-1])
    deep = middle > min(2.5, 0.25 * ratio)
    bulk = float(1.0 - solid[deep].sum() / space[deep].sum())
    return Waves(ratio, friction, middle, 1.0 - solid / space, tuple(mean), bulk)


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


def mean_of(waves: Waves, local: Float64Array) -> float:
    """Return the mean over the cylinder of a local porosity, given shell by shell as in ``waves``."""
    area = 0.5 * waves.ratio - waves.wall_distance
    return float((area * local).sum() / area.sum())


def mean_rows(arranged: Sequence[Waves], poured: Sequence[Waves]) -> list[list[str]]:
    """Return a row a D/d and friction: mean porosity, the correlations', and that of LIGGGHTS' beds."""
    rows = []
    for index, waves in enumerate(arranged):
        dense, loose = zou_yu(waves.ratio)
        mean = float(np.mean(waves.mean))
        verdict = "yes" if dense <= mean <= loose else "no"
        row = [f"{waves.friction:g}", f"{waves.ratio:g}", f"{mean:.4f}", f"{np.ptp(waves.mean):.4f}"]
        row += [f"{dense:.4f}", f"{loose:.4f}", verdict]
        row += [f"{waves.bulk:.4f}", f"{mean_of(waves, published(waves)['de Klerk']):.4f}"]
        rows.append(row + ([f"{np.mean(poured[index].mean):.4f}"] if poured else []))
    return rows


def extremum_rows(arranged: Sequence[Waves], poured: Sequence[Waves]) -> list[list[str]]:
    """Return a row an extremum: place, depth, and what correlations and LIGGGHTS' beds are off by."""
    rows = []
    for index, waves in enumerate(arranged):
        here = extrema(waves.wall_distance, waves.porosity)
        there = [extrema(waves.wall_distance, curve) for curve in published(waves).values()]
        there += [extrema(each.wall_distance, each.porosity) for each in poured[index : index + 1]]
        for number, name in enumerate(EXTREMA):
            place, depth = here[number]
            row = [f"{waves.friction:g}", f"{waves.ratio:g} {name}", f"{place:.3f}", f"{depth:.3f}"]
            for other in there:
                row += [f"{place - other[number][0]:+.3f}", f"{depth - other[number][1]:+.3f}"]
            rows.append(row)
    return rows


def plot(arranged: Sequence[Waves], poured: Sequence[Waves], path: Path, facts: dict[str, str]) -> None:
    """Draw local porosity over the distance from the wall: a row of panels a friction, a column a D/d."""
    across = len({waves.ratio for waves in arranged})
    down = len(arranged) // across
    figure = output.start_figure(4.0 * across, 3.4 * down)
    panels = figure.subplots(down, across, sharey=True, squeeze=False)
    for index, (panel, waves) in enumerate(zip(panels.flat, arranged, strict=True)):
        shown = waves.wall_distance < min(4.0, 0.5 * waves.ratio - 0.2)
        place = waves.wall_distance[shown]
        panel.plot(place, waves.porosity[shown], color=output.INK, label="packgen")
        for each in poured[index : index + 1]:
            panel.plot(place, each.porosity[shown], color="#3b7ea1", linewidth=0.9, label="LIGGGHTS, poured")
        for (name, curve), style in zip(published(waves).items(), ("--", ":"), strict=True):
            panel.plot(place, curve[shown], style, color="#b04a2f", label=name)
        panel.set_title(f"friction {waves.friction:g}, D/d = {waves.ratio:g}, mean {np.mean(waves.mean):.3f}")
        panel.set_ylim(0.0, 1.0)
    for panel in panels[-1]:
        panel.set_xlabel("distance from the wall [d]")
    for panel in panels[:, 0]:
        panel.set_ylabel("local porosity")
    panels[0, 0].legend(frameon=False)
    output.save_figure(figure, path, facts)


def csv_rows(waves: Waves, made_by: str) -> list[dict[str, str]]:
    """Return a row a shell."""
    curves = published(waves)
    return [
        {
            "made_by": made_by, "friction": f"{waves.friction:g}", "ratio": f"{waves.ratio:g}",
            "wall_distance": f"{place:.4f}", "porosity": f"{porosity:.5f}",
            "mueller": f"{curves['Mueller'][index]:.5f}", "de_klerk": f"{curves['de Klerk'][index]:.5f}",
        }
        for index, (place, porosity) in enumerate(zip(waves.wall_distance, waves.porosity, strict=True))
    ]  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--ratios", type=float, nargs="+", default=[5.0, 10.0, 20.0])
    parser.add_argument("--beds", type=int, default=4)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--friction", type=float, nargs="+", default=[0.1, 0.5])
    parser.add_argument("--poured", type=int, default=2, help="beds poured by LIGGGHTS (default 2)")
    options = parser.parse_args(arguments)
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed)
    cases = [(ratio, friction) for friction in options.friction for ratio in options.ratios]

    def of(make: Callable[[float, float, int], Positions], beds: int) -> list[Waves]:
        seeds = range(options.seed, options.seed + beds)
        return [measured(*case, (make(*case, seed) for seed in seeds)) for case in cases]

    arranged = of(arranged_bed, options.beds)
    poured = of(poured_bed, options.poured) if options.poured and liggghts_installed() else []
    rows = [row for waves in arranged for row in csv_rows(waves, "packgen")]
    rows += [row for waves in poured for row in csv_rows(waves, "LIGGGHTS")]
    output.write_csv(options.out / "porosity.csv", rows, facts)
    beside = ("LIGGGHTS",) if poured else ()
    means = output.table(
        (*MEANS, *beside),
        mean_rows(arranged, poured),
    )
    less = [column for name in ("Mueller", "de Klerk", *beside) for column in (f"less {name}", "")]
    waves_table = output.table(
        ("friction", "D/d, extremum", "place [d]", "porosity", *less), extremum_rows(arranged, poured)
    )
    by_liggghts = options.poured if poured else 0
    notes = [
        f"{options.beds} beds of each; LIGGGHTS: {by_liggghts}, E = 1e8 Pa, walls of the same friction.",
        "Differences: place in diameters, then porosity. The correlations differ from each other by up",
        "to 0.1 in porosity in the first layer, and know nothing of friction. De Klerk: the mean of his",
        "curve at the bed's bulk porosity. It is at most that of Zou and Yu's loose packings where the bulk",
        "porosity is at most 0.396, 0.361 and 0.377 at D/d = 5, 10 and 20; random close packing has 0.36.",
    ]
    title = "Porosity of cylinders of equal spheres"
    output.write_text(options.out / "porosity.txt", title, facts, [means, waves_table], notes)
    plot(arranged, poured, options.out / "porosity.png", facts)
    print(means, waves_table, sep="\n\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
