"""Which middles of a regular grid's cells are in a ball."""

from __future__ import annotations

import numpy as np

from packgen.arrays import BoolArray, Float64Array


def points_in_balls(
    position: Float64Array,
    radius: Float64Array,
    low: Float64Array,
    spacing: Float64Array,
    shape: tuple[int, int, int],
) -> BoolArray:
    """Return whether the middle of each cell of a grid is in a ball, or on its surface.

    Args:
        position: Centres [m], shape (N, 3).
        radius: Radii [m], shape (N,).
        low: Lower corner of the grid [m], shape (3,).
        spacing: Size of a cell [m], shape (3,).
        shape: Number of cells along x, y, z.

    Returns:
        Whether, of ``shape``, bool.
    """
    solid = np.zeros(shape, bool)
    count = np.array(shape)
    first = np.ceil((position - radius[:, None] - low) / spacing - 0.5).astype(np.int64)
    last = np.floor((position + radius[:, None] - low) / spacing - 0.5).astype(np.int64)
    first, last = np.maximum(first, 0), np.minimum(last, count - 1)
    for ball in np.flatnonzero((first <= last).all(axis=1)).tolist():
        part = tuple(slice(int(a), int(b) + 1) for a, b in zip(first[ball], last[ball], strict=True))
        x, y, z = (
            (low[axis] + (np.arange(each.start, each.stop) + 0.5) * spacing[axis] - position[ball, axis]) ** 2
            for axis, each in enumerate(part)
        )
        solid[part] |= x[:, None, None] + y[:, None] + z <= radius[ball] ** 2
    return solid
