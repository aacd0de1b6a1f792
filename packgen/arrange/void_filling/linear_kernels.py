"""Linear programmes in four unknowns, by the dual simplex method: a few rows, thousands of times a second.

Every programme here has a corner to start from that no row makes better, so that it is solved by letting
violated rows in, one by one (Lemke, Nav. Res. Logist. Q. 1 (1954) 36).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.compiled import inner_loop

PIVOTS = 60
"""Rows that enter at most."""

SMALL = 1.0e-10
"""Pivots below it are taken for zero; rows are unit vectors, or nearly."""


@inner_loop
def solve_small(
    row: NDArray[np.float64],
    bound: NDArray[np.float64],
    count: int,
    basis: NDArray[np.int64],
    inverse: NDArray[np.float64],
    found: NDArray[np.float64],
    slack: float,
) -> bool:
    """Make a linear objective as large as rows allow: each row times the unknowns is at most its bound.

    Args:
        row: Rows, shape (K, 4).
        bound: Their bounds, shape (K,).
        count: How many of them count.
        basis: In: four rows that bound the objective; out: those that hold at the end, shape (4,).
        inverse: In: the inverse of the rows of ``basis``; in its fifth line that times the objective, the
            dual values, none below 0; out: the same at the end, shape (5, 4).
        found: Out: the unknowns, shape (4,).
        slack: By how much a row may be missed.

    Returns:
        Whether there is a solution; without one, ``found`` keeps the rows of ``basis`` alone.
    """
    for _ in range(PIVOTS):
        for k in range(4):
            total = 0.0
            for i in range(4):
                total += inverse[k, i] * bound[basis[i]]
            found[k] = total
        worst, entering = slack, -1
        for j in range(count):
            off = -bound[j]
            for k in range(4):
                off += row[j, k] * found[k]
            if off > worst and j != basis[0] and j != basis[1] and j != basis[2] and j != basis[3]:
                worst, entering = off, j
        if entering < 0:
            return True
        leaving, least = -1, np.inf
        share = np.empty(4)
        for i in range(4):
            share[i] = 0.0
            for k in range(4):
                share[i] += row[entering, k] * inverse[k, i]
            if share[i] > SMALL and inverse[4, i] < least * share[i]:
                leaving, least = i, inverse[4, i] / share[i]
        if leaving < 0:
            return False
        basis[leaving] = entering
        scale = 1.0 / share[leaving]
        for k in range(5):
            pivot = inverse[k, leaving] * scale
            for i in range(4):
                inverse[k, i] -= share[i] * pivot
            inverse[k, leaving] = pivot
    return True
