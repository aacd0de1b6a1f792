"""Triangles cut into pieces, so that a k-d tree finds what is near a large one without looking everywhere."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array, Int64Array

BLOCK_SIZE = 1_000_000  # point-triangle pairs held at a time: about 250 MB at the peak
BATCH_SIZE = 200  # pieces whose candidates are held at a time


def pieces(corners: Float64Array, size: float) -> tuple[Float64Array, Float64Array, Int64Array]:
    """Return balls that cover the triangles: centre (B, 3), radius (B,), and the triangle of each (B,).

    Long triangles are halved across their longest edge until no edge exceeds ``size``: one ball around the
    whole of a long and thin triangle would hold most of the bed.
    """
    triangle = np.arange(len(corners))
    done: list[tuple[Float64Array, Int64Array]] = []
    while len(corners):
        lengths = np.linalg.norm(corners[:, [1, 2, 0]] - corners, axis=2)
        longest = lengths.argmax(axis=1)
        split = lengths.max(axis=1) > size
        done.append((corners[~split], triangle[~split]))
        turn = (longest[split, None] + np.arange(3)) % 3
        turned = np.take_along_axis(corners[split], turn[:, :, None], axis=1)
        a, b, c = turned[:, 0], turned[:, 1], turned[:, 2]
        middle = 0.5 * (a + b)
        corners = np.concatenate([np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)])
        triangle = np.tile(triangle[split], 2)
    pieces = np.concatenate([each[0] for each in done])
    centre = pieces.mean(axis=1)
    radius = np.linalg.norm(pieces - centre[:, None], axis=2).max(axis=1)
    return centre, radius * (1.0 + 1e-9), np.concatenate([each[1] for each in done])


def candidates(
    tree: cKDTree, centre: Float64Array, reach: Float64Array, triangle: Int64Array
) -> Iterator[tuple[Int64Array, Int64Array]]:
    """Yield each pair (point of the tree, triangle) with the point in one of the triangle's balls once."""
    order = np.argsort(triangle, kind="stable")
    centre, reach, triangle = centre[order], reach[order], triangle[order]
    first_piece = np.flatnonzero(np.diff(triangle, prepend=-1))
    # All pieces of a triangle are in one batch, so that no pair comes twice.
    places = np.searchsorted(first_piece, np.arange(0, len(triangle), BATCH_SIZE))
    bounds = [*np.unique(first_piece[places[places < len(first_piece)]]), len(triangle)]
    width = int(triangle[-1]) + 1 if len(triangle) else 1
    for start, stop in pairwise(bounds):
        near = tree.query_ball_point(centre[start:stop], reach[start:stop])
        counts = np.array([len(each) for each in near])
        if counts.sum() == 0:
            continue
        points = np.concatenate([np.asarray(each, dtype=np.int64) for each in near])
        keys = np.unique(points * width + np.repeat(triangle[start:stop], counts))
        for block in range(0, len(keys), BLOCK_SIZE):
            point, face = np.divmod(keys[block : block + BLOCK_SIZE], width)
            yield point, face
