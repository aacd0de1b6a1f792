"""A template: the spheres of one rigid clump, with the mass properties of the body that they stand for."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, read_only
from packgen.bodies.mass import MassProperties
from packgen.portable import cube_root


@dataclass(frozen=True, eq=False, slots=True)
class Template:
    """Spheres in the frame of their body, whose origin is the body's centre of mass.

    Attributes:
        name: What decks and messages call it.
        spheres: Centres and radii [m], shape (N, 4), float64.
        volume: Volume of the body [m3].
        inertia: Inertia tensor of the body about the origin, a unit of density [m5], shape (3, 3), float64.
        place: Where the body's centre of mass was in the file of its mesh [m], shape (3,), float64; the
            axes are those of the mesh.
    """

    name: str
    spheres: Float64Array
    volume: float
    inertia: Float64Array
    place: Float64Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "spheres", read_only(self.spheres, np.float64, (None, 4), "spheres"))
        object.__setattr__(self, "inertia", read_only(self.inertia, np.float64, (3, 3), "inertia"))
        object.__setattr__(self, "place", read_only(self.place, np.float64, (3,), "place"))

    @property
    def count(self) -> int:
        """Number of spheres."""
        return len(self.spheres)

    @property
    def properties(self) -> MassProperties:
        """Volume, centre and inertia of the body, in this frame."""
        return MassProperties(self.volume, np.zeros(3), self.inertia)

    @property
    def equivalent_diameter(self) -> float:
        """Diameter of the sphere of the body's volume [m]."""
        return self.properties.equivalent_diameter

    @property
    def equivalent_radius(self) -> float:
        """Radius of the sphere of the body's volume [m], alike on all machines."""
        return cube_root(self.volume / (4.0 / 3.0 * math.pi))

    @property
    def reach(self) -> float:
        """Radius of the sphere about the centre of mass that holds all spheres [m]."""
        return float((np.linalg.norm(self.spheres[:, :3], axis=1) + self.spheres[:, 3]).max())

    def scaled(self, factor: float) -> Template:
        """Return the template of the body with all lengths multiplied by a factor."""
        return Template(
            self.name,
            self.spheres * factor,
            self.volume * factor**3,
            self.inertia * factor**5,
            self.place * factor,
        )


def is_sphere(template: Template) -> bool:
    """Return whether a template is a sphere: one about its centre of mass, and no other body."""
    if template.count > 1:
        return False
    x, y, z, radius = template.spheres[0]
    off = math.sqrt(x * x + y * y + z * z)
    return bool(off <= 1e-9 * radius and abs(template.equivalent_radius / radius - 1.0) <= 1e-9)
