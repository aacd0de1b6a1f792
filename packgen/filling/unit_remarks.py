"""Advice where the unit of a mesh, or of a radius, seems wrong, and the guess where nobody has said it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from packgen.arrays import Float64Array
from packgen.geometry import Container
from packgen.units import LENGTHS

if TYPE_CHECKING:
    from packgen.scene import Scene

LIKELY = (3.0, 500.0)
"""Usual width of a container: at least in largest diameters, at most in smallest ones."""

USUAL = (0.01, 50.0)
"""Usual size of a container [m] where the spheres are not known."""


def units_remark(scene: Scene, container: Container, radius_min: float, radius_max: float) -> str:
    """Return what to check where container and spheres do not go together.

    Args:
        scene: The scene.
        container: Its container.
        radius_min: Smallest radius [m].
        radius_max: Largest radius [m].

    Returns:
        The end of a sentence; of a mesh it names the units that would make sense, likeliest first.
    """
    spec = scene.container
    if spec.path is None:
        return "check the units of the container's lengths and of the radii"
    extent = (container.bounds[1] - container.bounds[0]) / spec.scale
    fitting = [
        name for name in likely_units(float(extent.min()), radius_min, radius_max) if name != spec.units
    ]
    found = f"{spec.path.name} is read in `units: {spec.units}`"
    if not fitting:
        return f"{found}; check them, and the units of the radii"
    size = extent_text(np.stack([np.zeros(3), extent * LENGTHS[fitting[0]]]))
    others = "".join(f" or {each}" for each in fitting[1:])
    return f"{found}: did you mean {fitting[0]} ({size}){others}?"


def likely_units(width: float, radius_min: float, radius_max: float) -> list[str]:
    """Return the units in which a container has a usual width for its spheres, likeliest first.

    Args:
        width: Its least extent, in the unit sought.
        radius_min: Smallest radius [m].
        radius_max: Largest radius [m].
    """
    fitting = [
        name
        for name, scale in LENGTHS.items()
        if LIKELY[0] < width * scale / (2.0 * radius_max) and width * scale / (2.0 * radius_min) < LIKELY[1]
    ]
    return sorted(fitting, key=_rarity)


def usual_units(size: float) -> list[str]:
    """Return the units in which a container of some largest extent is a usual vessel, likeliest first."""
    fitting = [name for name, scale in LENGTHS.items() if USUAL[0] <= size * scale <= USUAL[1]]
    return sorted(fitting, key=_rarity)


def _rarity(unit: str) -> bool:
    """Return whether a unit is a rare one: metres and millimetres are what nearly all meshes are in."""
    return bool(abs(np.log10(LENGTHS[unit])) % 3.0 > 0.0)


def extent_text(bounds: Float64Array) -> str:
    """Return the size of a bounding box [m], shape (2, 3), as text."""
    x, y, z = bounds[1] - bounds[0]
    return f"{x:.4g} x {y:.4g} x {z:.4g} m"
