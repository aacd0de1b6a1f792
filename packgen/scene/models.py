"""What a scene file may say about container, zones, algorithm, materials and limits; all in SI once read.

Each class is one mapping of the YAML. Its attributes are the mapping's keys; its properties are what the rest
of packgen asks for.
"""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, model_validator

from packgen.units import LENGTHS
from packgen.values import (
    AxisIndex,
    BedPath,
    Count,
    FilePath,
    Flag,
    Fraction,
    Fractions,
    InnerFraction,
    Keys,
    Length,
    LengthUnit,
    Mass,
    NonNegative,
    NonNegativeLength,
    Periodic,
    Point,
    PoissonsRatio,
    Positive,
    PositiveLength,
    Pressure,
    PrimitiveAxis,
    SolidVolume,
    Unit3,
    WholeNumber,
    fault,
    plainly,
)

__all__ = [
    "AMOUNTS", "FRACTIONS", "BoxSpec", "ConeSpec", "ContainerSpec", "CylinderSpec", "FractionSpec", "GapSpec",
    "LocationSpec", "MaterialSpec", "PrimitiveSpec", "RatioSpec", "SliceSpec", "SphereSpec", "StartFrom",
    "StartSpec", "ValidationSpec", "ZoneSpec",
]  # fmt: skip

AMOUNTS = ("n_particles", "volume", "mass")
"""The keys of a zone that say how much is in it."""

FRACTIONS = ("solid_fraction", "porosity", "void_ratio")
"""The keys of a zone that say how dense it is."""

SUM_SLACK = 2.0e-3  # lets thirds be written as 0.333
_ORIGIN: Unit3 = (0.0, 0.0, 0.0)
_UP: Unit3 = (0.0, 0.0, 1.0)


class BoxSpec(Keys):
    """An axis-parallel box between two corners [m]."""

    min: Point
    max: Point

    @model_validator(mode="after")
    def _corners_in_order(self) -> Self:
        for axis, low, high in zip("xyz", self.min, self.max, strict=True):
            if not low < high:
                raise fault(("max", list(self.max), f"a corner above min = {list(self.min)} along {axis}"))
        return self


class CylinderSpec(Keys):
    """A cylinder with flat ends [m]; ``axis`` points from its base to its other end."""

    radius: PositiveLength
    height: PositiveLength
    base: Point = _ORIGIN
    axis: PrimitiveAxis = _UP


class ConeSpec(Keys):
    """A cone, truncated or not [m]; ``axis`` points from its bottom end to its top end."""

    radius_bottom: NonNegativeLength
    radius_top: NonNegativeLength
    height: PositiveLength
    base: Point = _ORIGIN
    axis: PrimitiveAxis = _UP

    @model_validator(mode="after")
    def _one_end_is_open(self) -> Self:
        if self.radius_bottom == self.radius_top == 0.0:
            raise fault(("radius_top", 0.0, "a radius greater than 0 at one of the two ends"))
        return self


class SphereSpec(Keys):
    """The inside of a sphere [m]."""

    radius: PositiveLength
    center: Point = _ORIGIN


class SliceSpec(Keys):
    """The space between two planes across ``axis``, a unit vector."""

    axis: AxisIndex
    min_bound: Length
    max_bound: Length

    @model_validator(mode="after")
    def _bounds_in_order(self) -> Self:
        if not self.min_bound < self.max_bound:
            raise fault(("max_bound", self.max_bound, f"more than min_bound = {self.min_bound:g}"))
        return self


PrimitiveSpec = BoxSpec | CylinderSpec | ConeSpec | SphereSpec


