"""How the solid fraction runs along the height of a bed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed, is_askew, with_images
from packgen.geometry import Container
from packgen.measure.fraction import against_gravity
from packgen.measure.particles import in_grains, particle_radius
from packgen.measure.volumes import container_volume_below, mean_diameter, sphere_volume, volume_below

SLABS_MAX = 60
SLABS_MIN = 4


@dataclass(frozen=True, slots=True)
class HeightProfile:
    """Solid fraction of the slabs of a bed, from the container's floor to the bed's highest point.

    Of a bed that is endless or without gravity, from one side of the container to the other.

    Attributes:
        height: Bounds of the slabs along the direction against gravity [m], one more than slabs.
        solid_fraction: Solid fraction of each slab, spheres cut exactly by its bounds; None where the
            container has no volume there.
    """

    height: tuple[float, ...]
    solid_fraction: tuple[float | None, ...]


def height_profile(bed: Bed) -> HeightProfile:
    """Return the solid fraction of a bed along its height.

    Slabs are one mean diameter (by volume) thick, thicker where that would make more than `SLABS_MAX`.

    Args:
        bed: The bed.

    Returns:
        The profile; empty for a bed without spheres, and for an endless one whose gravity is askew.
    """
    if bed.container.cell is not None or (bed.endless and is_askew(bed.down, bed.container.periodic)):
        return HeightProfile((), ())
    whole, bed = bed, in_grains(bed)
    sound = np.isfinite(bed.position).all(axis=1) & np.isfinite(bed.radius) & (bed.radius > 0.0)
    if not sound.any():
        return HeightProfile((), ())
    up = against_gravity(bed)
    position, radius = bed.position[sound], bed.radius[sound]
    diameter = mean_diameter(radius) if whole is bed else mean_diameter(particle_radius(whole))
    corners = bed.container.surface.vertices @ up
    low, high = float(corners.min()), float((position @ up + radius).max())
    if not bed.rests:
        position, radius = with_images(bed, along=up)
        high = float(corners.max())
    level = slab_bounds(low, high, diameter)
    return profile_of(bed.container, up, level, solid_below(position @ up, radius, level))


def slab_bounds(low: float, high: float, diameter: float) -> Float64Array:
    """Return the bounds [m] of slabs between two heights, for spheres of a mean diameter; rising."""
    return np.linspace(low, high, int(np.clip((high - low) / diameter, SLABS_MIN, SLABS_MAX)) + 1)


def profile_of(
    container: Container, up: Float64Array, level: Float64Array, below: Float64Array
) -> HeightProfile:
    """Return the profile of a bed of which these are known.

    Args:
        container: The vessel.
        up: Unit vector against gravity, shape (3,).
        level: Bounds of the slabs [m], shape (L,).
        below: Solid volume below each of them [m3], shape (L,).
    """
    room = np.diff(container_volume_below(container, up, level))
    least = 1e-9 * float(room.max())
    return HeightProfile(
        tuple(level.tolist()),
        tuple(
            float(part / of) if of > least else None for part, of in zip(np.diff(below), room, strict=True)
        ),
    )


def solid_below(height: Float64Array, radius: Float64Array, level: Float64Array) -> Float64Array:
    """Return the solid volume [m3] below each of some rising levels, shape of ``level``, float64."""
    order = np.argsort(height)
    height, radius = height[order], radius[order]
    whole = np.concatenate([[0.0], np.cumsum(sphere_volume(radius))])
    reach = float(radius.max())
    # Only spheres near a level are cut by it; those further down count as a whole.
    first = np.searchsorted(height, level - reach)
    last = np.searchsorted(height, level + reach)
    return np.array(
        [
            whole[low] + volume_below(height[low:high], radius[low:high], float(at)).sum()
            for low, high, at in zip(first, last, level, strict=True)
        ]
    )
