"""Whether clumps fit where they are to go: told before a long run starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from packgen.bodies import fits_within
from packgen.errors import PackingError
from packgen.geometry import Container, floor_direction

if TYPE_CHECKING:
    from packgen.scene import Scene

__all__ = ["check_clumps", "has_clumps", "slenderness_of"]

RARE = 1.0e-3
"""Share of the particles, the largest, that may be too wide: they stay without a place."""


def has_clumps(scene: Scene) -> bool:
    """Return whether any particles of a scene are clumps."""
    return any(each.form is not None for each in scene.particle_sets)


def slenderness_of(scene: Scene) -> float:
    """Return how far the most slender particles reach, in radii of spheres of their volume."""
    forms = [each.form for each in scene.particle_sets if each.form is not None]
    return max((each.template.reach / each.template.equivalent_radius for each in forms), default=1.0)


def check_clumps(scene: Scene, container: Container, device: str = "cpu") -> None:
    """Refuse a container that clumps cannot fill.

    Args:
        scene: The scene.
        container: Its container.
        device: Where it is to be packed.

    Raises:
        PackingError: It has no floor, or a set's clumps fit into it in no orientation; a line a fault.
    """
    if not has_clumps(scene):
        return
    faults = too_wide(scene, container)
    gravity = np.asarray(scene.gravity_direction, float)
    if floor_direction(gravity, container.periodic) is None:
        faults.append(
            f"{scene.named('container.periodic')}: found a box that wraps around along gravity, expected a "
            "floor: not supported yet with clumps"
        )
    if device != "cpu":
        faults.append(f"--device: found {device}, expected cpu: not supported yet with clumps")
    if faults:
        raise PackingError("\n".join(faults))


def too_wide(scene: Scene, container: Container) -> list[str]:
    """Return a line for each set whose clumps fit into the container in no orientation."""
    extent = container.bounds[1] - container.bounds[0]
    room = np.where(container.periodic, np.inf, extent)
    faults = []
    for index, each in enumerate(scene.particle_sets):
        if each.form is None:
            continue
        template = each.form.template
        size = float(each.distribution.quantile(np.array([1.0 - RARE]))[0])
        if fits_within(template.spheres * (size / template.equivalent_radius), room):
            continue
        x, y, z = (f"{each:.4g}" for each in extent)
        reach = 2.0 * size / template.equivalent_radius * template.reach
        place = scene.named(f"particle_sets[{index}]")
        faults.append(
            f"{place}: found clumps up to {reach:.4g} m long, wider than the "
            f"container however they are turned ({x} x {y} x {z} m); expected smaller ones, or a larger "
            "container"
        )
    return faults
