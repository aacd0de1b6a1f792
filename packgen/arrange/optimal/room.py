"""A convex container by its planes, or a ball: what keeps spheres inside."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array
from packgen.geometry import Ball, Box, Container, Polyhedron
from packgen.portable import matrix_product

SAME = 1.0e-9
"""Difference of normals, and of offsets in the container's size, of one and the same plane."""

TRIES = 10_000
"""Points that are drawn at once where some inside the container are wanted."""


@dataclass(frozen=True, eq=False, slots=True)
class Room:
    """The points x with ``normal @ x <= offset`` for every plane, or a ball.

    Attributes:
        normal: Outward unit normals, shape (P, 3); empty for a ball.
        offset: Distances of the planes from the origin [m], shape (P,); empty for a ball.
        center: Centre of the ball [m], shape (3,).
        radius: Its radius [m]; 0: there are planes.
        bounds: Lower and upper corner [m], shape (2, 3).
        volume: Volume [m3].
    """

    normal: Float64Array
    offset: Float64Array
    center: Float64Array
    radius: float
    bounds: Float64Array
    volume: float

    @classmethod
    def of(cls, container: Container) -> Room | None:
        """Return the room in a container; None: it is no convex polyhedron, no box and no ball."""
        shape, nowhere = container.shape, np.zeros(3)
        if any(container.periodic):
            return None
        if isinstance(shape, Ball):
            none = np.empty((0, 3)), np.empty(0)
            return cls(*none, np.array(shape.center), shape.radius, container.bounds, container.volume)
        if isinstance(shape, Box):
            normal, offset = np.concatenate([np.eye(3), -np.eye(3)]), np.concatenate([shape.max, -shape.min])
        elif isinstance(shape, Polyhedron):
            normal, offset = _once(shape.normal, shape.offset, float(np.ptp(container.bounds, axis=0).max()))
        else:
            return None
        return cls(normal, offset, nowhere, 0.0, container.bounds, container.volume)

    def distances(self, center: Float64Array) -> Float64Array:
        """Return the distances of points from the walls [m], shape (N, walls), negative outside."""
        if self.radius > 0.0:
            away = center - self.center
            return np.asarray(self.radius - np.sqrt((away * away).sum(axis=1)))[:, None]
        return np.asarray(self.offset - matrix_product(center, self.normal.T))

    def inward(self, center: Float64Array) -> Float64Array:
        """Return the unit vectors along which points leave the walls fastest, shape (N, walls, 3)."""
        if self.radius == 0.0:
            return np.asarray(np.broadcast_to(-self.normal, (len(center), *self.normal.shape)))
        away = self.center - center
        distance = np.sqrt((away * away).sum(axis=1))[:, None]
        middle = np.where(distance > 0.0, distance, 1.0)
        return np.asarray(np.where(distance > 0.0, away / middle, np.eye(3)[0]))[:, None]

    def points(self, count: int, rng: np.random.Generator) -> Float64Array:
        """Return random points inside [m], shape (count, 3)."""
        low, high = self.bounds
        found = np.empty((0, 3))
        while len(found) < count:
            tried = low + rng.random((TRIES if count > 100 else 4 * count + 16, 3)) * (high - low)
            found = np.concatenate([found, tried[self.distances(tried).min(axis=1) > 0.0]])
        return found[:count]


def _once(normal: Float64Array, offset: Float64Array, size: float) -> tuple[Float64Array, Float64Array]:
    """Return planes without those that are the same as others: facets of one side."""
    kept: list[int] = []
    for place in range(len(offset)):
        same = [
            other
            for other in kept
            if np.abs(normal[place] - normal[other]).max() < SAME
            and abs(offset[place] - offset[other]) < SAME * size
        ]
        if not same:
            kept.append(place)
    return normal[kept], offset[kept]
