"""How much of the spheres lies in each cell, exactly: of a regular grid (`cuts`), of a mesh (``overlap``).

Reference: S. Strobl, A. Formella, T. Poeschel, Exact calculation of the overlap volume of spheres and mesh
elements, J. Comput. Phys. 311 (2016) 158. Cells of a mesh are hexahedra, wedges and tetrahedra with corners
in VTK's order. The library takes an element inside out for another one, so that those are turned first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exporters import cuts

Float64Array = NDArray[np.float64]

SPHERES_PER_CHUNK = 65536
VALUES_PER_BLOCK = 1_000_000  # volumes below planes that are held at a time

# The corners of an element seen as a mirror image, and the four corners whose triple product tells.
MIRRORED = {
    "hexahedron": ([4, 5, 6, 7, 0, 1, 2, 3], [0, 1, 3, 4]),
    "wedge": ([3, 4, 5, 0, 1, 2], [0, 1, 2, 3]),
    "tetra": ([0, 2, 1, 3], [0, 1, 2, 3]),
}


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
    # Spheres that lie in as many cells along each axis are one block of arrays.
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


def mesh_volumes(
    position: Float64Array, radius: Float64Array, kind: str, corners: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return the volume of spheres in each cell of one kind, and the volumes of the cells.

    Args:
        position: Sphere centres [m], shape (N, 3).
        radius: Sphere radii [m], shape (N,).
        kind: ``hexahedron``, ``wedge`` or ``tetra``.
        corners: Corners of each cell [m], shape (C, 8, 6 or 4, 3).

    Returns:
        Volume of spheres, and of the cell [m3], each of shape (C,).
    """
    import overlap

    element = {"hexahedron": overlap.Hexahedron, "wedge": overlap.Wedge, "tetra": overlap.Tetrahedron}[kind]
    bodies = [element(each) for each in _right_side_out(kind, corners)]
    spheres = [overlap.Sphere(center, size) for center, size in zip(position, radius.tolist(), strict=True)]
    volume = np.zeros(len(bodies))
    for sphere, cells in _close_cells(position, radius, corners):
        for cell in cells.tolist():
            volume[cell] += overlap.overlap_volume(spheres[sphere], bodies[cell])
    return volume, np.array([body.volume for body in bodies])


def _right_side_out(kind: str, corners: Float64Array) -> Float64Array:
    """Return the corners of cells, of those that are inside out in the order of their mirror image."""
    order, tetrahedron = MIRRORED[kind]
    edges = corners[:, tetrahedron[1:]] - corners[:, tetrahedron[:1]]
    inside_out = np.linalg.det(edges) < 0
    turned = corners.copy()
    turned[inside_out] = corners[inside_out][:, order]
    return turned


def _close_cells(
    position: Float64Array, radius: Float64Array, corners: Float64Array
) -> list[tuple[int, NDArray[np.int64]]]:
    """Return, for spheres that reach cells, the index of the sphere and of the cells whose box it reaches."""
    from scipy.spatial import cKDTree

    low, high = corners.min(axis=1), corners.max(axis=1)
    center, reach = (low + high) / 2, np.linalg.norm(high - low, axis=1) / 2
    octave = np.floor(np.log2(reach / reach.min())).astype(np.int64)
    found = []
    # A tree for each octave of cell size: a small cell is not looked for as far away as a large one.
    for value in np.unique(octave):
        members = np.flatnonzero(octave == value)
        near = cKDTree(center[members]).query_ball_point(position, radius + reach[members].max())
        for sphere, places in enumerate(near):
            cells = members[np.asarray(places, dtype=np.int64)]
            nearest = np.clip(position[sphere], low[cells], high[cells])
            cells = cells[((nearest - position[sphere]) ** 2).sum(axis=1) < radius[sphere] ** 2]
            if len(cells):
                found.append((sphere, cells))
    return found
