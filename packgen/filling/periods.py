"""Whether a periodic box is long enough for its spheres, and for the algorithm that fills it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from packgen.arrange.traits import traits_of
from packgen.errors import PackingError
from packgen.geometry import Container

if TYPE_CHECKING:
    from packgen.scene import Scene

__all__ = ["check_periods"]

PERIOD_MIN = 4.0
"""Least length of a periodic box, in largest radii."""


def check_periods(scene: Scene, container: Container, reach: float) -> None:
    """Refuse a periodic box so short that a sphere meets another one twice, or that nothing can fill.

    Args:
        scene: The scene.
        container: Its container.
        reach: Largest radius, half the least gap included [m].

    Raises:
        PackingError: It is; a line a fault.
    """
    if not any(container.periodic):
        return
    place = scene.named("container.periodic")
    lengths = container.bounds[1] - container.bounds[0]
    traits = traits_of(scene.params)
    fitted = traits.fits_container  # then the algorithm knows how long it becomes
    least = PERIOD_MIN * reach
    faults = [
        f"{place}: found a box of {lengths[axis]:.4g} m along {'xyz'[axis]}, expected at least "
        f"{least:.4g} m, two diameters of the largest sphere, so that none meets another one twice; "
        f"make it longer or leave {'xyz'[axis]} out"
        for axis in np.flatnonzero(container.periodic)
        if lengths[axis] < least and not fitted
    ]
    unsupported = traits.unsupported
    faults += [
        f"{scene.named(path)}: {text}"
        for path, text in ([] if unsupported is None else unsupported(container))
    ]
    if faults:
        raise PackingError("\n".join(faults))
