"""The edges of facets."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Int64Array = NDArray[np.int64]


def edges_of(faces: Int64Array) -> Int64Array:
    """Return the three edges of each facet, the lower corner of each first.

    Args:
        faces: Corner indices, shape (F, 3).

    Returns:
        Corner indices of the edges, shape (F, 3, 2).
    """
    edges: Int64Array = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
    return edges


def edge_uses(faces: Int64Array) -> Int64Array:
    """Return how many facets have each of the three edges of each facet, itself included, shape (F, 3)."""
    edges = edges_of(faces)
    # One number an edge sorts several times as fast as two.
    key = edges[:, :, 0] * (int(faces.max(initial=0)) + 1) + edges[:, :, 1]
    _, edge, use = np.unique(key, return_inverse=True, return_counts=True)
    uses: Int64Array = use[edge.reshape(-1, 3)]
    return uses


def shared_edges(faces: Int64Array) -> tuple[Int64Array, Int64Array]:
    """Return both places in ``edges_of(faces)``, flat, of edges that exactly two facets share, (E,) each."""
    edges = edges_of(faces).reshape(-1, 2)
    key = edges[:, 0] * (int(faces.max(initial=0)) + 1) + edges[:, 1]
    order = np.argsort(key, kind="stable")
    starts = np.flatnonzero(np.diff(key[order], prepend=-1))
    pairs = starts[np.diff(np.append(starts, len(order))) == 2]
    return order[pairs], order[pairs + 1]
