"""The constants by which layers of bodies come to rest."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

from packgen.arrange.projection.recipe import Recipe, Step
from packgen.portable import scalar_power

TOLERANCE = 1.0e-6
"""Largest overlap where none is asked for: bodies are parted in any case."""

RUB = 0.6
"""Friction while bodies are arranged, over that of the material: a contact that is pushed again in each sweep
grips more than its share of the weight would. With all of it a body has fewer contacts than it needs to
stand, and beds of dimers and tetrapods sink by two and three times as much in LAMMPS."""


@dataclass(frozen=True, slots=True)
class RigidRecipe(Recipe):
    """How bodies fall, slide on each other and come to rest; steps are relative to the bodies' sizes.

    Bodies start apart and fall nearly freely: a sweep is a step of time, in which gravity adds a step to the
    last one, and contacts take it off without rebound. Then gravity fades, so that the weight of the layer
    leaves no overlaps, and the last motion with it: slowly, for what lies squeezed under a strong one loses
    contacts as it springs back.

    Attributes:
        hold: Sweeps until gravity fades.
        calm: Momentum that is left when it has faded.
    """

    hold: int = 80
    calm: float = 0.9

    @classmethod
    def of_bodies(cls, friction: float, tolerance: float | None) -> Self:
        """Return the recipe of a bed about as dense as gravity would make it of bodies of some friction.

        Args:
            friction: Coefficient of sliding friction of body on body.
            tolerance: Largest overlap of the true spheres, as a fraction of the smaller radius; None: any.
        """
        return cls(
            tolerance=TOLERANCE if tolerance is None else tolerance,
            friction=RUB * friction,
            stride=0.3,
            sink_sweeps=240,
            sink_first=0.005,
            momentum=0.98,
            momentum_sweeps=1,
            give_up=(0.1, 0.05, 0.02, 0.008, 0.003, 0.001, 0.0004),
            give_up_first=252,
            far_sweeps=0,
            skin_first=1.0,
            skin_last=0.25,
        )

    def fall(self, number: int) -> float:
        """Return the step down before a sweep."""
        if number >= self.sink_sweeps:
            return Recipe.fall(self, number)
        return self.sink_last + self.sink_first * scalar_power(self._strength(number), 3)

    def step(self, number: int, *, rough: bool) -> Step:
        """Return how a sweep moves the bodies."""
        step = Recipe.step(self, number, rough=rough)
        return step._replace(momentum=self.calm + (self.momentum - self.calm) * self._strength(number))

    def _strength(self, number: int) -> float:
        """Return how strong gravity is in a sweep, from 1 to 0; its third power, to be exact."""
        return min(max((self.sink_sweeps - number) / (self.sink_sweeps - self.hold), 0.0), 1.0)
