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
