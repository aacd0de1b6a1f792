"""Boxes around shapes, and the frame of gravity."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array
from packgen.geometry import Ball, Box, Cone, Shape, Slice
from packgen.portable import components, length


def gravity_frame(down: Float64Array) -> Float64Array:
    """Return unit vectors u, v and up as the rows of a rotation, shape (3, 3); up is ``-down``."""
    up = -np.asarray(down, float) / length(np.asarray(down, float))
    first = np.eye(3)[int(np.argmin(np.abs(up)))]
    u = first - (first * up).sum() * up
    u /= length(u)
    return np.stack([u, np.cross(up, u), up])


def shape_bounds(shape: Shape | Slice) -> tuple[Float64Array, Float64Array]:
    """Return lower and upper corner of a shape's bounding box [m]; infinite where a slice leaves it open."""
    if isinstance(shape, Box):
        return shape.min, shape.max
    if isinstance(shape, Ball):
        return shape.center - shape.radius, shape.center + shape.radius
    if isinstance(shape, Cone):
        across = np.sqrt(np.maximum(1.0 - shape.axis**2, 0.0))
        top = shape.base + shape.height * shape.axis
        bottom_reach, top_reach = shape.radius_bottom * across, shape.radius_top * across
        return np.minimum(shape.base - bottom_reach, top - top_reach), np.maximum(
            shape.base + bottom_reach, top + top_reach
        )
    if isinstance(shape, Slice):
        least, most = np.full(3, -np.inf), np.full(3, np.inf)
        axis = int(np.argmax(np.abs(shape.axis)))
        if abs(shape.axis[axis]) > 0.999999:
            ends = sorted((shape.low * shape.axis[axis], shape.high * shape.axis[axis]))
            least[axis], most[axis] = ends
        return least, most
    vertices = shape.surface.vertices
    return vertices.min(axis=0), vertices.max(axis=0)


def altitude_range(shape: Shape | Slice, up: Float64Array) -> tuple[float, float]:
    """Return the lowest and the highest altitude of a shape along a unit vector [m]; infinite for a slice."""
    if isinstance(shape, Slice):
        return -np.inf, np.inf
    if isinstance(shape, Ball):
        middle = float((shape.center * up).sum())
        return middle - shape.radius, middle + shape.radius
    if isinstance(shape, Cone):
        along = float((shape.axis * up).sum())
        across = float(np.sqrt(max(1.0 - along * along, 0.0)))
        ends = float((shape.base * up).sum()) + np.array([0.0, shape.height * along])
        reach = np.array([shape.radius_bottom, shape.radius_top]) * across
        return float((ends - reach).min()), float((ends + reach).max())
    if isinstance(shape, Box):
        least, most = np.minimum(shape.min * up, shape.max * up), np.maximum(shape.min * up, shape.max * up)
        return float(least.sum()), float(most.sum())
    altitude = components(shape.surface.vertices, up)
    return float(altitude.min()), float(altitude.max())
