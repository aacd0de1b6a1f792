"""Cells of any shape in files: three vectors, the first along x, the second in the plane of x and y.

Reference: LAMMPS manual, page "Howto triclinic": a box has edges (xhi - xlo, 0, 0), (xy, yhi - ylo, 0) and
(xz, yz, zhi - zlo) from the corner (xlo, ylo, zlo); dumps give the bounds of the box around it instead.
"""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array
from packgen.reading.spheres import Cell


def cell_of(vectors: Float64Array) -> Cell:
    """Return the cell of some vectors from the origin.

    Args:
        vectors: They, as rows, a lower triangle, positive along its diagonal [m], shape (3, 3).
    """
    corners = np.stack([np.minimum(vectors, 0.0).sum(axis=0), np.maximum(vectors, 0.0).sum(axis=0)])
    return Cell(corners, (True, True, True), vectors)


def tilted_vectors(size: Float64Array, tilt: Float64Array) -> Float64Array:
    """Return the vectors of a tilted box as rows [m], shape (3, 3).

    Args:
        size: Its lengths along x, y and z [m], shape (3,).
        tilt: ``xy xz yz`` [m], shape (3,).
    """
    vectors = np.diag(size)
    vectors[[1, 2, 2], [0, 0, 1]] = tilt
    return vectors


def inside_bounds(bounds: Float64Array, tilt: Float64Array) -> Float64Array:
    """Return ``lo`` and ``hi`` of a tilted box from the bounds that a dump gives [m], both of shape (2, 3).

    Args:
        bounds: Lower and upper bound [m], shape (2, 3).
        tilt: ``xy xz yz`` [m], shape (3,).
    """
    xy, xz, yz = tilt.tolist()
    along_x, along_y = (0.0, xy, xz, xy + xz), (0.0, yz)
    low = bounds[0] - [min(along_x), min(along_y), 0.0]
    high = bounds[1] - [max(along_x), max(along_y), 0.0]
    return np.stack([low, high])
