"""What a scene file may say about a set of spheres: its law of sizes, density and material.

One class a ``radius_distribution``; each builds its law from ``packgen.distributions``.
"""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Literal, Self

from pydantic import Discriminator, model_validator

from packgen import distributions
from packgen.distributions import Distribution
from packgen.values import (
    Density,
    FilePath,
    Fractions,
    Keys,
    Lengths,
    Name,
    Positive,
    PositiveLength,
    fault,
)

__all__ = ["ParticleSetSpec", "SetKeys"]


class SetKeys(Keys):
    """What every set has.

    Attributes:
        name: Its name; empty only before ``load_scene`` fills it in.
        density: Density of its spheres [kg/m3].
        material: Name of its material; empty only before ``load_scene`` fills it in.
    """

    name: Name = ""
    density: Density = 2500.0
    material: Name = ""

    @cached_property
    def distribution(self) -> Distribution:
        """The law of the radii."""
        return self._build()

    def _build(self) -> Distribution:
        raise NotImplementedError

    @model_validator(mode="after")
    def _law_can_be_built(self) -> Self:
        try:
            _ = self.distribution
        except distributions.ParameterError as error:
            raise fault(*error.faults) from error
        return self


class ConstantSet(SetKeys):
    """Spheres of one radius [m]."""

    radius_distribution: Literal["constant"]
    radius: PositiveLength

    def _build(self) -> Distribution:
        return distributions.Constant(self.radius)


class UniformSet(SetKeys):
    """Radii [m] spread evenly between two bounds."""

    radius_distribution: Literal["uniform"]
    radius_min: PositiveLength
    radius_max: PositiveLength

    def _build(self) -> Distribution:
        return distributions.Uniform(self.radius_min, self.radius_max)


class NormalSet(SetKeys):
    """Normally distributed radii [m], truncated."""

    radius_distribution: Literal["normal"]
    radius_mean: PositiveLength
    radius_std_dev: PositiveLength
    radius_min: PositiveLength | None = None
    radius_max: PositiveLength | None = None

    def _build(self) -> Distribution:
        return distributions.Normal(self.radius_mean, self.radius_std_dev, self.radius_min, self.radius_max)


class LognormalSet(SetKeys):
    """Log-normally distributed radii [m], truncated."""

    radius_distribution: Literal["lognormal"]
    radius_median: PositiveLength
    sigma: Positive
    radius_min: PositiveLength | None = None
    radius_max: PositiveLength | None = None

    def _build(self) -> Distribution:
        return distributions.Lognormal(self.radius_median, self.sigma, self.radius_min, self.radius_max)


class RosinRammlerSet(SetKeys):
    """Rosin-Rammler by mass, truncated: 63.2 % of the mass below ``radius_63`` [m]."""

    radius_distribution: Literal["rosin_rammler"]
    radius_63: PositiveLength
    exponent: Positive
    radius_min: PositiveLength
    radius_max: PositiveLength

    def _build(self) -> Distribution:
        return distributions.RosinRammler(self.radius_63, self.exponent, self.radius_min, self.radius_max)


class SieveSet(SetKeys):
    """A sieve curve: the mass fraction that passes each diameter [m]."""

    radius_distribution: Literal["sieve"]
    diameters: Lengths
    passing: Fractions

    def _build(self) -> Distribution:
        return distributions.Sieve(self.diameters, self.passing)


class DiscreteSet(SetKeys):
    """A few radii [m], and the fraction of spheres or of mass that has each."""

    radius_distribution: Literal["discrete"]
    radii: Lengths
    fractions: Fractions
    by: Literal["number", "mass"] = "number"

    def _build(self) -> Distribution:
        return distributions.Discrete(self.radii, self.fractions, self.by)


class FileSet(SetKeys):
    """Exactly the spheres of a file of radii [m]."""

    radius_distribution: Literal["file"]
    path: FilePath

    def _build(self) -> Distribution:
        return distributions.Listed.from_file(self.path)


class FreeSet(SetKeys):
    """Spheres as large as the voids are, between two radii [m]; of algorithms that fill voids."""

    radius_distribution: Literal["free"]
    radius_min: PositiveLength
    radius_max: PositiveLength | None = None

    def _build(self) -> Distribution:
        return distributions.Free(self.radius_min, self.radius_max)


ParticleSetSpec = Annotated[
    ConstantSet
    | UniformSet
    | NormalSet
    | LognormalSet
    | RosinRammlerSet
    | SieveSet
    | DiscreteSet
    | FileSet
    | FreeSet,
    Discriminator("radius_distribution"),
]
