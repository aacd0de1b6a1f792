"""Sizes that no law draws: as large as the voids are, between two bounds."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array
from packgen.distributions.base import ParameterError, StepLaw

__all__ = ["Free"]


class Free(StepLaw):
    """Spheres as large as the voids that they fill.

    Nobody knows their radii before they are placed: as a law, this one has the least radius alone, and what
    is drawn from it stands for spheres still to be sized. An algorithm that sizes spheres by their voids says
    so in its settings (`free_sizes`).

    Attributes:
        radius_min: Least radius [m].
        radius_max: Largest radius [m]; None: as large as the largest void.
    """

    def __init__(self, radius_min: float, radius_max: float | None = None) -> None:
        """Check the bounds.

        Raises:
            ParameterError: The largest radius is below the least one.
        """
        if radius_max is not None and not 0.0 < radius_min <= radius_max:
            raise ParameterError((("radius_max",), radius_max, f"at least radius_min = {radius_min:g}"))
        self.radius_min, self.radius_max = radius_min, radius_max

    @property
    def radius(self) -> Float64Array:  # type: ignore[override]
        """The least radius [m], shape (1,)."""
        return np.array([self.radius_min])

    @property
    def number(self) -> Float64Array:  # type: ignore[override]
        """All spheres have at least that, shape (1,)."""
        return np.ones(1)
