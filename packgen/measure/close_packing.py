"""A bed's solid fraction beside what its sizes fill at random, and what its walls cost."""

from __future__ import annotations

from dataclasses import dataclass

from packgen.bed import AnyBed, Bed, has_clumps
from packgen.measure.fraction import SolidFraction, against_gravity
from packgen.measure.volumes import mean_diameter, wall_area_below
from packgen.supply.close_packing import close_packing_fraction, wall_loss


@dataclass(frozen=True, slots=True)
class ClosePacking:
    """Random close packing of a bed's spheres.

    Attributes:
        fraction: Solid fraction of a random close packing of the bed's radii, without walls (Farr and Groot,
            J. Chem. Phys. 131 (2009) 244104).
        reached: Share of it that the bed has.
        of: What `reached` was measured in: `core`, or `filled` where the bed has no core.
        wall_loss: Share of the solid fraction that the walls and the floor are expected to cost the filled
            volume against the core.
    """

    fraction: float
    reached: float
    of: str
    wall_loss: float


def close_packing(bed: Bed, solid: SolidFraction) -> ClosePacking | None:
    """Return how far a bed is from random close packing.

    Args:
        bed: The bed.
        solid: Its solid fractions.

    Returns:
        The figures; None of a bed without spheres, and of one with clumps.
    """
    if bed.count == 0 or has_clumps(bed) or solid.filled_volume <= 0.0:
        return None
    return beside_close_packing(bed, solid, close_packing_fraction(bed.radius), mean_diameter(bed.radius))


def beside_close_packing(bed: AnyBed, solid: SolidFraction, fraction: float, diameter: float) -> ClosePacking:
    """Return how far a bed is from the random close packing of its spheres, which is known.

    Args:
        bed: The bed.
        solid: Its solid fractions.
        fraction: The solid fraction of the random close packing.
        diameter: Mean diameter of the spheres by volume [m].
    """
    area = wall_area_below(bed.container, against_gravity(bed), solid.top)
    of, own = ("filled", solid.filled) if solid.core is None else ("core", solid.core)
    loss = wall_loss(area, solid.filled_volume, diameter)
    return ClosePacking(fraction, own / fraction, of, loss)
