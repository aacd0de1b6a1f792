"""What a scene file may say about a set of particles: law of sizes, shape, density and material.

One class a ``radius_distribution``; each builds its law from ``packgen.distributions``.
"""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, Literal, Self

from pydantic import Discriminator, model_validator
from pydantic_core import PydanticCustomError

from packgen import distributions
from packgen.bodies import Form, Template, is_sphere, sieve_size
from packgen.distributions import Distribution
from packgen.scene.shapes import ShapeSpec
from packgen.values import (
    Density,
    FilePath,
    Fractions,
    Keys,
    Lengths,
    Name,
    Positive,
    PositiveLength,
    Turning,
    fault,
)

__all__ = ["ParticleSetSpec", "SetKeys"]


class SetKeys(Keys):
    """What every set has.

    Attributes:
        name: Its name; empty only before ``load_scene`` fills it in.
        density: Density of its spheres [kg/m3].
        material: Name of its material; empty only before ``load_scene`` fills it in.
        shape: Shape of its particles, rigid clumps of spheres; None: they are spheres. Each radius of the law
            is half the particle's size then.
        size: What that size is: ``equivalent``, the diameter of the sphere of the particle's volume, or
            ``sieve``, the side of the smallest square hole that it passes. Left out: equivalent.
        orientation: How the particles are turned when they come; they turn further as they come to rest:
            ``random``, ``aligned`` (the shape's axes are the bed's), or a direction that their longest axis
            lies along. Left out: random.
    """

    name: Name = ""
    density: Density = 2500.0
    material: Name = ""
    shape: ShapeSpec | None = None
    size: Literal["equivalent", "sieve"] | None = None
    orientation: Turning | None = None

    @cached_property
    def distribution(self) -> Distribution:
        """The law of the radii; of clumps those of the spheres of their volumes."""
        law = self._build()
        if self.template is None or self.size != "sieve":
            return law
        ratio = self.template.equivalent_diameter / sieve_size(self.template.spheres)
        return distributions.scaled(law, ratio)

    @cached_property
    def template(self) -> Template | None:
        """The clump of the shape; None: the particles are spheres."""
        return None if self.shape is None else self.shape.template()

    @cached_property
    def form(self) -> Form | None:
        """The clump and how it is turned; None: the particles are spheres, or clumps of one that is all."""
        template = self.template
        if template is None or is_sphere(template):
            return None
        return Form(template, self.orientation or "random")

    def _build(self) -> Distribution:
        raise NotImplementedError

    @model_validator(mode="after")
    def _law_can_be_built(self) -> Self:
        stray = [(key, getattr(self, key)) for key in ("size", "orientation") if self.shape is None]
        faults = [(key, value, "this key only beside shape") for key, value in stray if value is not None]
        if faults:
            raise fault(*faults)
        try:
            _ = self.template
        except PydanticCustomError as error:
            context = error.context or {}
            raise fault(*(("shape", *each[1:]) for each in context["faults"])) from error
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
