"""The bed: spheres at rest in a container, and all that a deck, a report or a solver needs to know of them.

This module is the contract between packgen and every exporter: plain read-only numpy arrays, no torch.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int32Array, read_only
from packgen.bodies import (
    SINGLE,
    Bodies,
    Template,
    UnbalancedError,
    has_members,
    quaternions,
    rotations,
    sphere_shares,
)
from packgen.census import Census, count_spheres
from packgen.errors import ExportError
from packgen.geometry import (
    Ball,
    Box,
    Cone,
    Container,
    Mesh,
    Polyhedron,
    Shape,
    Surface,
    floor_direction,
)
from packgen.images import is_askew, with_images, with_owned_images

# Plug-ins find a bed's shapes here, with the bed; packgen itself takes them from where they live.
__all__ = [
    "SINGLE", "AnyBed", "Ball", "Bed", "Bodies", "Box", "Census", "Cone", "Container", "EarlierBed", "Head",
    "Material", "Mesh", "ParticleSet", "Polyhedron", "Shape", "Surface", "Template", "UnbalancedError",
    "has_clumps", "is_askew", "numbered", "pair_coefficient", "quaternions", "rotations", "sphere_shares",
    "with_images", "with_owned_images",
]  # fmt: skip

UNKNOWN = "not known"  # what the provenance of a bed from elsewhere says of its walls


@dataclass(frozen=True, slots=True)
class Material:
    """What a solver needs to know of a material; SI units.

    Attributes:
        name: Name in the scene.
        youngs_modulus: Young's modulus [Pa].
        poissons_ratio: Poisson's ratio.
        restitution: Coefficient of restitution.
        friction: Coefficient of sliding friction; spheres below 1/3 are arranged more densely, down to 0.1.
        rolling_friction: Coefficient of rolling friction; 0 leaves the rolling model out.
    """

    name: str
    youngs_modulus: float = 1.0e8
    poissons_ratio: float = 0.3
    restitution: float = 0.5
    friction: float = 0.5
    rolling_friction: float = 0.0


def pair_coefficient(first: float, second: float) -> float:
    """Return restitution or friction of a contact of two materials, whose own are given.

    It is the harmonic mean 2ab / (a + b), as MercuryDPM mixes its species: like materials keep their value,
    and a frictionless wall stays frictionless.
    """
    if first == second:
        return first
    return 2.0 * first * second / (first + second) if first > 0.0 and second > 0.0 else 0.0


@dataclass(frozen=True, slots=True)
class ParticleSet:
    """A set of spheres with common properties: name, density [kg/m3], and the name of its material.

    Of a bed from elsewhere the density may be unknown, NaN, and the material, an empty name.
    """

    name: str
    density: float
    material: str


@dataclass(frozen=True, slots=True)
class EarlierBed:
    """Which spheres were there before the others were placed; a solver may have left them with overlaps.

    Attributes:
        first_zone: Number of the zone from which on spheres are of it.
        tolerance: Largest overlap of two of its spheres, or of one with a wall, as a fraction of the smaller
            radius; None: any.
    """

    first_zone: int
    tolerance: float | None


class Head:
    """What follows from what a bed is beside its spheres, whether these are at hand or in pieces."""

    __slots__ = ()

    particle_sets: tuple[ParticleSet, ...]
    container: Container
    gravity: Float64Array

    @property
    def down(self) -> Float64Array:
        """Unit vector towards what the bed lies on, shape (3,).

        It is gravity without its part along periodic axes, all of gravity for an endless bed, and -z without
        gravity.
        """
        strength = float(np.linalg.norm(self.gravity))
        if strength == 0.0:
            return np.array([0.0, 0.0, -1.0])
        held = floor_direction(self.gravity, self.container.periodic)
        return self.gravity / strength if held is None else held

    @property
    def endless(self) -> bool:
        """Whether the container wraps around along gravity: nothing holds the bed, it would fall for ever."""
        return bool(self.gravity.any()) and floor_direction(self.gravity, self.container.periodic) is None

    @property
    def rests(self) -> bool:
        """Whether the bed lies on something, and has a top: it has gravity, and is not endless."""
        return bool(self.gravity.any()) and not self.endless

    @property
    def weights_known(self) -> bool:
        """Whether the density of every set is known; that of a bed from elsewhere may not be."""
        return not any(np.isnan(each.density) for each in self.particle_sets)

    @property
    def acceleration(self) -> Float64Array:
        """Acceleration for the solvers [m/s2], shape (3,): that of gravity, zero in an endless bed."""
        return np.zeros(3) if self.endless else self.gravity


@dataclass(frozen=True, eq=False, slots=True)
class Bed(Head):
    """Spheres at rest in a container.

    Attributes:
        position: Sphere centres [m], shape (N, 3), float64.
        radius: Sphere radii [m], shape (N,), float64.
        set_index: Index into ``particle_sets``, shape (N,), int32.
        zone_index: Zone that each sphere was placed for, shape (N,), int32.
        batch_index: Batch (layer) that each sphere arrived with, shape (N,), int32.
        particle_sets: The sets.
        materials: The materials that sets and wall use, in the order of the decks' types; none
            where they are not known.
        wall_material: Name of the walls' material.
        container: The vessel.
        gravity: Acceleration of gravity [m/s2], shape (3,), float64.
        tolerance: Largest overlap asked for, as a fraction of the smaller radius; None: as Adam left it.
        provenance: Version, scene, seed, effective settings; plain data that JSON can hold.
        body_index: Body of each sphere, shape (N,), int32: spheres of one body may overlap each other. None:
            each sphere is a body.
        earlier: The bed that was there before, where this one goes on from another; None: it does not.
        bodies: Shape, place and orientation of each body, by ``body_index``; None: spheres of one body may
            belong together, but nothing more is known of it.
    """

    position: Float64Array
    radius: Float64Array
    set_index: Int32Array
    zone_index: Int32Array
    batch_index: Int32Array
    particle_sets: tuple[ParticleSet, ...]
    materials: tuple[Material, ...]
    wall_material: str
    container: Container
    gravity: Float64Array
    tolerance: float | None = 1.0e-6
    provenance: Mapping[str, Any] = field(default_factory=lambda: MappingProxyType({}))
    body_index: Int32Array | None = None
    earlier: EarlierBed | None = None
    bodies: Bodies | None = None
    _census: Census | None = field(default=None, init=False, repr=False)

    def __post_init__(self) -> None:
        count = len(self.position)
        for name, dtype, shape in (
            ("position", np.float64, (None, 3)),
            ("radius", np.float64, (count,)),
            ("set_index", np.int32, (count,)),
            ("zone_index", np.int32, (count,)),
            ("batch_index", np.int32, (count,)),
            ("gravity", np.float64, (3,)),
            ("body_index", np.int32, (count,)),
        ):
            value = getattr(self, name)
            if value is not None or name != "body_index":
                object.__setattr__(self, name, read_only(value, dtype, shape, f"bed.{name}"))
        self._check_bodies()

    def _check_bodies(self) -> None:
        """Refuse bodies that are not those of the spheres.

        Raises:
            ValueError: They are not.
        """
        if self.bodies is None:
            return
        if self.body_index is None or not has_members(self.bodies, self.body_index):
            raise ValueError(
                f"bed.bodies: {len(self.bodies)} bodies are not those of bed.body_index, expected a row a "
                "body, whose spheres have consecutive rows, as many as its template"
            )

    @classmethod
    def load(cls, path: Path | str) -> Bed:
        """Read a bed from a file, as `packgen.read_bed` does.

        Args:
            path: A ``bed.npz``, or a file of any other format that packgen reads.

        Raises:
            ReadError: The file is not what it claims; a line a fault.
        """
        from packgen.reading import read_bed

        return read_bed(path)

    def save(self, path: Path | str) -> None:
        """Write a bed as ``bed.npz``: its spheres, and the provenance that says what is known besides.

        Args:
            path: File to write; its ending is npz.

        Raises:
            ExportError: It has another ending: other formats are the exporters'.
            OSError: The file cannot be written.
        """
        from packgen.bedfile import save_bed

        if Path(path).suffix != ".npz":
            raise ExportError(f"{path}: expected a name that ends in .npz; exporters write other formats")
        save_bed(self, Path(path))

    def _repr_html_(self) -> str:
        """Return verdict and page, which notebooks show."""
        from packgen.notebook import bed_html

        return bed_html(self)

    @property
    def count(self) -> int:
        """Number of spheres."""
        return len(self.radius)

    @property
    def is_earlier(self) -> BoolArray:
        """Which spheres were there before the others were placed, shape (N,), bool."""
        if self.earlier is None:
            return np.zeros(self.count, dtype=bool)
        return np.asarray(self.zone_index >= self.earlier.first_zone)

    @property
    def density(self) -> Float64Array:
        """Density of each sphere [kg/m3], shape (N,), float64."""
        return np.array([each.density for each in self.particle_sets], dtype=np.float64)[self.set_index]

    @property
    def type_index(self) -> Int32Array:
        """Index into ``materials`` of each sphere, shape (N,), int32."""
        names = [material.name for material in self.materials]
        by_set = np.array([names.index(each.material) for each in self.particle_sets], dtype=np.int32)
        return by_set[self.set_index]

    @property
    def census(self) -> Census:
        """Numbers, sizes and places of the spheres in short; found once."""
        if self._census is None:
            counted = count_spheres(self.position, self.radius, self.set_index, len(self.particle_sets))
            object.__setattr__(self, "_census", counted)
        assert self._census is not None
        return self._census

    def chunks(self) -> Iterator[Bed]:
        """Yield the spheres in the order of their numbers: all of them at once."""
        yield self


class AnyBed(Protocol):
    """What a bed at hand and a bed in pieces have in common: the attributes of `Bed`, but for its arrays.

    Attributes:
        count: Number of spheres.
        census: Numbers, sizes and places of the spheres in short.
    """

    @property
    def particle_sets(self) -> tuple[ParticleSet, ...]: ...  # noqa: D102
    @property
    def materials(self) -> tuple[Material, ...]: ...  # noqa: D102
    @property
    def wall_material(self) -> str: ...  # noqa: D102
    @property
    def container(self) -> Container: ...  # noqa: D102
    @property
    def gravity(self) -> Float64Array: ...  # noqa: D102
    @property
    def provenance(self) -> Mapping[str, Any]: ...  # noqa: D102
    @property
    def count(self) -> int: ...  # noqa: D102
    @property
    def census(self) -> Census: ...  # noqa: D102
    @property
    def acceleration(self) -> Float64Array: ...  # noqa: D102
    @property
    def endless(self) -> bool: ...  # noqa: D102
    @property
    def rests(self) -> bool: ...  # noqa: D102
    @property
    def down(self) -> Float64Array: ...  # noqa: D102
    @property
    def weights_known(self) -> bool: ...  # noqa: D102

    def chunks(self) -> Iterator[Bed]:
        """Yield the spheres in the order of their numbers, some at a time, as beds of their own."""
        ...


def has_clumps(bed: Bed) -> bool:
    """Return whether some body of a bed, whose shape is known, has more than one sphere."""
    return bed.bodies is not None and len(bed.bodies) < bed.count


def numbered(bed: AnyBed) -> Iterator[tuple[int, Bed]]:
    """Yield the chunks of a bed, each with the number of its first sphere, from 0."""
    start = 0
    for chunk in bed.chunks():
        yield start, chunk
        start += chunk.count
