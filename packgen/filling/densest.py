"""What a room holds of some sizes: at most, and as a poured bed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from packgen.arrays import Float64Array
from packgen.distributions import UNIT_VOLUME
from packgen.geometry import Container
from packgen.supply.close_packing import EQUAL_SPHERES, close_packing_fraction, wall_loss

DENSEST = float(np.pi / np.sqrt(18.0))
"""Solid fraction that no packing of equal spheres exceeds (Hales, Ann. Math. 162, 2005, 1065)."""

DENSEST_MIXED = 1.0 - (1.0 - DENSEST) ** 2
"""The same for two sizes in the limit of a large ratio: small spheres fill the hollows of large ones."""

HOLLOW_RATIO = float(1.0 + np.sqrt(2.0))
"""Ratio of radii from which a sphere fits into the octahedral hollow of the densest packing."""

FEW = 8.0
"""Volume of a zone [largest spheres] below which no bound holds: one sphere may fill its vessel."""

NARROW = 2.0
"""Width of a zone [largest diameters] below which its walls may put the spheres in order."""

SLACK, SCATTER = 1.01, 0.5
"""A random packing exceeds the fraction of random close packing by less than a factor `SLACK` +
`SCATTER` / sqrt(n) where n of the largest spheres make the volume. That of 1,000 equal spheres varies by
0.0015; the margin is more than six times as wide."""

POURED = 0.6
"""Solid fraction of a poured bed of equal spheres away from its walls."""


@dataclass(frozen=True)
class Sizes:
    """Sizes and how many spheres have each.

    Attributes:
        radius: Radii [m], shape (k,), float64.
        weight: Numbers, in proportion, shape (k,), float64.
        radius_min: Smallest radius that may come [m].
        radius_max: Largest radius that may come [m].
    """

    radius: Float64Array
    weight: Float64Array
    radius_min: float
    radius_max: float

    @cached_property
    def close_packing(self) -> float:
        """Solid fraction of a random close packing."""
        return close_packing_fraction(self.radius, self.weight)

    @property
    def diameter(self) -> float:
        """Mean diameter by volume [m]."""
        volume = self.weight * self.radius**3
        return 2.0 * float((volume * self.radius).sum() / volume.sum())


def together(zones: Sequence[tuple[Sizes, float]]) -> Sizes:
    """Return the sizes of several zones with their numbers of spheres."""
    used = [(sizes, count / sizes.weight.sum()) for sizes, count in zones if count > 0.0]
    return Sizes(
        np.concatenate([sizes.radius for sizes, _ in used]),
        np.concatenate([part * sizes.weight for sizes, part in used]),
        min(sizes.radius_min for sizes, _ in used),
        max(sizes.radius_max for sizes, _ in used),
    )


def densest_ordered(room: float, sizes: Sizes) -> float:
    """Return the solid fraction of a volume [m3] that no packing of some sizes exceeds."""
    if room < FEW * UNIT_VOLUME * sizes.radius_max**3:
        return 1.0
    return DENSEST if sizes.radius_max < HOLLOW_RATIO * sizes.radius_min else DENSEST_MIXED


def densest_random(room: float, width: float, sizes: Sizes) -> float:
    """Return the solid fraction of a zone that no random packing of some sizes exceeds.

    Args:
        room: Its volume [m3].
        width: Its least extent [m].
        sizes: The sizes.
    """
    ordered = densest_ordered(room, sizes)
    if width < NARROW * 2.0 * sizes.radius_max:
        return ordered
    number = room / (UNIT_VOLUME * sizes.radius_max**3)
    return min(ordered, sizes.close_packing * (SLACK + SCATTER / float(np.sqrt(number))))


def poured_fraction(container: Container, sizes: Sizes) -> float:
    """Return the solid fraction that a poured bed of some sizes has in a container, walls included."""
    from packgen.measure.volumes import wall_area_below

    up = np.array([0.0, 0.0, 1.0])
    area = wall_area_below(container, up, float(container.bounds[1, 2]) + 1.0)
    loss = wall_loss(area, container.volume, sizes.diameter)
    return POURED * sizes.close_packing / EQUAL_SPHERES * (1.0 - loss)
