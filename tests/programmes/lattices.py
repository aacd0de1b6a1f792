"""Lattices of touching spheres in periodic cells, with all their contacts."""

from __future__ import annotations

from itertools import product

import numpy as np

from packgen.programmes.steps import PairRows, Pins, WallRows

NO_WALLS = WallRows(np.empty(0, np.int64), np.empty(0), np.empty((0, 3)), np.empty(0))
FIRST_STILL = Pins(np.zeros(3, np.int64), np.eye(3))


def cubic_close_packing(cells: int, diameter: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Centres of a face-centred cubic lattice, and the lengths of its cell."""
    corner = np.array(list(product(range(cells), repeat=3)), float)
    face = np.array([[0, 0, 0], [0, 0.5, 0.5], [0.5, 0, 0.5], [0.5, 0.5, 0]])
    edge = np.sqrt(2.0) * diameter
    return (corner[:, None] + face).reshape(-1, 3) * edge, np.full(3, cells * edge)


def rows_of(center: np.ndarray, cell: np.ndarray, radius: np.ndarray, within: float) -> PairRows:
    """All pairs nearer than the sum of their radii and a distance, images included, by brute force."""
    first, second, separation = [], [], []
    for shift in product((-1, 0, 1), repeat=3):
        way = center[:, None] - center[None] - np.array(shift) * cell
        near = np.linalg.norm(way, axis=2) < radius[:, None] + radius + within
        for i, j in zip(*np.nonzero(near), strict=True):
            if i < j:
                first.append(i)
                second.append(j)
                separation.append(way[i, j])
    one, other = np.array(first), np.array(second)
    return PairRows(one, other, np.array(separation), radius[one] + radius[other])


def forces_left(count: int, pairs: PairRows, force: np.ndarray) -> np.ndarray:
    """The sum of the forces upon each sphere, (N, 3)."""
    total = np.zeros((count, 3))
    unit = pairs.separation / np.linalg.norm(pairs.separation, axis=1)[:, None]
    np.add.at(total, pairs.first, unit * force[:, None])
    np.add.at(total, pairs.second, -unit * force[:, None])
    return total
