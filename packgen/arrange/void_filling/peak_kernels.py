"""The way up from a point in a void to its largest sphere."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.void_filling.ball_tree_kernels import BallTree
from packgen.arrange.void_filling.cell_kernels import Cells, nearest_at
from packgen.arrange.void_filling.climb_kernels import EVEN, Bench, highest, keep_in_mind, look, sure_reach
from packgen.arrange.void_filling.wall_kernels import Walls
from packgen.compiled import inner_loop

ROUNDS = 80
STEP = 0.5
"""First length of a step along each axis, in radii; no step reaches a wall."""

STEP_MAX = 0.55


@inner_loop
def climb(
    walls: Walls, tree: BallTree, cells: Cells, bench: Bench, start: NDArray[np.float64], cap: float,
    peak: NDArray[np.float64],
) -> float:  # fmt: skip
    """Go up from a point in a void to its largest sphere.

    Args:
        walls: The walls.
        tree: The spheres.
        cells: Cells and what is near them.
        bench: What is known to be near already.
        start: The point [m], shape (3,).
        cap: A radius that is enough [m].
        peak: Out: centre, radius and the reach of `sure_reach` [m], shape (5,).

    Returns:
        The radius [m]; 0 or less where the point is in no void.
    """
    x, y, z = start[0], start[1], start[2]
    bench.fresh[0] = -1.0
    within = look(walls, bench, x, y, z, 1.0)
    radius = nearest_at(walls, tree, cells, x, y, z, within, bench.fresh)
    peak[0], peak[1], peak[2], peak[3], peak[4] = x, y, z, radius, 0.0
    if radius <= 0.0 or radius == np.inf:
        return radius
    keep_in_mind(bench)
    step, tries = STEP * radius, 0
    for _ in range(ROUNDS):
        look(walls, bench, x, y, z, 1.0)
        highest(bench, step)
        found = bench.found
        gain = found[3] - radius
        moved = max(abs(found[0]), abs(found[1]), abs(found[2]))
        if moved <= 1e-15 * radius or (gain <= 1e-15 * radius and tries > 3):
            break
        nx, ny, nz = x + found[0], y + found[1], z + found[2]
        within = look(walls, bench, nx, ny, nz, 1.0)
        bench.fresh[0] = -1.0
        reached = nearest_at(walls, tree, cells, nx, ny, nz, within, bench.fresh)
        fresh = keep_in_mind(bench)
        if reached >= radius:
            # A ridge that is as high all along is followed to where something ends it.
            if reached > radius * (1.0 + 1e-14):
                tries = 0
            elif moved < 0.999 * step:
                tries += 1
            if moved >= 0.999 * step:
                step = min(2.0 * step, STEP_MAX * reached)
            x, y, z, radius = nx, ny, nz, reached
            if radius >= cap:
                break
        elif not fresh or moved < 1e-3 * step:
            tries += 1
            step = 0.25 * min(step, moved)
        if tries > 6 or step < 1e-14 * radius:
            break
    look(walls, bench, x, y, z, 1.0)
    highest(bench, 0.02 * radius)
    peak[0], peak[1], peak[2], peak[3] = x, y, z, radius
    peak[4] = sure_reach(bench, radius) if bench.found[3] <= radius * (1.0 + 0.1 * EVEN) else 0.0
    return radius
