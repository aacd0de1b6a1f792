"""The settings of SHRINKING_CELL."""

from __future__ import annotations

from typing import ClassVar

from packgen.values import Count, InnerFraction, Keys, Positive, Tolerance


class Params(Keys):
    """Settings of SHRINKING_CELL: the densest periodic cell of a few spheres, its shape free.

    Attributes:
        starts: Random cells from which it is sought; the densest of what they lead to is the bed.
        phi_start: Solid fraction of the random cells.
        influence: Distance of surfaces up to which a step keeps spheres apart, in largest diameters: small
            values lead to disordered cells, large ones to dense cells.
        move: Largest move of a sphere along an axis in the first steps, in largest diameters.
        tolerance: Largest overlap that the check allows, as a fraction of the smaller radius; there is none
            beyond rounding.
    """

    zone_keys: ClassVar[frozenset[str]] = frozenset()
    weightless: ClassVar[bool] = True
    free_cell: ClassVar[bool] = True
    fits_container: ClassVar[bool] = True
    may_change: ClassVar[str] = "container"

    starts: Count = 50
    phi_start: InnerFraction = 0.1
    influence: Positive = 1.0
    move: Positive = 0.3
    tolerance: Tolerance = 1.0e-6
