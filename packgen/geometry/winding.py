"""How often surfaces wind round points."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.compiled import loop


@loop
def winding_numbers(corner: NDArray[np.float64], point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how often a surface winds around each point: the sum of its solid angles over 4 pi.

    Van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125.

    Args:
        corner: Triangles [m], shape (F, 9), counter-clockwise from outside.
        point: Points [m], shape (N, 3).

    Returns:
        Winding numbers, shape (N,); of a closed surface whole numbers.
    """
    winding = np.zeros(len(point))
    for i in range(len(point)):
        x, y, z = point[i, 0], point[i, 1], point[i, 2]
        total = 0.0
        for f in range(len(corner)):
            ax, ay, az = corner[f, 0] - x, corner[f, 1] - y, corner[f, 2] - z
            bx, by, bz = corner[f, 3] - x, corner[f, 4] - y, corner[f, 5] - z
            cx, cy, cz = corner[f, 6] - x, corner[f, 7] - y, corner[f, 8] - z
            a = math.sqrt(ax * ax + ay * ay + az * az)
            b = math.sqrt(bx * bx + by * by + bz * bz)
            c = math.sqrt(cx * cx + cy * cy + cz * cz)
            top = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
            bottom = (
                a * b * c
                + (ax * bx + ay * by + az * bz) * c
                + (bx * cx + by * cy + bz * cz) * a
                + (cx * ax + cy * ay + cz * az) * b
            )
            total += math.atan2(top, bottom)
        winding[i] = total / (2.0 * math.pi)
    return winding
