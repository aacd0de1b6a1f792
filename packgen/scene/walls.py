"""What a scene file may say about the named parts of its walls; all in SI once read."""

from __future__ import annotations

from typing import Self

import numpy as np
from pydantic import model_validator

from packgen.geometry.parts import Motion, Rotation, Translation, Vibration
from packgen.units import LENGTHS
from packgen.values import (
    FilePath,
    Flag,
    Frequency,
    Keys,
    LengthUnit,
    Name,
    Period,
    Point,
    Positive,
    PrimitiveAxis,
    Unit3,
    Velocity,
    fault,
)

__all__ = ["LinearSpec", "MoveSpec", "RotateSpec", "VibrateSpec", "WallSpec"]

_ORIGIN: Unit3 = (0.0, 0.0, 0.0)
SECONDS_A_MINUTE = 60.0


def _one_of(spec: Keys, *names: str) -> None:
    """Refuse a mapping that has none or several of some keys.

    Raises:
        PydanticCustomError: It has.
    """
    given = [name for name in names if getattr(spec, name) is not None]
    if len(given) != 1:
        found = " and ".join(given) or "none of them"
        raise fault((given[1] if given else "", found, f"exactly one of {', '.join(names)}"))


class RotateSpec(Keys):
    """Turning at a constant rate, counter-clockwise seen from the tip of the axis.

    Attributes:
        axis: Direction of the axis.
        origin: A point of the axis.
        rpm: Turns a minute.
        period: Time of one turn; instead of ``rpm``.
    """

    axis: PrimitiveAxis
    origin: Point = _ORIGIN
    rpm: Positive | None = None
    period: Period | None = None

    @model_validator(mode="after")
    def _one_rate(self) -> Self:
        _one_of(self, "rpm", "period")
        return self

    @property
    def motion(self) -> Rotation:
        """The motion, in SI units."""
        period = SECONDS_A_MINUTE / self.rpm if self.rpm is not None else self.period
        assert period is not None
        return Rotation(np.array(self.origin), np.array(self.axis), period)


class LinearSpec(Keys):
    """Moving at a constant velocity.

    Attributes:
        velocity: The velocity.
    """

    velocity: Velocity

    @model_validator(mode="after")
    def _moves(self) -> Self:
        if not any(self.velocity):
            raise fault(("velocity", list(self.velocity), "a velocity that is not zero"))
        return self

    @property
    def motion(self) -> Translation:
        """The motion, in SI units."""
        return Translation(np.array(self.velocity))


class VibrateSpec(Keys):
    """Swinging as a sine that starts in the middle.

    Attributes:
        amplitude: The way from the middle to one end.
        frequency: Swings a second.
        period: Time of one swing to and fro; instead of ``frequency``.
    """

    amplitude: Point
    frequency: Frequency | None = None
    period: Period | None = None

    @model_validator(mode="after")
    def _one_rate(self) -> Self:
        if not any(self.amplitude):
            raise fault(("amplitude", list(self.amplitude), "an amplitude that is not zero"))
        _one_of(self, "frequency", "period")
        return self

    @property
    def motion(self) -> Vibration:
        """The motion, in SI units."""
        period = 1.0 / self.frequency if self.frequency is not None else self.period
        assert period is not None
        return Vibration(np.array(self.amplitude), period)


class MoveSpec(Keys):
    """How a part of the walls moves in a solver's run: one of these.

    Attributes:
        rotate: Turning about an axis.
        linear: Moving at a constant velocity.
        vibrate: Swinging to and fro.
    """

    rotate: RotateSpec | None = None
    linear: LinearSpec | None = None
    vibrate: VibrateSpec | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        _one_of(self, "rotate", "linear", "vibrate")
        return self

    @property
    def motion(self) -> Motion:
        """The motion, in SI units."""
        chosen = self.rotate or self.linear or self.vibrate
        assert chosen is not None
        return chosen.motion


class WallSpec(Keys):
    """A named part of the walls: it holds spheres as the container's own do, decks have a wall for it.

    Attributes:
        name: Its name.
        path: A triangle mesh; null: the solid or group of facets of that name in
            the container's file.
        units: Unit of the mesh's coordinates.
        material: Name of its material; null: that of the walls.
        remove: Whether the solver's run takes it away, after as many steps as it has.
        move: How it moves in the solver's run; null: it stands still.
    """

    name: Name
    path: FilePath | None = None
    units: LengthUnit = "m"
    material: Name | None = None
    remove: Flag = False
    move: MoveSpec | None = None

    @model_validator(mode="after")
    def _units_of_a_mesh(self) -> Self:
        if "units" in self.model_fields_set and self.path is None:
            raise fault(("units", self.units, "this key only beside path"))
        return self

    @property
    def scale(self) -> float:
        """Metres in one unit of the mesh coordinates."""
        return LENGTHS[self.units]

    @property
    def motion(self) -> Motion | None:
        """How it moves, in SI units; None: it stands still."""
        return None if self.move is None else self.move.motion
