"""Parametric shapes: dumbbell, rod, tetrapod and ring of spheres; filled cylinder, ellipsoid, cube.

Dumbbell, tetrapod and ring are the union of their spheres. A rod is the spherocylinder that its spheres
stand for. The others are bodies that spheres fill as they fill a stone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from types import MappingProxyType

import numpy as np

from packgen.arrays import Float64Array
from packgen.errors import PackgenError
from packgen.geometry import Surface


@dataclass(frozen=True, slots=True)
class Dumbbell:
    """Two equal spheres.

    Attributes:
        radius: Radius of the spheres [m].
        distance: Distance of their centres [m].
    """

    radius: float = 0.005
    distance: float = 0.008

    def spheres(self, count: int) -> Float64Array:
        """Return the spheres [m], shape (N, 4); there are two."""
        _need(count == 2, "dumbbell", f"spheres={count}", "2 spheres")
        x = self.distance / 2.0
        return np.array([[-x, 0.0, 0.0, self.radius], [x, 0.0, 0.0, self.radius]])


@dataclass(frozen=True, slots=True)
class Rod:
    """A cylinder with round ends along x.

    Attributes:
        radius: Radius of the rod [m].
        length: Length from tip to tip [m].
    """

    radius: float = 0.0025
    length: float = 0.015

    def spheres(self, count: int) -> Float64Array:
        """Return equal spheres along the rod [m], shape (count, 4)."""
        _need(self.length > 2.0 * self.radius, "rod", f"length={self.length:g}", "more than two radii")
        _need(count >= 2, "rod", f"spheres={count}", "at least 2 spheres")
        x = np.linspace(-1.0, 1.0, count) * (self.length / 2.0 - self.radius)
        return np.column_stack([x, np.zeros((count, 2)), np.full(count, self.radius)])

    def surface(self) -> Surface:
        """Return its mesh."""
        from packgen.clumps.tessellate import rod_surface

        return rod_surface(self.radius, self.length)


@dataclass(frozen=True, slots=True)
class Tetrapod:
    """Four arms towards the corners of a regular tetrahedron.

    Attributes:
        radius: Radius of the arms and their ends [m].
        arm: Distance of the ends' centres from the middle [m].
    """

    radius: float = 0.003
    arm: float = 0.008

    def spheres(self, count: int) -> Float64Array:
        """Return one sphere in the middle and as many on each arm [m], shape (count, 4)."""
        _need(
            count >= 5 and count % 4 == 1, "tetrapod", f"spheres={count}", "5, 9, 13 ...: one, and four arms"
        )
        way = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / math.sqrt(3.0)
        along = self.arm * np.arange(1, count // 4 + 1)[:, None, None] / (count // 4)
        centre = np.concatenate([np.zeros((1, 3)), (along * way).reshape(-1, 3)])
        return np.column_stack([centre, np.full(count, self.radius)])


@dataclass(frozen=True, slots=True)
class Ring:
    """Equal spheres on a circle about z.

    Attributes:
        radius: Radius of the circle of the centres [m].
        thickness: Diameter of the spheres [m]; 0: they touch their neighbours.
    """

    radius: float = 0.005
    thickness: float = 0.0

    def spheres(self, count: int) -> Float64Array:
        """Return the spheres [m], shape (count, 4)."""
        _need(count >= 3, "ring", f"spheres={count}", "at least 3 spheres")
        touching = self.radius * math.sin(math.pi / count)
        radius = self.thickness / 2.0 or touching
        _need(
            radius >= touching * (1.0 - 1e-12),
            "ring",
            f"thickness={self.thickness:g}",
            f"at least {2.0 * touching:.6g}, at which {count} spheres touch",
        )
        angle = 2.0 * np.pi * np.arange(count) / count
        centre = self.radius * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(count)])
        return np.column_stack([centre, np.full(count, radius)])


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A cylinder about z with flat ends.

    Attributes:
        radius: Radius [m].
        height: Height [m].
    """

    radius: float = 0.005
    height: float = 0.01

    def surface(self) -> Surface:
        """Return its mesh."""
        from packgen.clumps.tessellate import cylinder_surface

        return cylinder_surface(self.radius, self.height)


@dataclass(frozen=True, slots=True)
class Ellipsoid:
    """An ellipsoid.

    Attributes:
        x: Full length along x [m].
        y: Full length along y [m].
        z: Full length along z [m].
    """

    x: float = 0.012
    y: float = 0.01
    z: float = 0.008

    def surface(self) -> Surface:
        """Return its mesh."""
        from packgen.clumps.tessellate import ellipsoid_surface

        return ellipsoid_surface((self.x, self.y, self.z))


@dataclass(frozen=True, slots=True)
class Cube:
    """A cube with rounded edges and corners.

    Attributes:
        side: Its length from face to face [m].
        edge: Radius of the edges [m].
    """

    side: float = 0.01
    edge: float = 0.002

    def surface(self) -> Surface:
        """Return its mesh."""
        from packgen.clumps.tessellate import rounded_cube_surface

        _need(
            2.0 * self.edge <= self.side,
            "cube",
            f"edge={self.edge:g}",
            f"at most half a side, {self.side / 2.0:g}",
        )
        return rounded_cube_surface(self.side, self.edge)


OfSpheres = Dumbbell | Rod | Tetrapod | Ring
Solid = Cylinder | Ellipsoid | Cube
ParametricShape = OfSpheres | Solid

SHAPES: MappingProxyType[str, type[ParametricShape]] = MappingProxyType(
    {
        "dumbbell": Dumbbell,
        "rod": Rod,
        "tetrapod": Tetrapod,
        "ring": Ring,
        "cylinder": Cylinder,
        "ellipsoid": Ellipsoid,
        "cube": Cube,
    }
)
"""The shapes by name."""


def shape_of(name: str, sizes: dict[str, float]) -> ParametricShape:
    """Return a shape.

    Args:
        name: A key of `SHAPES`.
        sizes: Lengths [m] by name; those that are left out have defaults.

    Raises:
        PackgenError: The shape has no such size, or one is not above 0.
    """
    kind = SHAPES[name]
    known = [each.name for each in fields(kind)]
    for key, value in sizes.items():
        _need(key in known, name, f"size {key!r}", " or ".join(known))
        _need(0.0 < value < 1e6, name, f"{key}={value:g}", "a length above 0")
    return kind(**sizes)


def _need(holds: bool, shape: str, found: str, expected: str) -> None:
    if not holds:
        raise PackgenError(f"clump: {shape}: found {found}, expected {expected}")
