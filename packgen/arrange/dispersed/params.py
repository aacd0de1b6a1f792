"""The settings of DISPERSED."""

from __future__ import annotations

from typing import ClassVar

from packgen.values import Keys, Tolerance


class Params(Keys):
    """Settings of DISPERSED: spheres without gravity that touch nothing; fraction and gap stand in the zone.

    Attributes:
        tolerance: Largest overlap that the check allows, as a fraction of the smaller radius; there is none.
    """

    zone_keys: ClassVar[frozenset[str]] = frozenset({"solid_fraction", "porosity", "void_ratio", "gap"})
    weightless: ClassVar[bool] = True
    may_change: ClassVar[str] = "nothing"
    holds: ClassVar[tuple[str, ...]] = ("fixed",)

    tolerance: Tolerance = 1.0e-6
