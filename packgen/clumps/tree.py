"""Exact distances to a triangulated surface, and the largest balls inscribed in it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array, read_only
from packgen.clumps.tree_kernels import LEAF, distances, shrink_balls

SLACK = 1.0e-3  # extents: how deep facets of a fine mesh reach into a ball that touches their neighbour
ROUNDS = 40


@dataclass(frozen=True, eq=False, slots=True)
class TriangleTree:
    """Triangles in a complete binary tree of boxes, which halves space along a curve.

    Attributes:
        box: Low and high corner of each box [m], shape (2 L - 1, 6), float64.
        corner: Corners of the triangles, leaf by leaf [m], shape (L * 4, 9), float64.
    """

    box: Float64Array
    corner: Float64Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "box", read_only(self.box, np.float64, (None, 6), "box"))
        object.__setattr__(self, "corner", read_only(self.corner, np.float64, (None, 9), "corner"))

    def distance(self, point: Float64Array) -> Float64Array:
        """Return the distance of points (N, 3) to the surface [m], shape (N,), float64."""
        return distances(self.box, self.corner, np.ascontiguousarray(point, np.float64))

    def touching_balls(self, point: Float64Array, inward: Float64Array, slack: float = SLACK) -> Float64Array:
        """Return the largest inscribed ball that touches each point of the surface.

        Args:
            point: Points of the surface [m], shape (N, 3).
            inward: Unit vectors into the body there, shape (N, 3).
            slack: How far from its point a ball may stay, in extents of the surface.

        Returns:
            Centres and radii [m], shape (N, 4), float64; a radius is the exact distance of its centre. Radius
            0: there is no such ball.
        """
        extent = float((self.box[0, 3:] - self.box[0, :3]).max())
        point, inward = np.ascontiguousarray(point), np.ascontiguousarray(inward)
        return shrink_balls(self.box, self.corner, point, inward, extent, slack * extent, ROUNDS)


def triangle_tree(corners: Float64Array) -> TriangleTree:
    """Return the tree of triangles (F, 3, 3) [m]."""
    depth = max(int(np.ceil(np.log2(len(corners) / LEAF))), 0)
    places = LEAF << depth
    # A complete tree has more places than triangles: some triangles stand in two neighbouring ones.
    order = _halved(corners.mean(axis=1), depth)
    placed = corners[order[np.arange(places) * len(corners) // places]]
    low, high = (each.reshape(-1, LEAF, 3) for each in (placed.min(axis=1), placed.max(axis=1)))
    level = np.hstack([low.min(axis=1), high.max(axis=1)])
    levels = [level]
    while len(level) > 1:
        pair = level.reshape(-1, 2, 6)
        level = np.hstack([pair[:, :, :3].min(axis=1), pair[:, :, 3:].max(axis=1)])
        levels.append(level)
    return TriangleTree(np.concatenate(levels[::-1]), placed.reshape(-1, 9))


def _halved(point: Float64Array, depth: int) -> Int64Array:
    """Return the order of points (N, 3) after ``depth`` halvings, across the longest side of each part."""
    order = np.arange(len(point))
    for level in range(depth):
        part = np.arange(len(point)) * (1 << level) // len(point)
        first = np.flatnonzero(np.diff(part, prepend=-1))
        placed = point[order]
        side = np.maximum.reduceat(placed, first) - np.minimum.reduceat(placed, first)
        axis = side.argmax(axis=1)[np.cumsum(np.diff(part, prepend=0) > 0)]
        order = order[np.lexsort((placed[np.arange(len(point)), axis], part))]
    return order
