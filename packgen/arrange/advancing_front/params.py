"""The settings of ADVANCING_FRONT."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

from pydantic import model_validator

from packgen.values import InnerFraction, Keys, PositiveLength, Tolerance, fault


class FillSpec(Keys):
    """Spheres in the voids that the front leaves, as a set of their own with `radius_distribution: free`.

    Attributes:
        radius_min: Least radius.
        radius_max: Largest radius; left out: that of the largest sphere drawn.
        until: Solid fraction of the zone at which no more are placed; left out: none.
    """

    radius_min: PositiveLength
    radius_max: PositiveLength | None = None
    until: InnerFraction | None = None

    @model_validator(mode="after")
    def _bounds_in_order(self) -> Self:
        if self.radius_max is not None and self.radius_max < self.radius_min:
            raise fault(("radius_max", self.radius_max, f"at least radius_min = {self.radius_min:g}"))
        return self


class Params(Keys):
    """Settings of ADVANCING_FRONT: spheres put one by one where they touch three others or walls.

    Attributes:
        rule: Where the next sphere goes: to the lowest place where its contacts bear it (lowest), or to the
            one nearest to the zone's lowest corner, where the front begins (nearest).
        fill: Spheres for the voids; left out: none.
        tolerance: Largest overlap that the check allows, as a fraction of the smaller radius; there is none
            beyond rounding.
    """

    zone_keys: ClassVar[frozenset[str]] = frozenset()
    may_change: ClassVar[str] = "nothing"
    holds: ClassVar[tuple[str, ...]] = ("fixed",)

    rule: Literal["nearest", "lowest"] = "nearest"
    fill: FillSpec | None = None
    tolerance: Tolerance = 1.0e-6

    @property
    def free_sizes(self) -> str | None:
        """Where spheres of free sizes go: into what ``fill`` fills; None: nowhere."""
        return None if self.fill is None else "fill"
