"""A periodic container's spheres with what reaches into it across its seams."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed


def with_images(bed: Bed, along: Float64Array | None = None) -> tuple[Float64Array, Float64Array]:
    """Return a bed's spheres and, where its container is periodic, their images that reach into it.

    Args:
        bed: The bed.
        along: Unit vector across the planes of a slab: what a sphere has beyond a seam beside the slab counts
            with the sphere, so that no images are made there.

    Returns:
        Centres [m], shape (M, 3), float64, the bed's own first; radii [m], shape (M,), float64.

    Raises:
        ValueError: The slab is askew to a direction in which the container is periodic.
    """
    position, radius = bed.position, bed.radius
    low, high = bed.container.bounds
    for axis in range(3):
        share = 1.0 if along is None else abs(float(along[axis]))
        if not bed.container.periodic[axis] or share < 1e-12:
            continue
        if share < 1.0 - 1e-12:
            raise ValueError("slab: its planes are askew to a direction in which the container is periodic")
        step = (high[axis] - low[axis]) * np.eye(3)[axis]
        wrapped = position - step * np.floor((position[:, [axis]] - low[axis]) / step[axis])
        near_low = wrapped[:, axis] - radius < low[axis]
        near_high = wrapped[:, axis] + radius > high[axis]
        position = np.concatenate([wrapped, wrapped[near_low] + step, wrapped[near_high] - step])
        radius = np.concatenate([radius, radius[near_low], radius[near_high]])
    return position, radius