class _Place(Keys):
    """What container and location share: a mesh file or one primitive.

    Attributes:
        path: A triangle mesh: stl, ply, obj, off, and what meshio reads.
        units: Unit of the mesh's coordinates.
        shape: The surface as it is, convex or not, or its convex hull.
        box: An axis-parallel box.
        cylinder: A cylinder.
        cone: A cone.
        sphere: A sphere.
    """

    path: FilePath | None = None
    units: LengthUnit = "m"
    shape: Literal["mesh", "convex_hull"] = "mesh"
    box: BoxSpec | None = None
    cylinder: CylinderSpec | None = None
    cone: ConeSpec | None = None
    sphere: SphereSpec | None = None

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        forms = [
            name
            for name in ("path", "slice", "box", "cylinder", "cone", "sphere", "cell")
            if name in type(self).model_fields
        ]
        given = [name for name in forms if getattr(self, name) is not None]
        if len(given) != 1:
            found = " and ".join(given) or "none of them"
            raise fault((given[1] if given else "", found, f"exactly one of {', '.join(forms)}"))
        stray = [name for name in ("units", "shape") if name in self.model_fields_set and self.path is None]
        if stray:
            raise fault(*((name, getattr(self, name), "this key only beside path") for name in stray))
        return self

    @property
    def scale(self) -> float:
        """Metres in one unit of the mesh coordinates."""
        return LENGTHS[self.units]

    @property
    def primitive(self) -> PrimitiveSpec | None:
        """The primitive, or None where a mesh file or a slice is given."""
        return self.box or self.cylinder or self.cone or self.sphere


class ContainerSpec(_Place):
    """The container: a mesh file, a primitive, or a periodic cell.

    Attributes:
        cell: free: a periodic cell whose shape and size are found; algorithm SHRINKING_CELL.
        periodic: Axes along which a box wraps around.
    """

    cell: Literal["free"] | None = None
    periodic: Periodic = (False, False, False)

    @model_validator(mode="after")
    def _only_boxes_wrap_around(self) -> Self:
        if any(self.periodic) and self.box is None:
            found = [axis for axis, wraps in zip("xyz", self.periodic, strict=True) if wraps]
            raise fault(("periodic", found, "this key only beside box"))
        return self


class LocationSpec(_Place):
    """Where a zone is: a mesh file, a primitive, or a slice.

    Attributes:
        slice: The space between two planes; across gravity it bounds the spheres' centres, so that layers
            interlock as poured ones do; any other location bounds whole spheres.
    """

    slice: SliceSpec | None = None


class FractionSpec(Keys):
    """How dense a zone is, as a share of its space.

    Attributes:
        value: The share.
        of: Whether it is that of the filled volume, walls included, or of the core away from them.
    """

    value: InnerFraction
    of: Literal["filled", "core"] = "filled"


class RatioSpec(Keys):
    """How dense a zone is, as the ratio of voids to spheres; see ``FractionSpec``."""

    value: Positive
    of: Literal["filled", "core"] = "filled"


class GapSpec(Keys):
    """The least distance between surfaces; both parts add up.

    Attributes:
        radii: In radii: of the mean radius of two spheres, at a wall of the sphere's own.
        length: In metres.
    """

    radii: NonNegative = 0.0
    length: NonNegativeLength = 0.0


def _by_value(value: Any) -> Any:
    """Return a plain number as the mapping that it stands for."""
    return value if isinstance(value, dict | FractionSpec | RatioSpec) else {"value": value}


def _by_unit(value: Any) -> Any:
    """Return a plain number, which is one of radii, or a length with its unit as a mapping."""
    if isinstance(value, dict | GapSpec):
        return value
    return {"length" if isinstance(value, str) else "radii": value}


ShareOfSpace = Annotated[FractionSpec, BeforeValidator(_by_value), plainly(InnerFraction)]
RatioOfVoids = Annotated[RatioSpec, BeforeValidator(_by_value), plainly(Positive)]
LeastGap = Annotated[GapSpec, BeforeValidator(_by_unit), plainly(NonNegativeLength)]


