"""Volumes of spheres inside circular cylinders, and inside such cylinders between two planes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from packgen.arrays import Float64Array

NEAR_AXIS = 1.0e-9  # of the cylinder's radius: nearer to the axis, closed forms divide by zero
NEAR_SURFACE = 1.0e-5  # of the sphere's radius: a centre so near to the cylinder is interpolated
NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)


def volume_in_cylinder(distance: Float64Array, radius: Float64Array, cylinder: Float64Array) -> Float64Array:
    """Return the volume of spheres inside endless circular cylinders.

    The closed form by complete elliptic integrals is that of Lamarche and Leroy (Comput. Phys. Commun. 59,
    1990, 359); the integrals are taken in Carlson's forms (Carlson, Numer. Algorithms 10, 1995, 13). Its
    rounding error is below 1e-9 of the sphere's volume.

    Args:
        distance: Distances of the spheres' centres from the cylinders' axes [m], shape (N,), float64.
        radius: Sphere radii [m], shape (N,), float64.
        cylinder: Cylinder radii [m], shape (N,), float64.

    Returns:
        Volumes inside [m3], shape (N,), float64.
    """
    volume = np.where(distance < cylinder, 4.0 / 3.0 * np.pi * radius**3, 0.0)
    cut = np.flatnonzero((np.abs(distance - cylinder) < radius) & (cylinder > 0.0))
    if len(cut) == 0:
        return volume
    b, c = distance[cut] / radius[cut], cylinder[cut] / radius[cut]
    b = np.maximum(b, NEAR_AXIS * c)
    found = np.empty(len(cut))
    near = np.abs(b - c) < NEAR_SURFACE
    found[~near] = _unit_volume(b[~near], c[~near])
    if near.any():  # the closed form is a difference of infinite terms there
        at, c = b[near], c[near]
        inner, outer = np.maximum(at - 1.01 * NEAR_SURFACE, 0.5 * at), at + 1.01 * NEAR_SURFACE
        low, high = _unit_volume(at, inner), _unit_volume(at, outer)
        found[near] = low + (high - low) * (c - inner) / (outer - inner)
    volume[cut] = np.clip(found, 0.0, 4.0 / 3.0 * np.pi) * radius[cut] ** 3
    return volume


def _unit_volume(b: Float64Array, c: Float64Array) -> Float64Array:
    """Volume of a unit sphere, its centre ``b`` from the axis, inside a cylinder of radius ``c``."""
    from scipy.special import elliprd, elliprf, elliprj

    far, near, across = (b + c) ** 2, (b - c) ** 2, (b + c) * (b - c)
    through = far < 1.0  # the cylinder leaves the sphere by its two ends only
    top, low = np.where(through, 1.0, far), np.where(through, far, 1.0)
    complement = np.maximum((top - low) / (top - near), 1e-30)
    modulus = (low - near) / (top - near)
    characteristic = (near - low) / near
    first = elliprf(0.0, complement, 1.0)
    second = first - modulus / 3.0 * elliprd(0.0, complement, 1.0)
    third = first + characteristic / 3.0 * elliprj(0.0, complement, 1.0, 1.0 - characteristic)
    # A modulus above 1 is turned to its reciprocal (Byrd and Friedman, Handbook of Elliptic Integrals, 162).
    scale = np.where(through, np.sqrt((1.0 - near) / (far - near)), 1.0)
    second = np.where(through, scale * (second - complement * first), second)
    first, third = first / scale, third / scale
    parts = (
        third * across / near
        + first * (across * (far - 2.0) + (far - 1.0) * (3.0 - near - 2.0 * far) / 3.0)
        + second * (far - near) * (-across + (2.0 * far + 2.0 * near - 4.0) / 3.0)
    )
    volume: Float64Array = 4.0 / (3.0 * np.sqrt(far - near)) * parts + np.where(c > b, 4.0 / 3.0 * np.pi, 0.0)
    return volume


def volume_in_cylinder_between(
    distance: Float64Array,
    height: Float64Array,
    radius: Float64Array,
    cylinder: Float64Array,
    bounds: tuple[float, float],
) -> Float64Array:
    """Return the volume of spheres inside circular cylinders between two planes across the axis.

    Spheres that the planes leave whole have the closed form of `volume_in_cylinder`. For the others, areas of
    two overlapping circles are integrated along the axis by Gauss' rule between the heights at which the
    circles begin to touch or to hold one another; with 24 nodes a piece the error is below 1e-7 of the volume
    of the sphere.

    Args:
        distance: Distances of the spheres' centres from the axis [m], shape (N,), float64.
        height: Heights of the centres along the axis [m], shape (N,), float64.
        radius: Sphere radii [m], shape (N,), float64.
        cylinder: Cylinder radii [m], shape (N,), float64.
        bounds: Heights of the two planes [m].

    Returns:
        Volumes inside [m3], shape (N,), float64.
    """
    low, high = bounds
    whole = (height - radius >= low) & (height + radius <= high)
    volume = np.zeros(len(radius))
    volume[whole] = volume_in_cylinder(distance[whole], radius[whole], cylinder[whole])
    cut = np.flatnonzero(~whole & (height + radius > low) & (height - radius < high))
    if len(cut):
        b, r, c = distance[cut], radius[cut], cylinder[cut]
        first = np.clip((low - height[cut]) / r, -1.0, 1.0)
        last = np.clip((high - height[cut]) / r, -1.0, 1.0)
        volume[cut] = _integrated(b / r, c / r, first, last) * r**3
    return volume


def _integrated(b: Float64Array, c: Float64Array, first: Float64Array, last: Float64Array) -> Float64Array:
    """Volume of a unit sphere inside a cylinder between two heights above its centre, by Gauss' rule."""
    touch = np.sqrt(np.maximum(1.0 - (b - c) ** 2, 0.0))
    hold = np.sqrt(np.maximum(1.0 - (b + c) ** 2, 0.0))
    breaks = np.stack([first, -touch, -hold, hold, touch, last])
    breaks = np.clip(breaks, first, last)
    volume = np.zeros(len(b))
    for low, high in pairwise(breaks):
        # z = middle + half sin(pi t / 2) takes the roots at the ends of a piece away.
        half, middle = 0.5 * (high - low), 0.5 * (high + low)
        z = middle[:, None] + half[:, None] * np.sin(0.5 * np.pi * NODES)
        weight = WEIGHTS * 0.5 * np.pi * np.cos(0.5 * np.pi * NODES)
        area = circles_overlap(np.sqrt(np.maximum(1.0 - z**2, 0.0)), c[:, None], b[:, None])
        volume += half * (area @ weight)
    return volume


def circles_overlap(first: Float64Array, second: Float64Array, distance: Float64Array) -> Float64Array:
    """Return the area that two circles share: two segments, of (2 a - sin 2 a) / 2 times the squared radius.

    Args:
        first: Radii of the one [m], any shape.
        second: Radii of the other one [m], a shape that fits.
        distance: Distances of their centres [m], above 0.

    Returns:
        Shared area [m2].
    """
    tiny = 1e-200
    cos_first = (distance**2 + first**2 - second**2) / np.maximum(2.0 * distance * first, tiny)
    cos_second = (distance**2 + second**2 - first**2) / np.maximum(2.0 * distance * second, tiny)
    # Clipping makes a circle within the other whole, and circles apart empty.
    angle_first = np.arccos(np.clip(cos_first, -1.0, 1.0))
    angle_second = np.arccos(np.clip(cos_second, -1.0, 1.0))
    area: Float64Array = first**2 * (angle_first - 0.5 * np.sin(2.0 * angle_first))
    return area + second**2 * (angle_second - 0.5 * np.sin(2.0 * angle_second))
