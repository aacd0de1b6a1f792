"""Random laws of sizes as the judge knows them: their bounds, and how many spheres are below a radius."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

Array = NDArray[np.float64]
POINTS = 4001
CUT = 4.0  # standard deviations that laws without bounds reach


@dataclass(frozen=True)
class Law:
    """A law of sizes.

    Attributes:
        spec: Its keys in the scene.
        low: Smallest radius [m].
        high: Largest radius [m].
        radius: Radii [m] in rising order, shape (K,): all that the law has, or points of its curve.
        number: Share of the spheres up to each radius, shape (K,).
        stepped: Whether there are no radii but those.
        listed: Whether each radius is that of one sphere of a file.
    """

    spec: dict[str, Any]
    low: float
    high: float
    radius: Array
    number: Array
    stepped: bool = False
    listed: bool = False

    @property
    def mean_volume(self) -> float:
        """Mean volume of a sphere [m3]."""
        share = np.diff(self.number, prepend=0.0)
        cube = self.radius**3
        if not self.stepped:  # between two points of the curve
            cube = np.concatenate([cube[:1], 0.5 * (cube[1:] + cube[:-1])])
        return float(4.0 / 3.0 * np.pi * (share @ cube))


def curve(spec: dict[str, Any], low: float, high: float, below: Callable[[Array], Array]) -> Law:
    """Return the law of which ``below`` spheres, up to a factor, are below each radius."""
    radius = np.linspace(low, high, POINTS) if high < 3.0 * low else np.geomspace(low, high, POINTS)
    count = below(radius)
    return Law(spec, low, high, radius, (count - count[0]) / (count[-1] - count[0]))


def of_mass(spec: dict[str, Any], low: float, high: float, mass_below: Callable[[Array], Array]) -> Law:
    """Return the law of which so much mass is below each radius, which weighs spheres by their cubes."""
    radius = np.geomspace(low, high, POINTS)
    middle = np.sqrt(radius[1:] * radius[:-1])
    count = np.concatenate([[0.0], np.cumsum(np.diff(mass_below(radius)) / (middle / high) ** 3)])
    return Law(spec, low, high, radius, count / count[-1])


def stepped(spec: dict[str, Any], radius: Any, number: Any, *, listed: bool = False) -> Law:
    """Return a law of single radii with so many spheres each."""
    order = np.argsort(radius)
    size, count = np.asarray(radius, float)[order], np.asarray(number, float)[order]
    return Law(spec, size[0], size[-1], size, np.cumsum(count) / count.sum(), True, listed)


def random_law(rng: np.random.Generator, low: float, high: float, folder: Path, name: str) -> Law:
    """Return a law of any kind about as wide as asked [m]; files of radii are written into a folder."""
    kinds = [constant, uniform, lognormal, rosin_rammler, sieve, discrete, listed] * 2 + [normal]
    kind = kinds[int(rng.integers(len(kinds)))]
    if kind is listed:
        return listed(rng, low, high, folder, name)
    return kind(rng, low, high)


def constant(rng: np.random.Generator, low: float, high: float) -> Law:
    radius = float(rng.uniform(low, high))
    written: Any = radius if rng.random() < 0.8 else f"{1e3 * radius!r} mm"
    return stepped({"radius_distribution": "constant", "radius": written}, [radius], [1.0])


def uniform(rng: np.random.Generator, low: float, high: float) -> Law:
    high = max(high, low * (1.0 + 1e-9))
    spec = {"radius_distribution": "uniform", "radius_min": low, "radius_max": high}
    return curve(spec, low, high, lambda radius: radius - low)


def normal(rng: np.random.Generator, low: float, high: float) -> Law:
    mean, deviation = 0.5 * (low + high), max((high - low) / rng.uniform(2.0, 8.0), 1e-3 * low)
    spec = {"radius_distribution": "normal", "radius_mean": mean, "radius_std_dev": deviation}
    bounds = max(mean - CUT * deviation, 0.1 * mean), mean + CUT * deviation
    return _bounded(rng, spec, (low, high), bounds, lambda radius: ndtr((radius - mean) / deviation))


def lognormal(rng: np.random.Generator, low: float, high: float) -> Law:
    median = float(np.sqrt(low * high))
    sigma = max(float(np.log(high / low) / rng.uniform(2.0, 8.0)), 1e-3)
    spec = {"radius_distribution": "lognormal", "radius_median": median, "sigma": sigma}
    bounds = median * float(np.exp(-CUT * sigma)), median * float(np.exp(CUT * sigma))
    return _bounded(rng, spec, (low, high), bounds, lambda radius: ndtr(np.log(radius / median) / sigma))


def _bounded(rng: np.random.Generator, spec: dict[str, Any], asked: tuple[float, float],
             default: tuple[float, float], below: Callable[[Array], Array]) -> Law:  # fmt: skip
    """Write one bound, both or none; the law's own ones are taken where none is written and they are near."""
    low, high = default
    wide = asked[1] > 1.01 * asked[0]
    if wide and (rng.random() < 0.5 or low < 0.7 * asked[0]):
        low = spec["radius_min"] = asked[0]
    if wide and (rng.random() < 0.5 or high > 1.3 * asked[1]):
        high = spec["radius_max"] = asked[1]
    return curve(spec, low, high, below)