class ZoneSpec(Keys):
    """A part of the container to fill: where, how much or how densely, and with which sets.

    Attributes:
        n_particles: Number of spheres; without this, another amount and a fraction: until the zone is full.
        volume: Solid volume [m3].
        mass: Mass [kg].
        solid_fraction: Volume of the spheres over that of the zone, walls included. With DISPERSED the number
            of spheres follows. COLLECTIVE_ARRANGEMENT makes the bed of the only zone as loose or dense,
            beside an amount too.
        porosity: The same, by the share of the voids.
        void_ratio: The same, by the volume of the voids over that of the spheres.
        gap: Least distance between surfaces, of spheres and of walls: a number of radii, or a length with its
            unit. Algorithm DISPERSED.
        location: Where; None: the whole container.
        set_proportions: Share of each set; adds up to 1. Empty only before ``load_scene`` fills it in.
        proportions_by: What the shares are shares of.
    """

    n_particles: Count | None = None
    volume: SolidVolume | None = None
    mass: Mass | None = None
    solid_fraction: ShareOfSpace | None = None
    porosity: ShareOfSpace | None = None
    void_ratio: RatioOfVoids | None = None
    gap: LeastGap | None = None
    location: LocationSpec | None = None
    set_proportions: Fractions = ()
    proportions_by: Literal["number", "volume", "mass"] = "number"

    @model_validator(mode="after")
    def _one_amount(self) -> Self:
        for names in (AMOUNTS, FRACTIONS):
            given = [name for name in names if getattr(self, name) is not None]
            if len(given) > 1:
                raise fault((given[1], " and ".join(given), f"at most one of {', '.join(names)}"))
        total = math.fsum(self.set_proportions)
        if self.set_proportions and abs(total - 1.0) > SUM_SLACK:
            expected = f"numbers that add up to 1, not to {total:g}"
            raise fault(("set_proportions", list(self.set_proportions), expected))
        return self

    @property
    def density_key(self) -> str | None:
        """The key that says how dense the zone is; None: none does."""
        return next((name for name in FRACTIONS if getattr(self, name) is not None), None)

    @property
    def fraction(self) -> FractionSpec | None:
        """How dense it is, as a solid fraction; None: that is not asked."""
        if self.porosity is not None:
            return FractionSpec(value=1.0 - self.porosity.value, of=self.porosity.of)
        if self.void_ratio is not None:
            return FractionSpec(value=1.0 / (1.0 + self.void_ratio.value), of=self.void_ratio.of)
        return self.solid_fraction


def _by_path(value: Any) -> Any:
    """Return a plain path as the mapping that it stands for."""
    return {"path": value} if isinstance(value, str) else value


class StartSpec(Keys):
    """A bed that is there before the zones are filled.

    Attributes:
        path: A file of spheres of any format that packgen reads, or a result folder.
        hold: Whether its spheres near the surface move again with the first new ones (surface), or all stay
            where they are (fixed). Left out: surface where the algorithm fills in layers, else fixed.
        units: Unit of the file's lengths; left out: metres, unless they look like another unit.
        step: Step of a dump, or of an XYZ file; left out: the last one.
    """

    path: BedPath
    hold: Literal["surface", "fixed"] | None = None
    units: LengthUnit | None = None
    step: WholeNumber | None = None


StartFrom = Annotated[StartSpec, BeforeValidator(_by_path), plainly(BedPath)]


class MaterialSpec(Keys):
    """A material as solver decks and, its friction, the arrangement need it; see ``packgen.bed.Material``.

    Attributes:
        allow_soft: Whether spheres may be so soft that the bed's weight presses them half a radius or more
            into each other; false: such a scene is refused.
    """

    youngs_modulus: Pressure = 1.0e8
    poissons_ratio: PoissonsRatio = 0.3
    restitution: Fraction = 0.5
    friction: NonNegative = 0.5
    rolling_friction: NonNegative = 0.0
    allow_soft: Flag = False


class ValidationSpec(Keys):
    """What a solver's verdict on a bed is measured against.

    Attributes:
        force_limit: Largest contact force at step 0, in sphere weights.
        displacement_limit: Mean displacement in the gravity run, in radii.
        sinking_limit: Sinking of the centre of mass, as a fraction of its height.
        lost_limit: Spheres that may be lost.
        free_fall_times: Length of the gravity run, in times sqrt(2 r / g) of free fall over a mean radius; it
            ends before where nothing moves any more.
        work_budget: Sphere-steps that the gravity run may cost; a bed of few spheres counts for more, as a
            step has costs of its own.
    """

    force_limit: Positive = 1.0
    displacement_limit: Positive = 0.2
    sinking_limit: Positive = 0.015
    lost_limit: WholeNumber = 0
    free_fall_times: Positive = 20.0
    work_budget: Positive = 2.0e9
