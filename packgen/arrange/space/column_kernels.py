"""Which column along gravity each point lies in: the loop that the surface of a bed is followed by."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.compiled import inlined, loop


@inlined
def component(position: Float64Array, i: int, axis: Float64Array) -> float:
    """Return the component of vector i (N, 3) along an axis (3,) as ``portable.components`` does."""
    total, any_yet = 0.0, False
    for k in range(3):
        if axis[k] != 0.0:
            total = total + position[i, k] * axis[k] if any_yet else position[i, k] * axis[k]
            any_yet = True
    return total


@loop
def column_index(
    position: Float64Array, across: Float64Array, corner: Float64Array, width: Float64Array, shape: Int64Array
) -> Int64Array:
    """Return the column that each point lies in, the nearest one for points beside the grid, flat, (N,).

    Args:
        position: Points [m], shape (N, 3).
        across: Unit vectors u and v across gravity, shape (2, 3).
        corner: Lower corner of the grid in u and v [m], shape (2,).
        width: Column width along u and v [m], shape (2,).
        shape: Number of columns along u and v, shape (2,).
    """
    index = np.empty(len(position), np.int64)
    for i in range(len(position)):
        flat = 0
        for k in range(2):
            place = int((component(position, i, across[k]) - corner[k]) / width[k])
            flat = flat * shape[k] + min(max(place, 0), shape[k] - 1)
        index[i] = flat
    return index
