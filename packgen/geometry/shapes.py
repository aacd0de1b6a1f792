"""The shapes that bound spheres: plain, frozen numpy data in SI units, without behaviour.

A container is one of these shapes; a zone's location is another. What a shape does to spheres is in
``packgen.container`` (queries) and ``packgen.arrange`` (the fused loops).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array, read_only
from packgen.geometry.parts import WallPart
from packgen.portable import length

FLOOR_SHARE_MIN = 1.0e-9
"""Share of gravity, across the periodic axes, below which it is rounding."""


@dataclass(frozen=True, eq=False, slots=True)
class Surface:
    """A triangulated surface.

    Attributes:
        vertices: Corner positions [m], shape (V, 3), float64.
        faces: Corner indices of each triangle, shape (F, 3), int64; seen from outside counter-clockwise.
    """

    vertices: Float64Array
    faces: Int64Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", read_only(self.vertices, np.float64, (None, 3), "vertices"))
        object.__setattr__(self, "faces", read_only(self.faces, np.int64, (None, 3), "faces"))


@dataclass(frozen=True, eq=False, slots=True)
class Box:
    """An axis-parallel box between two corners [m], each of shape (3,)."""

    min: Float64Array
    max: Float64Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "min", read_only(self.min, np.float64, (3,), "box.min"))
        object.__setattr__(self, "max", read_only(self.max, np.float64, (3,), "box.max"))


@dataclass(frozen=True, eq=False, slots=True)
class Cone:
    """A cylinder (equal radii), truncated cone or cone with flat ends.

    Attributes:
        base: Centre of the bottom end [m], shape (3,).
        axis: Unit vector from the bottom to the top end, shape (3,).
        height: Distance between the ends [m].
        radius_bottom: Radius of the bottom end [m].
        radius_top: Radius of the top end [m].
    """

    base: Float64Array
    axis: Float64Array
    height: float
    radius_bottom: float
    radius_top: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "base", read_only(self.base, np.float64, (3,), "cone.base"))
        object.__setattr__(self, "axis", read_only(self.axis, np.float64, (3,), "cone.axis"))


@dataclass(frozen=True, eq=False, slots=True)
class Ball:
    """The inside of a sphere: centre [m] of shape (3,), and radius [m]."""

    center: Float64Array
    radius: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "center", read_only(self.center, np.float64, (3,), "sphere.center"))


@dataclass(frozen=True, eq=False, slots=True)
class Polyhedron:
    """A convex polyhedron: the points x with ``normal @ x <= offset`` for every plane.

    Attributes:
        normal: Outward unit normals, shape (P, 3), float64.
        offset: Distances of the planes from the origin along their normals [m], shape (P,), float64.
        surface: Its triangulated surface (without the lid, where the mesh was open at the top).
    """

    normal: Float64Array
    offset: Float64Array
    surface: Surface

    def __post_init__(self) -> None:
        object.__setattr__(self, "normal", read_only(self.normal, np.float64, (None, 3), "normal"))
        object.__setattr__(self, "offset", read_only(self.offset, np.float64, (len(self.normal),), "offset"))


@dataclass(frozen=True, eq=False, slots=True)
class Mesh:
    """A volume bounded by a triangulated surface that is not convex."""

    surface: Surface


Shape = Box | Cone | Ball | Polyhedron | Mesh


@dataclass(frozen=True, eq=False, slots=True)
class Slice:
    """The space between two planes across ``axis``: ``low <= axis @ x <= high``, axis a unit vector (3,).

    Attributes:
        centers_only: True where only the spheres' centres have to lie between the planes (a slice across
            gravity, so that layers interlock), False where whole spheres have to.
    """

    axis: Float64Array
    low: float
    high: float
    centers_only: bool

    def __post_init__(self) -> None:
        object.__setattr__(self, "axis", read_only(self.axis, np.float64, (3,), "slice.axis"))


@dataclass(frozen=True, eq=False, slots=True)
class Container:
    """The vessel that holds the bed.

    Attributes:
        name: What messages and decks call it.
        shape: What bounds the spheres, exactly.
        surface: The walls as triangles for decks and pictures: the mesh itself, or a tessellation of a
            primitive whose facets lie on or just outside the true wall.
        bounds: Lower and upper corner of its bounding box [m], shape (2, 3), float64.
        volume: Enclosed volume [m3]; of an open-topped mesh, up to its rim.
        periodic: Whether the box wraps around along x, y, z.
        walls_known: Whether these are the walls of the vessel. Nobody may know those of a bed from elsewhere:
            the box around its spheres stands for them.
        parts: The parts of ``surface`` that have names; what is left of it has none.
        cell: Vectors of a periodic cell of any shape as rows [m], shape (3, 3), from the origin: the
            container repeats along them, and not along x, y, z. ``periodic`` is true all round. None: it is
            no such cell.
    """

    name: str
    shape: Shape
    surface: Surface
    bounds: Float64Array
    volume: float
    periodic: tuple[bool, bool, bool] = (False, False, False)
    walls_known: bool = True
    parts: tuple[WallPart, ...] = ()
    cell: Float64Array | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "bounds", read_only(self.bounds, np.float64, (2, 3), "bounds"))
        if self.cell is not None:
            object.__setattr__(self, "cell", read_only(self.cell, np.float64, (3, 3), "cell"))

    @property
    def period(self) -> tuple[float | None, float | None, float | None]:
        """Lengths after which the container repeats along x, y, z [m]; None where it does not.

        A cell of any shape repeats along none of them: its spheres have images; see ``packgen.part``.
        """
        if self.cell is not None:
            return None, None, None
        x, y, z = (
            float(length) if wraps else None
            for length, wraps in zip(self.bounds[1] - self.bounds[0], self.periodic, strict=True)
        )
        return x, y, z

    @property
    def part_index(self) -> Int64Array:
        """Index into ``parts`` of each triangle of the surface, -1 of those without a name, shape (F,)."""
        index = np.full(len(self.surface.faces), -1, np.int64)
        for number, part in enumerate(self.parts):
            index[part.faces] = number
        return index


def floor_direction(gravity: Float64Array, periodic: tuple[bool, bool, bool]) -> Float64Array | None:
    """Return the direction in which something holds a bed: gravity without what is along periodic axes.

    Args:
        gravity: Gravity or its direction, shape (3,).
        periodic: Whether the container wraps around along x, y, z.

    Returns:
        Unit vector, shape (3,); None where nothing is left of gravity: the bed has no floor.
    """
    held = np.where(periodic, 0.0, np.asarray(gravity, float))
    strength = length(held)
    if not strength > FLOOR_SHARE_MIN * length(gravity):
        return None
    direction: Float64Array = held / strength
    return direction
