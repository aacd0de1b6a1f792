"""The settings of JAMMED."""

from __future__ import annotations

from typing import ClassVar, Literal

from packgen.arrange.auto import AutoOrFlag
from packgen.values import Flag, InnerFraction, Keys, Tolerance


class Params(Keys):
    """Settings of JAMMED: spheres without gravity, pressed together until nothing can move.

    Attributes:
        adjust: What gives way so that the drawn radii stay: the container, all of whose lengths are
            multiplied by one factor, or the number of spheres, which then follows from the container.
        phi_start: Solid fraction at which equal spheres, soft and placed at random, are quenched, away from
            walls; 0.65 to 0.68 give beds of 0.637 to 0.641. Other sizes start at the same share of their
            random close packing.
        swap: Whether spheres change places while they are quenched where that relieves them: broad size laws
            become denser. It takes longer.
        certificate: Whether linear programmes prove that the bed is jammed; auto: up to 2,000 spheres.
        tolerance: Largest overlap that the check allows, as a fraction of the smaller radius; there is none
            beyond rounding.
    """

    zone_keys: ClassVar[frozenset[str]] = frozenset()
    weightless: ClassVar[bool] = True

    adjust: Literal["container", "count"] = "container"
    phi_start: InnerFraction = 0.66
    swap: Flag = False
    certificate: AutoOrFlag = "auto"
    tolerance: Tolerance = 1.0e-6

    @property
    def may_change(self) -> str:
        """What gives way of what the scene says."""
        return self.adjust

    @property
    def fits_container(self) -> bool:
        """Whether the container takes the size that the spheres need."""
        return self.adjust == "container"
