"""The volume of spheres in each cell of a regular grid, exactly (`ball_cuts`)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exporters.fields import ball_cuts as cuts

Float64Array = NDArray[np.float64]

SPHERES_PER_CHUNK = 65536
VALUES_PER_BLOCK = 1_000_000  # volumes below planes that are held at a time


def grid_volumes(
    position: Float64Array,
    radius: Float64Array,
    low: Float64Array,
    spacing: Float64Array,
    shape: tuple[int, int, int],
) -> Float64Array:
    """Return the volume of spheres in each cell of a regular grid.

    Args:
        position: Sphere centres [m], shape (N, 3).
        radius: Sphere radii [m], shape (N,).
        low: Lower corner of the grid [m], shape (3,).
        spacing: Size of a cell [m], shape (3,).
        shape: Number of cells along x, y, z.

    Returns:
        Volumes [m3], of ``shape``; what lies beyond the grid is in no cell.
    """
    volume = np.zeros(shape)
    for start in range(0, len(radius), SPHERES_PER_CHUNK):
        part = slice(start, start + SPHERES_PER_CHUNK)
        _add_chunk(volume, (position[part] - low) / spacing, radius[part], spacing)
    return volume


def _add_chunk(
    volume: Float64Array, center: Float64Array, radius: Float64Array, spacing: Float64Array
) -> None:
    """Add the spheres of a chunk, their centres in cells from the grid's corner, to the cells' volumes."""
    reach = radius[:, None] / spacing
    first = np.floor(center - reach).astype(np.int64)
    extent = np.floor(center + reach).astype(np.int64) - first + 1
    # Spheres with equal numbers of cells along each axis are one block of arrays.
    for cells in np.unique(extent, axis=0):
        members = np.flatnonzero((extent == cells).all(axis=1))
        step = max(1, VALUES_PER_BLOCK // int((cells + 1).prod()))
        for start in range(0, len(members), step):
            index = members[start : start + step]
            planes = [
                (first[index, axis, None] + 1 + np.arange(cells[axis] - 1) - center[index, axis, None])
                / reach[index, axis, None]
                for axis in range(3)
            ]
            share = cuts.below(*(np.clip(each, -1, 1) for each in planes))
            for axis in (1, 2, 3):
                share = np.diff(share, axis=axis)
            # Rounding leaves the empty corners of a block a little below 0.
            share = np.maximum(share, 0.0) * (radius[index] ** 3)[:, None, None, None]
            _add_blocks(volume, first[index], share)


def _add_blocks(volume: Float64Array, first: NDArray[np.int64], share: Float64Array) -> None:
    """Add to cells the blocks (M, I, J, K) that begin at cells ``first`` (M, 3); none beyond the grid."""
    cell = [
        np.broadcast_to(
            (first[:, axis, None] + np.arange(size)).reshape(-1, *np.insert([1, 1], axis, size)), share.shape
        )
        for axis, size in enumerate(share.shape[1:])
    ]
    there = np.ones(share.shape, dtype=bool)
    for each, size in zip(cell, volume.shape, strict=True):
        there &= (each >= 0) & (each < size)
    np.add.at(volume, tuple(each[there] for each in cell), share[there])
