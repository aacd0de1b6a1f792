"""The pair correlation of hard spheres by theory, and as it is counted in a bed; lengths in diameters."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array

STEPS = 200  # of a diameter
FARTHEST = 5


def percus_yevick(fraction: float) -> tuple[Float64Array, Float64Array]:
    """Return distances and g of the Percus-Yevick fluid.

    Baxter's equation (Aust. J. Phys. 21, 1968, 563) step by step outwards, as Perram does (Mol. Phys. 30,
    1975, 1505).
    """
    distance = np.arange(FARTHEST * STEPS + 1) / STEPS
    a, b = (1 + 2 * fraction) / (1 - fraction) ** 2, -1.5 * fraction / (1 - fraction) ** 2
    inner = distance[: STEPS + 1]
    factor = 0.5 * a * (inner**2 - 1) + b * (inner - 1)
    weight = np.full(STEPS + 1, 1 / STEPS)
    weight[[0, -1]] /= 2
    total = -distance  # r h(r); -r where spheres would overlap
    for place in range(STEPS, len(distance)):
        before = total[place - np.arange(1, STEPS + 1)]
        if STEPS < place < 2 * STEPS:
            before[place - STEPS - 1] = 0.5 * (total[STEPS] - 1.0)  # the jump at contact
        known = 12 * fraction * (weight[1:] * factor[1:] * before).sum()
        total[place] = known / (1 - 12 * fraction * weight[0] * factor[0])
    g = np.zeros(len(distance))
    g[STEPS:] = 1 + total[STEPS:] / distance[STEPS:]
    return distance, g


def verlet_weis(fraction: float) -> tuple[Float64Array, Float64Array]:
    """Return distances and g of hard spheres: Percus-Yevick with the correction of Verlet and Weis.

    Phys. Rev. A 5 (1972) 939: a slightly smaller sphere, and what is missing at contact.
    """
    smaller = fraction - fraction**2 / 16
    shrunk = (smaller / fraction) ** (1 / 3)
    distance, g = percus_yevick(smaller)
    place = np.linspace(1.0, FARTHEST - 0.5, 2001)
    g = np.interp(place, shrunk * distance, g)
    contact = (1 - fraction / 2) / (1 - fraction) ** 3
    missing = contact - g[0]
    rate = 24 * missing * (1 - smaller) ** 2 / (smaller * (1 + smaller / 2))
    return place, g + missing / place * np.exp(-rate * (place - 1)) * np.cos(rate * (place - 1))


def in_shells(curve: tuple[Float64Array, Float64Array], edges: Float64Array) -> Float64Array:
    """Return the mean of g over each shell between two distances."""
    means = []
    for low, high in pairwise(edges):
        place = np.linspace(low, high, 41)
        means.append(np.average(np.interp(place, *curve), weights=place**2))
    return np.array(means)


def counted(position: Float64Array, period: float, diameter: float, edges: Float64Array) -> Float64Array:
    """Return g of equal spheres in a periodic cube, shell by shell."""
    tree = cKDTree(position % period, boxsize=period)
    pairs = np.diff(tree.count_neighbors(tree, edges * diameter).astype(float))
    room = 4 / 3 * np.pi * np.diff((edges * diameter) ** 3)
    return pairs / len(position) / (len(position) / period**3 * room)
