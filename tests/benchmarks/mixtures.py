"""How beds of several sizes are mixed and how densely they pack, against beds that LIGGGHTS poured.

    python tests/benchmarks/mixtures.py --out DIR [--depth 14] [--poured 1] [--seed 0]

Columns on a square base 14 large radii wide: equal spheres, two sizes, and a lognormal law in eight classes.
Each is arranged by packgen and, so often as ``--poured`` says, inserted at random and settled by LIGGGHTS at
the same friction. Both beds are judged by the same code:

- core: solid fraction at least two large radii away from walls, floor and top
- model: solid fraction as far below random close packing, in proportion, as equal spheres in the first row
- large: share of the larger half of the sizes in the solid of four slabs of the core, lowest and highest
- none: share of the spheres without a contact (gap of 5 % of the mean diameter)

Writes mixtures.csv (every bed), mixtures.txt and mixtures.png into DIR.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import mean
from typing import Any

import machine
import numpy as np
import output
from columns import arrange, bed_of, column_document, sphere_volume
from pour import liggghts_installed, pour

from packgen.bed import Bed
from packgen.measure import box_fraction, contacts
from packgen.measure.fraction import bed_top
from packgen.supply.close_packing import EQUAL_SPHERES, close_packing_fraction

LARGE = 0.006  # m
ACROSS = 14.0  # large radii
MARGIN = 2.0  # large radii
FRACTION, CORE = 0.58, 0.6  # of equal spheres, with their walls and without
SLABS = 4
YOUNGS_MODULUS = 1.0e7  # Pa
SIGMA, CLASSES = 0.5, 8


@dataclass(frozen=True, slots=True)
class Mixture:
    """Sizes of a bed: radii [m], the largest first, and the share of the mass that each has."""

    name: str
    radius: tuple[float, ...]
    share: tuple[float, ...]

    @property
    def radius_mean(self) -> float:
        """Radius of a sphere of mean volume [m]."""
        radius = np.array(self.radius)
        return float(np.cbrt(1.0 / np.sum(np.array(self.share) / radius**3)))

    @property
    def close_packing(self) -> float:
        """Solid fraction of a random close packing of these sizes."""
        radius = np.array(self.radius)
        return close_packing_fraction(radius, np.array(self.share) / radius**3)

    def count(self, depth: float) -> int:
        """Return how many spheres make a bed of some depth [large radii]."""
        fraction = FRACTION * self.close_packing / EQUAL_SPHERES
        return round(fraction * ACROSS**2 * depth * LARGE**3 / sphere_volume(self.radius_mean))

    @property
    def edge(self) -> float:
        """Radius above which a sphere is one of the large ones [m]."""
        return float(np.sqrt(self.radius[0] * self.radius[-1]))

    @property
    def share_large(self) -> float:
        """Share of the mass of the large ones."""
        return sum(
            share for radius, share in zip(self.radius, self.share, strict=True) if radius >= self.edge
        )


def mixtures() -> list[Mixture]:
    """Return the mixtures, equal spheres first."""
    found = [Mixture("equal", (LARGE,), (1.0,))]
    for ratio, fine in ((2.0, 0.3), (3.0, 0.3), (3.0, 0.5), (5.0, 0.3)):
        found.append(Mixture(f"1:{ratio:g}, {fine:.0%} small", (LARGE, LARGE / ratio), (1.0 - fine, fine)))
    level = np.linspace(2.0, -2.0, CLASSES)
    share = np.exp(-0.5 * level**2)
    radius, share = LARGE * np.exp(SIGMA * (level - level[0])), share / share.sum()
    return [*found, Mixture(f"lognormal, sigma {SIGMA:g}", tuple(radius.tolist()), tuple(share.tolist()))]


def arranged_bed(mixture: Mixture, spheres: int, seed: int) -> tuple[Bed, float]:
    """Return packgen's bed and what it took [s]."""
    sizes = {
        "radius_distribution": "discrete",
        "radii": list(mixture.radius),
        "fractions": list(mixture.share),
        "by": "mass",
    }
    radius = mixture.radius_mean
    document = column_document(spheres, seed=seed, width=ACROSS * LARGE, radius=radius, sizes=sizes)
    document["container"]["box"]["max"][2] += 4.0 * LARGE
    return arrange(document)


def poured_bed(mixture: Mixture, spheres: int, seed: int) -> tuple[Bed, float]:
    """Return LIGGGHTS' bed and what it took [s]."""
    sizes = tuple(zip(mixture.radius, mixture.share, strict=True))
    width = ACROSS * LARGE
    poured = pour(
        spheres,
        width=width,
        radius=mixture.radius_mean,
        youngs_modulus=YOUNGS_MODULUS,
        seed=seed,
        sizes=sizes,
    )
    return bed_of(poured.position, poured.radius, width=width, height=poured.height), poured.seconds


