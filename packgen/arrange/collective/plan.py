"""How thick the layers are."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from packgen.arrange.space.region import Region
from packgen.supply.supply import Supply

START_FRACTION = 0.6
"""Solid fraction at which a layer of equal spheres starts, overlapping: that of the finished bed. A layer of
broad sizes starts as much denser as these sizes pack."""


@dataclass(frozen=True, slots=True)
class LayerPlan:
    """How thick the layers are, in reference diameters (of the volume-weighted mean radius).

    Attributes:
        thickness: Thickness of a new layer.
        reopened: Depth below the surface to which spheres that came to rest move again with it.
        buffer: Depth below that to which fixed spheres are kept at hand.
        first: Thickness of the first layer over that of the others. Its lowest spheres must not move again
            with the second layer, whose weight would squeeze too many onto the floor.
    """

    thickness: float = 2.0
    reopened: float = 1.0
    buffer: float = 1.0
    first: float = 2.0

    def of_size(self, batch_size: int, supply: Supply, region: Region) -> LayerPlan:
        """Return a plan whose layers hold about ``batch_size`` spheres at half of a region's height.

        They are half a diameter to twenty thick: thinner ones make loose beds.
        """
        area = region.area(0.5 * (region.floor + region.ceiling))
        fraction = supply.solid_fraction(START_FRACTION)
        per_diameter = fraction * area * 2.0 * supply.radius_reference / supply.mean_volume
        thickness = float(np.clip(batch_size / per_diameter, 0.5, 20.0))
        # A first layer thinner than its spheres would have no room between the floor and its own top.
        return replace(self, thickness=thickness, first=max(1.0, 1.0 / thickness))
