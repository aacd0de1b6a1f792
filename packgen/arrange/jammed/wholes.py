"""How all spheres of a bed can move as a whole without any wall noticing, and what keeps them from it."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.geometry import Ball, Cone, Container
from packgen.portable import length
from packgen.programmes.steps import Pins


def whole_moves(container: Container, center: Float64Array, members: Int64Array, *, located: bool) -> Pins:
    """Return a direction of a sphere for each way in which all can move: where it stays, they stay.

    They can shift along the axes of a periodic box, turn about the axis of a cylinder or a cone, and about
    any axis in a ball.

    Args:
        container: The container.
        center: Centres [m], shape (N, 3).
        members: The spheres to choose from, at least one.
        located: Whether the zone has walls of its own, which notice turns.
    """
    axes = np.flatnonzero(container.periodic)
    if len(axes):
        return Pins(np.full(len(axes), members[0]), np.eye(3)[axes])
    shape = container.shape
    if located or not isinstance(shape, Ball | Cone):
        return Pins(np.empty(0, np.int64), np.empty((0, 3)))
    if isinstance(shape, Cone):
        sphere, direction = _about(shape.axis, shape.base, center, members)
        return Pins(np.array([sphere]), direction[None])
    away = center[members] - shape.center
    far = members[np.argmax((away * away).sum(axis=1))]
    pole = center[far] - shape.center
    distance = length(pole)
    pole = pole / distance if distance > 0.0 else np.eye(3)[2]
    sphere, direction = _about(pole, shape.center, center, members)
    across = np.cross(direction, pole)
    return Pins(np.array([far, far, sphere]), np.stack([direction, across, direction]))


def _about(
    axis: Float64Array, point: Float64Array, center: Float64Array, members: Int64Array
) -> tuple[int, Float64Array]:
    """Return the sphere farthest from an axis, and the unit vector along which it turns about that."""
    along = np.cross(axis, center[members] - point)
    distance = np.linalg.norm(along, axis=1)
    farthest = int(np.argmax(distance))
    if distance[farthest] == 0.0:
        along[farthest] = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
        distance[farthest] = length(along[farthest])
    return int(members[farthest]), along[farthest] / distance[farthest]
