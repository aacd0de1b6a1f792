"""Images of the spheres of a bed that wraps around: copies of those that reach across a seam."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.geometry.cells import cell_images, into_cell

if TYPE_CHECKING:
    from packgen.bed import Bed

__all__ = ["is_askew", "with_images", "with_owned_images"]

SHARE_ROUNDING = 1.0e-12  # component of a unit vector along an axis; a smaller one is rounding


def is_askew(along: Float64Array, periodic: tuple[bool, bool, bool]) -> bool:
    """Return whether a unit vector (3,) is neither along nor across an axis of a box that wraps around."""
    share = np.abs(np.asarray(along, float))[list(periodic)]
    return bool(((share >= SHARE_ROUNDING) & (share < 1.0 - SHARE_ROUNDING)).any())


def with_images(bed: Bed, along: Float64Array | None = None) -> tuple[Float64Array, Float64Array]:
    """Return a bed's spheres and, where its container is periodic, their images that reach into it.

    Args:
        bed: The bed.
        along: Unit normal of a slab's planes. A sphere that crosses a seam beside the slab counts as a whole,
            so that no images are made there. In a cell of any shape all images are made.

    Returns:
        Centres [m], shape (M, 3), float64, the bed's own first; radii [m], shape (M,), float64.

    Raises:
        ValueError: The slab is askew to a direction in which the container is periodic.
    """
    position, radius, _ = with_owned_images(bed, along)
    return position, radius


def with_owned_images(
    bed: Bed, along: Float64Array | None = None
) -> tuple[Float64Array, Float64Array, Int64Array]:
    """Return what `with_images` does, and the index in the bed of each sphere or image, shape (M,), int64."""
    position, radius, owner = bed.position, bed.radius, np.arange(bed.count)
    low, high = bed.container.bounds
    if bed.container.cell is not None:
        position = into_cell(position, bed.container.cell)
        images, of, _ = cell_images(position, bed.container.cell, radius)
        owner = np.concatenate([owner, of])
        return np.concatenate([position, images]), radius[owner], owner
    if along is not None and is_askew(along, bed.container.periodic):
        raise ValueError("slab: its planes are askew to a direction in which the container is periodic")
    for axis in range(3):
        share = 1.0 if along is None else abs(float(along[axis]))
        if not bed.container.periodic[axis] or share < SHARE_ROUNDING:
            continue
        step = (high[axis] - low[axis]) * np.eye(3)[axis]
        wrapped = position - step * np.floor((position[:, [axis]] - low[axis]) / step[axis])
        near_low = wrapped[:, axis] - radius < low[axis]
        near_high = wrapped[:, axis] + radius > high[axis]
        position = np.concatenate([wrapped, wrapped[near_low] + step, wrapped[near_high] - step])
        radius = np.concatenate([radius, radius[near_low], radius[near_high]])
        owner = np.concatenate([owner, owner[near_low], owner[near_high]])
    return position, radius, owner
