"""What a scene file may say about the shape of a set's particles: a rigid clump of spheres.

One of a file of spheres, a mesh that spheres fill, or a parametric shape. Lengths of a shape give its
proportions: the set's law of sizes says how large each particle is.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Self

from pydantic import model_validator

from packgen.errors import PackgenError
from packgen.values import (
    FileOrCount,
    FilePath,
    Flag,
    InnerFraction,
    Keys,
    LengthUnit,
    NonNegativeLength,
    PositiveLength,
    fault,
)

if TYPE_CHECKING:
    from packgen.bodies import Template
    from packgen.clumps import Wanted

__all__ = ["ShapeSpec"]

MESHES = ("mesh", "cylinder", "ellipsoid", "cube")
"""Shapes that spheres fill, so that their number or an error has to be said."""


class DumbbellSpec(Keys):
    """Two equal spheres: their radius, and the distance of their centres [m]."""

    radius: PositiveLength
    distance: PositiveLength


class RodSpec(Keys):
    """A cylinder with round ends: its radius, and its length from tip to tip [m]."""

    radius: PositiveLength
    length: PositiveLength


class TetrapodSpec(Keys):
    """Four arms: their radius, and the distance of their ends' centres from the middle [m]."""

    radius: PositiveLength
    arm: PositiveLength


class RingSpec(Keys):
    """Spheres on a circle: the radius of the circle of their centres, and their diameter [m].

    Attributes:
        thickness: Diameter of the spheres [m]; 0: they touch their neighbours.
    """

    radius: PositiveLength
    thickness: NonNegativeLength = 0.0


class RoundBlockSpec(Keys):
    """A cylinder with flat ends: its radius and height [m]."""

    radius: PositiveLength
    height: PositiveLength


class EllipsoidSpec(Keys):
    """An ellipsoid: its full lengths along x, y and z [m]."""

    x: PositiveLength
    y: PositiveLength
    z: PositiveLength


class CubeSpec(Keys):
    """A cube with rounded edges: its side, and the radius of its edges [m]."""

    side: PositiveLength
    edge: PositiveLength


class ShapeSpec(Keys):
    """The shape of particles that are rigid clumps of spheres.

    Attributes:
        spheres: A file of rows ``x y z r``, as `packgen clump` writes it; beside another key, the number of
            spheres that a shape is made of.
        mesh: The closed mesh of a stone, which spheres fill.
        units: Unit of the mesh's coordinates.
        volume_error: Spheres are added until the volume that they miss is at most this share of the mesh's.
        surface_error: Spheres are added until the mesh's surface is nearer than this share of its diameter.
        least_radius: Least radius of a sphere before the clump is scaled [m].
        equal: Whether all spheres have one radius.
        best_fit: Whether spheres may stick out of the mesh.
        dumbbell: Two equal spheres.
        rod: A cylinder with round ends.
        tetrapod: Four arms.
        ring: Spheres on a circle.
        cylinder: A cylinder with flat ends, which spheres fill.
        ellipsoid: An ellipsoid, which spheres fill.
        cube: A cube with rounded edges, which spheres fill.
    """

    spheres: FileOrCount | None = None
    mesh: FilePath | None = None
    units: LengthUnit | None = None
    volume_error: InnerFraction | None = None
    surface_error: InnerFraction | None = None
    least_radius: NonNegativeLength | None = None
    equal: Flag | None = None
    best_fit: Flag | None = None
    dumbbell: DumbbellSpec | None = None
    rod: RodSpec | None = None
    tetrapod: TetrapodSpec | None = None
    ring: RingSpec | None = None
    cylinder: RoundBlockSpec | None = None
    ellipsoid: EllipsoidSpec | None = None
    cube: CubeSpec | None = None

    @model_validator(mode="after")
    def _one_form(self) -> Self:
        forms = ("mesh", "dumbbell", "rod", "tetrapod", "ring", "cylinder", "ellipsoid", "cube")
        given = [name for name in forms if getattr(self, name) is not None]
        by_file = isinstance(self.spheres, Path)
        if len(given) + by_file != 1:
            found = " and ".join([*given, *(["spheres with a file"] * by_file)]) or "none of them"
            place = given[1] if len(given) > 1 else "spheres" if by_file else ""
            raise fault((place, found, f"exactly one of spheres with a file, {', '.join(forms)}"))
        stray = [("units", "mesh")] if self.mesh is None else []
        if not given or given[0] not in MESHES:
            own = ("volume_error", "surface_error", "least_radius", "equal", "best_fit")
            stray += [(key, ", ".join(MESHES)) for key in own]
        faults = [
            (key, getattr(self, key), f"this key only beside {beside}")
            for key, beside in stray
            if getattr(self, key) is not None
        ]
        if faults:
            raise fault(*faults)
        limits = (self.spheres, self.volume_error, self.surface_error)
        if given and given[0] in MESHES and all(each is None for each in limits):
            raise fault(
                (given[0], "no number of spheres", "spheres, volume_error or surface_error beside it")
            )
        return self

    def template(self) -> Template:
        """Return the clump; its size is that of the file.

        Raises:
            ValueError: It cannot be made; a fault at its key.
        """
        # The maker's loops are compiled: a scene without clumps must not wait for them.
        from packgen import clumps

        try:
            if isinstance(self.spheres, Path):
                return clumps.read_template(self.spheres)
            if self.mesh is not None:
                clump = clumps.make_clump(self.mesh, self._wanted(), units=self.units or "m")
                return clump.template
            name, sizes = next((key, each) for key, each in self if isinstance(each, Keys))
            wanted = None if self.spheres is None and name not in MESHES else self._wanted()
            return clumps.make_clump(clumps.shape_of(name, _given(sizes)), wanted).template
        except (PackgenError, ValueError) as error:
            raise fault(*(("", *_halves(line)) for line in str(error).splitlines())) from error

    def _wanted(self) -> Wanted:
        from packgen.clumps import Wanted

        return Wanted(
            self.spheres if isinstance(self.spheres, int) else None,
            self.volume_error,
            self.surface_error,
            self.least_radius or 0.0,
            bool(self.equal),
            bool(self.best_fit),
        )


def _given(sizes: Keys) -> dict[str, float]:
    """Return the lengths of a shape; one of 0 is left to the shape's own default."""
    return {key: value for key, value in sizes if value != 0.0}


def _halves(text: str) -> tuple[str, str]:
    """Return what a sentence says was found, and what was expected."""
    before, parted, expected = text.partition(", expected ")
    place, said, found = before.partition("found ")
    place = place.strip().rstrip(":").removeprefix("clump: ")
    if not parted:
        return text, "a clump that can be made"
    return (f"{found} in {place}" if said and place else found if said else before), expected
