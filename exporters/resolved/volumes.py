"""Volumes of spheres that are cut flat, overlap, or are joined by cylinders: closed forms or quadrature."""

from __future__ import annotations

import math

import numpy as np

from packgen.arrays import Float64Array

DIRECTIONS = 20_000
DIRECTIONS_ERROR = 1.0e-4  # of a ball, where flats are not deep
WALL_NODES = 64


def ball(radius: Float64Array) -> Float64Array:
    """Return the volume of balls [m3]."""
    return np.asarray(4.0 / 3.0 * math.pi * radius**3)


def cap(radius: Float64Array, distance: Float64Array) -> Float64Array:
    """Return the volume of balls beyond planes at a distance from their centres, 0 where they do not meet."""
    height = np.clip(radius - distance, 0.0, 2.0 * radius)
    return np.asarray(math.pi / 3.0 * height**2 * (3.0 * radius - height))


def lens(first: Float64Array, second: Float64Array, distance: Float64Array) -> Float64Array:
    """Return the volume that two balls share: two caps at the plane where they meet, or the smaller ball."""
    apart = np.maximum(distance, np.finfo(float).tiny)
    plane = (apart**2 + first**2 - second**2) / (2.0 * apart)
    shared = cap(first, plane) + cap(second, apart - plane)
    smaller = ball(np.minimum(first, second))
    inside = distance <= np.abs(first - second)
    return np.where(inside, smaller, np.where(distance < first + second, shared, 0.0))


def cylinder_beyond(radius: Float64Array, cylinder: Float64Array, wall: Float64Array) -> Float64Array:
    """Return the volume of a cylinder on a ball's axis outside of the ball, as far as a flat wall.

    Args:
        radius: Radii of the balls [m].
        cylinder: Radii of the cylinders [m], smaller ones.
        wall: Distances of the walls from the centres [m].
    """
    rim = np.sqrt(radius**2 - cylinder**2)
    return np.asarray(math.pi * cylinder**2 * (wall - rim) - cap(radius, rim))


def behind_flat(cylinder: Float64Array, curvature: float) -> Float64Array:
    """Return the volume of cylinders between a flat wall and the hollow one that it touches [m3].

    The axis of each cylinder is at right angles to the hollow wall's. A quadrature, exact to rounding while
    the cylinders' radii are below half the wall's.

    Args:
        cylinder: Radii of the cylinders [m].
        curvature: Radius of the hollow wall [m]; infinite: flat.
    """
    if not math.isfinite(curvature):
        return np.zeros_like(cylinder)
    # The integral over a disc of f(y) is that of 2 sqrt(c^2 - y^2) f(y): Gauss and Chebyshev, second kind.
    angle = math.pi * np.arange(1, WALL_NODES + 1) / (WALL_NODES + 1)
    weight = math.pi / (WALL_NODES + 1) * np.sin(angle) ** 2
    across = cylinder[:, None] * np.cos(angle)
    depth = across**2 / (curvature + np.sqrt(np.maximum(curvature**2 - across**2, 0.0)))
    return np.asarray(-2.0 * cylinder**2 * (depth * weight).sum(axis=1))


def cut_ball(radius: float, normal: Float64Array, plane: Float64Array) -> float:
    """Return the volume of a ball that is cut by planes, by a quadrature over `DIRECTIONS` directions [m3].

    Args:
        radius: Radius of the ball [m].
        normal: Unit normals of the planes, shape (K, 3).
        plane: Distances of the planes from the centre [m], more than 0, shape (K,).
    """
    far = np.full(DIRECTIONS, radius)
    slope = spread_directions() @ normal.T
    reached = np.where(slope > 0.0, plane / np.where(slope > 0.0, slope, 1.0), np.inf)
    far = np.minimum(far, reached.min(axis=1))
    return float(4.0 / 3.0 * math.pi * (far**3).mean())


def spread_directions() -> Float64Array:
    """Return directions spread evenly on a spiral, shape (`DIRECTIONS`, 3)."""
    index = np.arange(DIRECTIONS) + 0.5
    height = 1.0 - 2.0 * index / DIRECTIONS
    turn = math.pi * (3.0 - math.sqrt(5.0)) * index
    across = np.sqrt(1.0 - height**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)
