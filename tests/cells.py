"""Beds in periodic cells of any shape, made by hand: close packings, and random spheres in a skewed cell."""

from __future__ import annotations

import numpy as np

from packgen.bed import Bed
from packgen.geometry.cells import cell_container, upright_cell
from tests.beds import make_bed

FCC = np.array([[1.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]) / np.sqrt(2.0)
SKEWED = np.array([[3.0, 0, 0], [1.2, 2.8, 0], [-1.4, 1.1, 2.5]])


def close_packing(radius: float = 0.5) -> Bed:
    """The one sphere of the face-centred cubic lattice, which touches twelve images of itself."""
    vectors, _ = upright_cell(2.0 * 0.5 * FCC)
    return make_bed(np.full((1, 3), 0.1), radius, cell_container(vectors), gravity=np.zeros(3))


def random_spheres(count: int = 40, seed: int = 0) -> Bed:
    """Random spheres of many sizes that overlap, across the seams too."""
    rng = np.random.default_rng(seed)
    radius = 0.1 + 0.3 * rng.random(count)
    return make_bed(rng.random((count, 3)) @ SKEWED, radius, cell_container(SKEWED), gravity=np.zeros(3))


def all_gaps(bed: Bed, reach: int = 3) -> np.ndarray:
    """Gaps of all pairs of a bed's spheres and images, each once, as fractions of the smaller radius."""
    assert bed.container.cell is not None
    found = []
    for x in range(-reach, reach + 1):
        for y in range(-reach, reach + 1):
            for z in range(-reach, reach + 1):
                shift = np.array([x, y, z]) @ bed.container.cell
                distance = np.linalg.norm(bed.position[:, None] - bed.position[None] + shift, axis=2)
                gap = distance - bed.radius[:, None] - bed.radius
                gap /= np.minimum(bed.radius[:, None], bed.radius)
                first, second = np.triu_indices(bed.count, 0 if (x, y, z) > (0, 0, 0) else 1)
                if (x, y, z) > (0, 0, 0):
                    found.append(gap.ravel())
                elif (x, y, z) == (0, 0, 0):
                    found.append(gap[first, second])
    return np.concatenate(found)
