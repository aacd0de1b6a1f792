"""Advice where the unit of a mesh, or of a radius, seems wrong."""

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
    extent = container.bounds[1] - container.bounds[0]
    fitting = []
    for name, scale in LENGTHS.items():
        width = float(extent.min()) * scale / spec.scale
        if (
            name != spec.units
            and LIKELY[0] < width / (2.0 * radius_max)
            and width / (2.0 * radius_min) < LIKELY[1]
        ):
            fitting.append((abs(np.log10(scale)) % 3.0 > 0.0, name, extent * scale / spec.scale))
    found = f"{spec.path.name} is read in `units: {spec.units}`"
    if not fitting:
        return f"{found}; check them, and the units of the radii"
    # Metres and millimetres are what nearly all meshes are in.
    fitting.sort(key=lambda each: each[0])
    size = extent_text(np.stack([np.zeros(3), fitting[0][2]]))
    others = "".join(f" or {each[1]}" for each in fitting[1:])
    return f"{found}: did you mean {fitting[0][1]} ({size}){others}?"


def extent_text(bounds: Float64Array) -> str:
    """Return the size of a bounding box [m], shape (2, 3), as text."""
    x, y, z = bounds[1] - bounds[0]
    return f"{x:.4g} x {y:.4g} x {z:.4g} m"
