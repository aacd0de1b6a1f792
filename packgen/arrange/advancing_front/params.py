"""The settings of ADVANCING_FRONT."""

from __future__ import annotations

from typing import ClassVar, Literal

from packgen.values import Keys, Tolerance


class Params(Keys):
    """Settings of ADVANCING_FRONT: spheres put one by one where they touch three others or walls.

    Attributes:
        rule: Where the next sphere goes: at the lowest stable place (lowest), or at the one nearest to the
            walls or, where an amount is asked for, to the middle of the zone (nearest).
        tolerance: Largest overlap that the check allows, as a fraction of the smaller radius; there is none
            beyond rounding.
    """

    zone_keys: ClassVar[frozenset[str]] = frozenset()
    holds: ClassVar[tuple[str, ...]] = ("fixed",)

    rule: Literal["nearest", "lowest"] = "nearest"
    tolerance: Tolerance = 1.0e-6
