"""Named parts of a container's walls: what they are made of, and what becomes of them in a solver's run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array, read_only


@dataclass(frozen=True, eq=False, slots=True)
class Rotation:
    """Turning at a constant rate, counter-clockwise seen from the tip of the axis.

    Attributes:
        origin: A point of the axis [m], shape (3,).
        axis: Unit vector along it, shape (3,).
        period: Time of one turn [s].
    """

    origin: Float64Array
    axis: Float64Array
    period: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", read_only(self.origin, np.float64, (3,), "rotation.origin"))
        object.__setattr__(self, "axis", read_only(self.axis, np.float64, (3,), "rotation.axis"))


@dataclass(frozen=True, eq=False, slots=True)
class Translation:
    """Moving at a constant velocity [m/s], shape (3,)."""

    velocity: Float64Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "velocity", read_only(self.velocity, np.float64, (3,), "velocity"))


@dataclass(frozen=True, eq=False, slots=True)
class Vibration:
    """Swinging as a sine that starts in the middle.

    Attributes:
        amplitude: The way from the middle to one end [m], shape (3,).
        period: Time of one swing to and fro [s].
    """

    amplitude: Float64Array
    period: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "amplitude", read_only(self.amplitude, np.float64, (3,), "amplitude"))


Motion = Rotation | Translation | Vibration


@dataclass(frozen=True, eq=False, slots=True)
class WallPart:
    """A named part of a container's walls.

    Attributes:
        name: Its name.
        faces: The triangles of the container's surface that it has, indices, shape (K,), int64.
        material: Name of its material.
        remove: Whether a solver's run takes it away once the bed has come to rest.
        motion: How it moves in a solver's run; None: it stands still.
    """

    name: str
    faces: Int64Array
    material: str
    remove: bool = False
    motion: Motion | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "faces", read_only(self.faces, np.int64, (None,), "part.faces"))
