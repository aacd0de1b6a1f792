"""The settings of VOID_FILLING."""

from __future__ import annotations

from typing import ClassVar

from packgen.values import InnerFraction, Keys, Tolerance


class Params(Keys):
    """Settings of VOID_FILLING: spheres without gravity, each into a void that takes it.

    Attributes:
        coverage: Solid fraction of the container at which it is full, earlier spheres included; without it,
            the zone's number of spheres ends it, or the least radius.
        tolerance: Largest overlap that the check allows, as a fraction of the smaller radius; there is none.
    """

    zone_keys: ClassVar[frozenset[str]] = frozenset()
    weightless: ClassVar[bool] = True
    may_change: ClassVar[str] = "nothing"
    free_sizes: ClassVar[str] = "zones"
    holds: ClassVar[tuple[str, ...]] = ("fixed",)

    coverage: InnerFraction | None = None
    tolerance: Tolerance = 1.0e-6
