"""How much of the spheres lies in each cell of a mesh, exactly, by the library ``overlap``.

Reference: S. Strobl, A. Formella, T. Poeschel, Exact calculation of the overlap volume of spheres and mesh
elements, J. Comput. Phys. 311 (2016) 158. Cells are hexahedra, wedges and tetrahedra with corners in VTK's
order. The library takes an element inside out for another one, so that those are turned first.
"""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

Float64Array = NDArray[np.float64]

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
    from overlap import Hexahedron, Sphere, overlap_volume

    volume = np.zeros(shape)
    first = np.floor((position - radius[:, None] - low) / spacing).astype(np.int64)
    last = np.floor((position + radius[:, None] - low) / spacing).astype(np.int64)
    within = ((first == last) & (first >= 0) & (first < shape)).all(axis=1)
    np.add.at(volume, tuple(first[within].T), 4 / 3 * np.pi * radius[within] ** 3)
    first, last = np.maximum(first, 0), np.minimum(last, np.array(shape) - 1)
    lower = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    corner = np.concatenate((lower, lower + np.array([0, 0, 1])))
    bodies: dict[tuple[int, ...], Any] = {}
    for index in np.flatnonzero(~within):
        sphere = Sphere(position[index], float(radius[index]))
        ranges = [range(a, b + 1) for a, b in zip(first[index].tolist(), last[index].tolist(), strict=True)]
        for cell in product(*ranges):
            # A grid's nodes are the same numbers in all the cells around them: no gaps, no overlaps.
            if cell not in bodies:
                bodies[cell] = Hexahedron(low + (np.array(cell) + corner) * spacing)
            volume[cell] += overlap_volume(sphere, bodies[cell])
    return volume


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