def rosin_rammler(rng: np.random.Generator, low: float, high: float) -> Law:
    high = max(high, 1.001 * low)
    middle, exponent = float(rng.uniform(low, high)), float(rng.uniform(0.5, 6.0))
    spec = {"radius_distribution": "rosin_rammler", "radius_63": middle, "exponent": exponent,
            "radius_min": low, "radius_max": high}  # fmt: skip
    return of_mass(spec, low, high, lambda radius: -np.exp(-((radius / middle) ** exponent)))


def sieve(rng: np.random.Generator, low: float, high: float) -> Law:
    high = max(high, 1.01 * low)
    count = int(rng.integers(2, 6))
    diameter = 2.0 * np.geomspace(low, high, count)
    passing = np.concatenate([[0.0], np.sort(rng.random(count - 2)), [1.0]])
    if count > 2 and rng.random() < 0.3:
        passing[0] = 0.5 * passing[1]
    spec = {"radius_distribution": "sieve", "diameters": diameter.tolist(), "passing": passing.tolist()}
    if rng.random() < 0.3:
        spec |= {key: spec[key][::-1] for key in ("diameters", "passing")}
    if passing[0] > 0.0:  # what passes the finest sieve goes as far as a next one of the series would be
        diameter = np.concatenate([[diameter[0] ** 2 / diameter[1]], diameter])
        passing = np.concatenate([[0.0], passing])
    return of_mass(
        spec, diameter[0] / 2.0, diameter[-1] / 2.0, lambda radius: np.interp(2.0 * radius, diameter, passing)
    )


def discrete(rng: np.random.Generator, low: float, high: float) -> Law:
    radius = np.unique(rng.uniform(low, high, int(rng.integers(1, 5))))
    share = rng.dirichlet(np.ones(len(radius)))
    by = "mass" if rng.random() < 0.5 else "number"
    spec = {
        "radius_distribution": "discrete",
        "radii": radius.tolist(),
        "fractions": share.tolist(),
        "by": by,
    }
    return stepped(spec, radius, share / radius**3 if by == "mass" else share)


def listed(rng: np.random.Generator, low: float, high: float, folder: Path, name: str) -> Law:
    radius = rng.uniform(low, high, int(np.exp(rng.uniform(0.0, np.log(300.0)))) + 1)
    lines = [repr(float(each)) for each in radius]
    if rng.random() < 0.5:
        lines = ["# radii in metres", *lines]
    else:
        lines = ["number,radius", *(f"{index},{line}" for index, line in enumerate(lines))]
    (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    spec = {"radius_distribution": "file", "path": f"{name}.csv"}
    return stepped(spec, radius, np.ones(len(radius)), listed=True)
