"""Exact solid fractions of regions of a bed: boxes, slabs, cylindrical shells, the whole container."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed, with_images
from packgen.measure.core import Core
from packgen.measure.fraction import solid_volume
from packgen.measure.particles import in_grains, particle_radius
from packgen.measure.radial import solid_in_cylinders
from packgen.measure.volumes import container_volume_below, sphere_volume, volume_below


def container_fraction(bed: Bed) -> float:
    """Return the solid fraction of the whole container, whatever part of it the bed fills.

    Args:
        bed: The bed; its spheres are inside the container and do not overlap.

    Returns:
        Volume of the spheres over the container's volume.
    """
    return float(sphere_volume(particle_radius(bed)).sum()) / bed.container.volume


def box_fraction(bed: Bed, low: Float64Array, high: Float64Array) -> float:
    """Return the solid fraction of an axis-parallel box, spheres cut exactly by its faces.

    Args:
        bed: The bed; where its container is periodic, the box lies in the container.
        low: Lower corner [m], shape (3,), float64.
        high: Upper corner [m], shape (3,), float64.

    Returns:
        Solid volume in the box over the box's volume, whether the container reaches as far or not; see
        `packgen.measure.solid_volume` for its source.

    Raises:
        ValueError: The box has no volume.
    """
    low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    if not (high > low).all():
        raise ValueError(f"box from {low} to {high}: expected a volume; give the lower corner first")
    box = Core(0.5 * (low + high), np.eye(3), 0.5 * (high - low), "a box")
    position, radius = with_images(in_grains(bed))
    return solid_volume(position, radius, box) / box.volume


def slab_fraction(bed: Bed, axis: Float64Array, low: float, high: float) -> float:
    """Return the solid fraction of what two parallel planes cut out of the container.

    Args:
        bed: The bed.
        axis: Normal of the planes, any length but 0, shape (3,), float64.
        low: Place of the lower plane, ``axis @ x`` with the unit normal [m].
        high: Place of the upper plane [m].

    Returns:
        Solid volume between the planes, spheres cut exactly (caps of `packgen.measure.volumes.volume_below`),
        over the container's volume between them (`packgen.measure.volumes.container_volume_below`).

    Raises:
        ValueError: The container has no volume between the planes, or is periodic in a direction that is
            neither along nor across ``axis``.
    """
    axis = np.asarray(axis, dtype=np.float64)
    axis = axis / np.linalg.norm(axis)
    room = float(np.diff(container_volume_below(bed.container, axis, np.array([low, high])))[0])
    if not room > 0.0:
        raise ValueError(f"slab from {low:g} to {high:g} m: the container has no volume there")
    position, radius = with_images(in_grains(bed), along=axis)
    place = position @ axis
    solid = volume_below(place, radius, high).sum() - volume_below(place, radius, low).sum()
    return float(solid) / room


def shell_fraction(
    bed: Bed,
    center: Float64Array,
    axis: Float64Array,
    radii: tuple[float, float],
    bounds: tuple[float, float],
) -> float:
    """Return the solid fraction of a cylindrical shell, spheres cut exactly by its four surfaces.

    Args:
        bed: The bed.
        center: A point of the shell's axis [m], shape (3,), float64.
        axis: Direction of the axis, any length but 0, shape (3,), float64.
        radii: Inner and outer radius [m]; 0 within makes a full cylinder.
        bounds: Where the shell begins and ends, ``axis @ x`` with the unit vector [m].

    Returns:
        Solid volume in the shell over the shell's volume, whether the container reaches as far or not; see
        `packgen.measure.cylinders` for source and error.

    Raises:
        ValueError: The shell has no volume.
    """
    inner, outer = radii
    if not (0.0 <= inner < outer and bounds[0] < bounds[1]):
        raise ValueError(
            f"shell between {inner:g} and {outer:g} m, from {bounds[0]:g} to {bounds[1]:g} m: no volume"
        )
    axis = np.asarray(axis, dtype=np.float64)
    axis = axis / np.linalg.norm(axis)
    position, radius = with_images(in_grains(bed))
    inside, outside = solid_in_cylinders(
        position, radius, np.asarray(center, dtype=np.float64), axis, np.array([inner, outer]), bounds
    )
    room = np.pi * (outer**2 - inner**2) * (bounds[1] - bounds[0])
    return float((outside - inside) / room)
