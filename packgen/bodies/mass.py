"""What a rigid body weighs, where, and how it turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, read_only


@dataclass(frozen=True, eq=False, slots=True)
class MassProperties:
    """What a body of density 1 weighs, where, and how it turns.

    Attributes:
        volume: Volume [m3].
        centre: Centre of mass [m], shape (3,), float64.
        inertia: Inertia tensor about the centre, a unit of density [m5], shape (3, 3), float64.
    """

    volume: float
    centre: Float64Array
    inertia: Float64Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre", read_only(self.centre, np.float64, (3,), "centre"))
        object.__setattr__(self, "inertia", read_only(self.inertia, np.float64, (3, 3), "inertia"))

    @property
    def equivalent_diameter(self) -> float:
        """Diameter of the sphere of this volume [m]."""
        return float(np.cbrt(6.0 * self.volume / np.pi))

    def principal(self) -> tuple[Float64Array, Float64Array]:
        """Return the principal moments [m5], rising, shape (3,), and their axes as columns, right-handed."""
        moments, axes = np.linalg.eigh(self.inertia)
        axes[:, 2] = np.cross(axes[:, 0], axes[:, 1])
        return moments, axes

    def moved(self, by: Float64Array) -> MassProperties:
        """Return the properties of the body moved by a vector (3,) [m]."""
        return MassProperties(self.volume, self.centre + by, self.inertia)