def measured(mixture: Mixture, bed: Bed) -> dict[str, Any]:
    """Return the figures of a bed."""
    margin = MARGIN * LARGE
    top = bed_top(bed.position[:, 2], bed.radius) - margin
    low, high = np.full(3, margin), np.array([ACROSS * LARGE - margin] * 2 + [top])
    bottom = bed.position[:, 2] - bed.radius
    deep = np.clip(np.linspace(margin, top, SLABS + 1)[:, None] - bottom, 0.0, 2.0 * bed.radius)
    solid = np.diff(np.pi / 3.0 * deep**2 * (3.0 * bed.radius - deep), axis=0)
    large = solid[:, bed.radius >= mixture.edge].sum(axis=1) / solid.sum(axis=1)
    return {
        "spheres": bed.count, "core": box_fraction(bed, low, high), "large_lowest": float(large.min()),
        "large_highest": float(large.max()), "no_contact": contacts(bed)[-1].none,
    }  # fmt: skip


def runs(options: argparse.Namespace) -> list[dict[str, Any]]:
    """Return a row a bed."""
    rows = []
    arrange(column_document(500, seed=0))  # whatever is not compiled yet
    for mixture in (each for each in mixtures() if each.name in options.sizes):
        spheres = mixture.count(options.depth)
        for by, made, beds in (
            ("packgen", arranged_bed, options.beds),
            ("LIGGGHTS", poured_bed, options.poured),
        ):
            for seed in range(options.seed, options.seed + beds):
                bed, seconds = made(mixture, spheres, seed)
                figures = measured(mixture, bed) | {"seconds": seconds}
                rows.append({"sizes": mixture.name, "by": by, "seed": seed} | figures)
    return rows


def of(rows: Sequence[dict[str, Any]], mixture: Mixture, by: str, key: str) -> list[float]:
    """Return one figure of all beds of a mixture."""
    return [row[key] for row in rows if row["sizes"] == mixture.name and row["by"] == by]


def model(rows: Sequence[dict[str, Any]], mixture: Mixture, by: str) -> float:
    """Return the solid fraction of a mixture as close to random close packing as equal spheres are."""
    alone = mean(of(rows, mixtures()[0], by, "core") or [CORE])
    return alone * mixture.close_packing / EQUAL_SPHERES


def as_table(rows: Sequence[dict[str, Any]]) -> str:
    """Return the means over the beds as a table."""
    lines = []
    for mixture in mixtures():
        for by in ("packgen", "LIGGGHTS"):
            if not of(rows, mixture, by, "core"):
                continue
            middle = {key: mean(of(rows, mixture, by, key)) for key in ("core", "no_contact", "seconds")}
            lowest, highest = (
                min(of(rows, mixture, by, "large_lowest")),
                max(of(rows, mixture, by, "large_highest")),
            )
            lines.append(
                (
                    f"{mixture.name}, {by}", f"{middle['core']:.3f}", f"{model(rows, mixture, by):.3f}",
                    f"{mixture.share_large:.2f}", f"{lowest:.2f} to {highest:.2f}",
                    f"{middle['no_contact']:.1%}", output.number(middle["seconds"]),
                )
            )  # fmt: skip
    return output.table(("sizes", "core", "model", "large", "in slabs", "none", "s"), lines)


def plot(rows: Sequence[dict[str, Any]], path: Path, facts: dict[str, str]) -> None:
    """Draw the core densities beside each other."""
    figure = output.start_figure(8.0, 3.6)
    axes = figure.subplots()
    names = [mixture.name for mixture in mixtures()]
    for by, marker, colour in (("packgen", "o", output.INK), ("LIGGGHTS", "x", "#c0504d")):
        shown = [row for row in rows if row["by"] == by]
        axes.plot(
            [names.index(row["sizes"]) for row in shown],
            [row["core"] for row in shown],
            marker,
            color=colour,
            label=by,
        )
    axes.plot(
        range(len(names)),
        [model(rows, each, "packgen") for each in mixtures()],
        "_",
        markersize=24,
        color=output.FAINT,
        label="by random close packing",
    )
    axes.set_xticks(range(len(names)), names, rotation=15, ha="right")
    axes.set_ylabel("solid fraction of the core")
    axes.set_title("Beds of several sizes, arranged and poured")
    axes.legend(frameon=False)
    output.save_figure(figure, path, facts)


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure, write the results, and print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True, help="folder for the results; made when missing")
    parser.add_argument("--depth", type=float, default=14.0, help="of a bed, in large radii (default 14)")
    parser.add_argument("--beds", type=int, default=3, help="of packgen for each mixture (default 3)")
    parser.add_argument("--poured", type=int, default=1, help="of LIGGGHTS for each mixture (default 1)")
    names = [each.name for each in mixtures()]
    parser.add_argument("--sizes", nargs="+", choices=names, default=names, help="default: all of them")
    parser.add_argument("--seed", type=int, default=0, help="first seed (default 0)")
    options = parser.parse_args(arguments)
    if options.poured and not liggghts_installed():
        parser.error("--poured: found no liggghts; install Debian's package of that name, or say --poured 0")
    options.out.mkdir(parents=True, exist_ok=True)
    facts = machine.facts(options.seed) | {"depth": f"{options.depth:g} large radii"}
    rows = runs(options)
    stem, text = options.out / "mixtures", as_table(rows)
    output.write_csv(stem.with_suffix(".csv"), rows, facts)
    notes = [
        "Means over the beds; slabs: lowest and highest of all. The columns are those of the script's head."
    ]
    output.write_text(stem.with_suffix(".txt"), "Beds of several sizes", facts, [text], notes)
    plot(rows, stem.with_suffix(".png"), facts)
    print(text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
