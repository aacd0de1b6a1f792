"""A periodic cell of any shape: its shortest vectors, and the pairs that meet across its seams."""

from __future__ import annotations

from itertools import product

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.portable import inverse, length, matrix_product

SHORTER = 1.0e-9
"""Share by which a vector has to become shorter to be replaced."""

ROUNDS = 100
"""Rounds of replacements at most; a handful are enough for any cell that a step leaves."""


def reduced(cell: Float64Array) -> Float64Array:
    """Return the vectors of the same lattice that cannot be made shorter by adding others, as rows (3, 3).

    A skewed cell has many images near its spheres, one of short vectors has few.
    """
    vectors = np.array(cell)
    for _ in range(ROUNDS):
        changed = False
        for k in range(3):
            one, other = (vectors[(k + step) % 3] for step in (1, 2))
            for a, b in product((-1, 0, 1), repeat=2):
                tried = vectors[k] + a * one + b * other
                while (tried * tried).sum() < (1.0 - SHORTER) * (vectors[k] * vectors[k]).sum():
                    vectors[k], changed = tried, True
                    tried = vectors[k] + a * one + b * other
        if not changed:
            break
    return vectors


def volume(cell: Float64Array) -> float:
    """Return the volume of a cell [m3], its vectors given as rows (3, 3)."""
    return abs(float((np.cross(cell[0], cell[1]) * cell[2]).sum()))


def spacings(cell: Float64Array) -> Float64Array:
    """Return the distances of a cell's opposite faces [m], shape (3,)."""
    faces = [length(np.cross(cell[(k + 1) % 3], cell[(k + 2) % 3])) for k in range(3)]
    return np.asarray(volume(cell) / np.array(faces))


def near_pairs(
    center: Float64Array, radius: Float64Array, cell: Float64Array, within: float
) -> tuple[Int64Array, Int64Array, Float64Array]:
    """Return all pairs of spheres and images whose surfaces are nearer than a distance.

    A sphere pairs with its own images, too. Of two that mirror each other one is returned.

    Args:
        center: Centres, anywhere [m], shape (N, 3).
        radius: Radii [m], shape (N,).
        cell: Vectors of the cell as rows [m], shape (3, 3).
        within: The distance [m].

    Returns:
        The spheres of each pair, (P,) each, and the way from the second's image to the first [m], (P, 3).
    """
    back = inverse(cell)
    place = matrix_product(center, back)
    center = matrix_product(place - np.floor(place), cell)
    reach = 2.0 * float(radius.max()) + within
    steps = np.floor(reach / spacings(cell) + 1.0).astype(int)
    shifts = np.array(list(product(*[range(-each, each + 1) for each in steps])))
    one, other = np.triu_indices(len(radius))
    way = (center[one] - center[other])[:, None] + matrix_product(shifts, cell)[None]
    square = (way * way).sum(axis=2)
    limit = radius[one] + radius[other] + within
    near = square < (limit * limit)[:, None]
    # A sphere's images come in opposite pairs, and one of its images is the sphere itself.
    near[one == other] &= np.arange(len(shifts)) > len(shifts) // 2
    pair, shift = np.nonzero(near)
    return one[pair], other[pair], way[pair, shift]
