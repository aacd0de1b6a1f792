"""Spaces with voids whose largest spheres are known, and what is left of them by other code."""

from __future__ import annotations

import numpy as np

from packgen.arrange.space.seams import NO_SEAMS
from packgen.arrange.void_filling.hollow import Hollow
from packgen.arrays import Float64Array
from packgen.geometry import Box, Mesh, Shape, Surface
from packgen.geometry.bounds import shape_bounds

UNIT_CUBE = Box(np.zeros(3), np.ones(3))


def hollow(shape: Shape, ball: Float64Array | None = None) -> Hollow:
    """Return a space, with spheres (N, 4) in it or empty."""
    bounds = np.stack(shape_bounds(shape))
    return Hollow([shape], bounds, NO_SEAMS, np.empty((0, 4)) if ball is None else ball)


def tetrahedron() -> Mesh:
    """Return the regular tetrahedron of edge 2 sqrt(2)."""
    corners = np.array([[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]])
    return Mesh(Surface(corners, np.array([[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]])))


def ell() -> Mesh:
    """Return an L of three unit cubes, which is not convex."""
    outline = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]], np.float64)
    corners = np.concatenate([np.column_stack([outline, np.full(6, z)]) for z in (0.0, 1.0)])
    floor = [[0, 2, 1], [0, 3, 2], [0, 4, 3], [0, 5, 4]]
    lid = [[a + 6, c + 6, b + 6] for a, b, c in floor]
    sides = [[k, (k + 1) % 6, (k + 1) % 6 + 6] for k in range(6)]
    sides += [[k, (k + 1) % 6 + 6, k + 6] for k in range(6)]
    return Mesh(Surface(corners, np.array(floor + lid + sides)))


def farthest_left(found: Hollow, bounds: Float64Array, count: int = 200_000) -> float:
    """Return how far random points of a box are from everything at most [m]."""
    points = bounds[0] + np.random.default_rng(1).random((count, 3)) * (bounds[1] - bounds[0])
    return float(found.distance(points).max())


def least_gap(ball: Float64Array) -> float:
    """Return the least distance between surfaces of spheres (N, 4) [m], by all pairs."""
    apart = np.linalg.norm(ball[:, None, :3] - ball[None, :, :3], axis=2)
    gap = apart - ball[:, 3] - ball[:, None, 3]
    return float(gap[np.triu_indices(len(ball), 1)].min())
