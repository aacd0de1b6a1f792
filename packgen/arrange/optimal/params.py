"""The settings of OPTIMAL."""

from __future__ import annotations

from typing import ClassVar, Literal

from packgen.arrange.auto import AutoOrFlag
from packgen.values import Count, Keys, Positive, Tolerance


class Params(Keys):
    """Settings of OPTIMAL: which of some spheres, and where, fill a convex container best.

    Attributes:
        maximize: volume: the spheres chosen among those of the zone have the largest volume, radii as drawn;
            scale: all spheres of the zone are placed, and the common factor of their radii is largest.
        time_limit: Seconds after which the search ends and keeps its best.
        starts: Starts at most; each is improved by moves until none of many helps.
        agree: Starts that lead to the same best value before the search ends.
        proof: Whether a branch and bound proves that nothing is better, by the optional package pyscipopt;
            auto: up to seven spheres, where it is installed.
        tolerance: Largest overlap that the check allows, as a fraction of the smaller radius; there is none
            beyond rounding.
    """

    zone_keys: ClassVar[frozenset[str]] = frozenset()
    weightless: ClassVar[bool] = True
    any_amount: ClassVar[bool] = True

    maximize: Literal["volume", "scale"] = "volume"
    time_limit: Positive = 60.0
    starts: Count = 1000
    agree: Count = 10
    proof: AutoOrFlag = "auto"
    tolerance: Tolerance = 1.0e-6

    @property
    def may_change(self) -> str:
        """What it makes free of what the scene says."""
        return "count" if self.maximize == "volume" else "radii"
