"""Triangles covered by balls, so that a k-d tree finds what is near a long one without looking everywhere."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array, Int64Array, distinct

BLOCK_SIZE = 1_000_000  # point-triangle pairs held at a time: about 250 MB at the peak
SLACK = 1.0 + 1e-9


def _rows(corners: Float64Array, size: float) -> tuple[Float64Array, Float64Array, Int64Array, Int64Array]:
    """Return each triangle turned so that its longest edge comes first, that edge, and how it is cut.

    Returns:
        (first corner, edge and rise from the edge to the third corner, shape (F, 3, 3); the share of the edge
        at which the third corner stands, shape (F,); rows of pieces and pieces in the longest row, (F,)).
    """
    edges = corners[:, [1, 2, 0]] - corners
    squared = np.einsum("ijk,ijk->ij", edges, edges)
    turn = (squared.argmax(axis=1)[:, None] + np.arange(3)) % 3
    start, end, third = np.moveaxis(np.take_along_axis(corners, turn[:, :, None], axis=1), 1, 0)
    edge, leg = end - start, third - start
    longest = np.einsum("ij,ij->i", edge, edge)
    foot = np.einsum("ij,ij->i", leg, edge) / np.where(longest > 0.0, longest, 1.0)
    rise = leg - foot[:, None] * edge
    rows = np.ceil(np.linalg.norm(rise, axis=1) / size).astype(np.int64)
    along = np.ceil(np.sqrt(longest) / size).astype(np.int64)
    return np.stack([start, edge, rise], axis=1), foot, np.maximum(rows, 1), np.maximum(along, 1)


def piece_count(corners: Float64Array, size: float) -> int:
    """Return how many balls ``pieces`` makes of triangles at most, without making them."""
    _, _, rows, along = _rows(corners, size)
    return int((rows * along).sum())


def pieces(corners: Float64Array, size: float) -> tuple[Float64Array, Float64Array, Int64Array]:
    """Return balls that cover triangles: one ball around a long and thin triangle would hold most of the bed.

    Each triangle is cut along its longest edge into rows no higher than ``size``, each row into rectangles no
    longer: the angles at the longest edge are acute, so that a row is nowhere wider than at its lower side.

    Args:
        corners: Triangles [m], shape (F, 3, 3), float64.
        size: Largest side of a rectangle [m]; a ball's radius is at most 0.71 of it.

    Returns:
        (centres [m], shape (B, 3); radii [m], shape (B,); triangle of each ball, in rising order, (B,)).
    """
    frame, foot, rows, along = _rows(corners, size)
    triangle = np.repeat(np.arange(len(corners)), rows)
    row = _counted(rows)
    low = row / rows[triangle]  # share of the rise at the row's lower side
    width = 1.0 - low
    length = np.linalg.norm(frame[:, 1], axis=1)
    number = np.minimum(np.maximum(np.ceil(width * length[triangle] / size), 1.0), along[triangle])
    strip = np.repeat(np.arange(len(triangle)), number.astype(np.int64))
    column = _counted(number.astype(np.int64))
    triangle, low, width, number = triangle[strip], low[strip], width[strip], number[strip]
    share = foot[triangle] * low + width * (column + 0.5) / number
    lift = low + 0.5 / rows[triangle]
    start, edge, rise = frame[triangle, 0], frame[triangle, 1], frame[triangle, 2]
    centre = start + share[:, None] * edge + lift[:, None] * rise
    height = np.linalg.norm(frame[:, 2], axis=1)
    radius = 0.5 * np.hypot(width * length[triangle] / number, (height / rows)[triangle])
    return centre, radius * SLACK, triangle


def _counted(lengths: Int64Array) -> Int64Array:
    """Return 0, 1, ... for each length in turn, shape (sum of the lengths,)."""
    ends = np.cumsum(lengths)
    return np.asarray(np.arange(int(ends[-1]) if len(ends) else 0) - np.repeat(ends - lengths, lengths))


def candidates(
    tree: cKDTree, centre: Float64Array, reach: Float64Array, triangle: Int64Array
) -> Iterator[tuple[Int64Array, Int64Array]]:
    """Yield each pair (point of the tree, triangle) with the point in one of the triangle's balls once.

    Args:
        tree: The points.
        centre: Centres of the balls [m].
        reach: Their radii [m], shape (B,).
        triangle: Their triangles in rising order, shape (B,).
    """
    near = tree.query_ball_point(centre, reach, return_length=True)
    found = near > 0
    centre, reach, triangle, near = centre[found], reach[found], triangle[found], near[found]
    first = np.flatnonzero(np.diff(triangle, prepend=-1))
    # All balls of a triangle are in one batch, so that no pair comes twice.
    batch = np.cumsum(np.add.reduceat(near, first) if len(first) else near) // BLOCK_SIZE
    bounds = [*first[np.flatnonzero(np.diff(batch, prepend=-1))], len(triangle)]
    width = int(triangle[-1]) + 1 if len(triangle) else 1
    for start, stop in pairwise(bounds):
        balls = cKDTree(centre[start:stop], balanced_tree=False, compact_nodes=False)
        pair = tree.sparse_distance_matrix(balls, float(reach[start:stop].max()), output_type="ndarray")
        pair = pair[pair["v"] <= reach[start:stop][pair["j"]]]
        keys = distinct(pair["i"] * width + triangle[start:stop][pair["j"]])
        for block in range(0, len(keys), BLOCK_SIZE):
            point, face = np.divmod(keys[block : block + BLOCK_SIZE], width)
            yield point, face
