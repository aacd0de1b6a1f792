"""All that may be nearest somewhere in a cell, by a look at everything: how lists begin."""

from __future__ import annotations

import numpy as np

from packgen.arrange.space.feature_kernels import closest_on_triangle
from packgen.arrange.void_filling.ball_tree_kernels import LAST, BallTree, octants_below
from packgen.arrange.void_filling.cell_kernels import LISTED, ROUNDING, STACK, Cells, narrow
from packgen.arrange.void_filling.climb_kernels import NEAR_MAX, ROOT3, Bench, look
from packgen.arrange.void_filling.wall_kernels import (
    FACET,
    FACET_CODE,
    IMAGES,
    PLANE_CODE,
    Walls,
    ball_code,
    curved_wall,
    has_image,
    image_shift,
    write_near,
)
from packgen.clumps.tree_kernels import LEAF as FACETS
from packgen.clumps.tree_kernels import box_distance
from packgen.compiled import inner_loop


@inner_loop
def _has_place(walls: Walls, bench: Bench, x: float, y: float, z: float, half: float) -> bool:
    """Tell whether one more thing can be noted, after what is not needed in a cell was forgotten."""
    if bench.known[0] < NEAR_MAX:
        return True
    look(walls, bench, x, y, z, 1.0)
    narrow(bench, half)
    return bool(bench.known[0] <= LISTED)


@inner_loop
def _gather_balls(
    walls: Walls, tree: BallTree, image: int, x: float, y: float, z: float, reach: float, cell_half: float,
    bench: Bench,
) -> bool:  # fmt: skip
    """Note the balls, or copies of them, that are nearer to a point than ``reach``; False: too many."""
    stack = np.empty(STACK, np.int64)
    middle = np.empty((STACK, 4))
    sx, sy, sz = x, y, z
    if image:
        sx -= image_shift(walls, image, 0)
        sy -= image_shift(walls, image, 1)
        sz -= image_shift(walls, image, 2)
    stack[0] = 0
    middle[0, :] = tree.cube
    depth = 1
    while depth > 0:
        depth -= 1
        node = stack[depth]
        mx, my, mz, half = middle[depth, 0], middle[depth, 1], middle[depth, 2], middle[depth, 3]
        if max(abs(sx - mx), abs(sy - my), abs(sz - mz)) >= reach + 2.0 * half:
            continue
        at = tree.first[node]
        while at >= 0:
            dx, dy, dz = sx - tree.ball[at, 0], sy - tree.ball[at, 1], sz - tree.ball[at, 2]
            limit = reach + tree.ball[at, 3]
            if dx * dx + dy * dy + dz * dz < limit * limit:
                if not _has_place(walls, bench, x, y, z, cell_half):
                    return False
                write_near(walls, tree, ball_code(at, image), x, y, z, bench.near[bench.known[0]])
                bench.known[0] += 1
            at = tree.following[at]
        depth = octants_below(tree, node, LAST, mx, my, mz, half, stack, middle, depth)
    return True


@inner_loop
def _gather_facets(
    walls: Walls,
    tree: BallTree,
    x: float,
    y: float,
    z: float,
    reach: float,
    cell_half: float,
    bench: Bench,
) -> bool:
    """Note the triangles that are nearer to a point than ``reach``; False: too many."""
    box = walls.box
    inner = (len(box) - 1) // 2
    stack = np.empty(STACK, np.int64)
    stack[0] = 0
    depth = 1
    while depth > 0:
        depth -= 1
        node = stack[depth]
        if box_distance(box, node, x, y, z) >= reach * reach:
            continue
        if node < inner:
            stack[depth], stack[depth + 1] = 2 * node + 1, 2 * node + 2
            depth += 2
            continue
        first = (node - inner) * FACETS
        for t in range(first, first + FACETS):
            px, py, pz = closest_on_triangle(x, y, z, walls.corner[t])
            px, py, pz = x - px, y - py, z - pz
            if px * px + py * py + pz * pz < reach * reach:
                if not _has_place(walls, bench, x, y, z, cell_half):
                    return False
                write_near(walls, tree, 4 * t + FACET_CODE, x, y, z, bench.near[bench.known[0]])
                bench.known[0] += 1
    return True


@inner_loop
def gather(
    walls: Walls, tree: BallTree, x: float, y: float, z: float, half: float, away: float, bench: Bench
) -> bool:  # fmt: skip
    """Note all that may be nearest somewhere in a cell; False: that is too much.

    Args:
        walls: The walls.
        tree: The spheres.
        x: Middle of the cell [m].
        y: Middle of the cell [m].
        z: Middle of the cell [m].
        half: Half its width [m].
        away: How far the middle is from everything, on whichever side [m].
        bench: Out: what may be nearest, and what `look` writes about it.
    """
    reach = (away + 2.0 * ROOT3 * half) * (1.0 + ROUNDING)
    bench.known[0] = 0
    for k in range(len(walls.plane)):
        row = walls.plane[k]
        if row[3] - (row[0] * x + row[1] * y + row[2] * z) < reach:
            if not _has_place(walls, bench, x, y, z, half):
                return False
            write_near(walls, tree, 4 * k + PLANE_CODE, x, y, z, bench.near[bench.known[0]])
            bench.known[0] += 1
    for k in range(len(walls.cone) + len(walls.hollow)):
        if not _has_place(walls, bench, x, y, z, half):
            return False
        if curved_wall(walls, k, x, y, z, reach, bench.near[bench.known[0]]) < reach:
            bench.known[0] += 1
    for image in range(IMAGES):
        if tree.size[0] == 0 or not has_image(walls, image):
            continue
        if not _gather_balls(walls, tree, image, x, y, z, reach, half, bench):
            return False
    look(walls, bench, x, y, z, 1.0)
    if bench.known[0] > 0:
        narrow(bench, half)
    return bool(bench.known[0] <= LISTED)


@inner_loop
def gather_facets(walls: Walls, tree: BallTree, cells: Cells, cell: int, away: float, bench: Bench) -> bool:
    """Note, beside what is listed, all triangles that may be nearest in a cell; False: that is too much."""
    row = cells.cell[cell]
    reach = (away + 2.0 * ROOT3 * row[3]) * (1.0 + ROUNDING)
    listed = 0
    for k in range(bench.known[0]):  # those that are known come again
        if bench.near[k, 0] != FACET:
            bench.near[listed, :] = bench.near[k]
            listed += 1
    bench.known[0] = listed
    if not _gather_facets(walls, tree, row[0], row[1], row[2], reach, row[3], bench):
        return False
    look(walls, bench, row[0], row[1], row[2], 1.0)
    narrow(bench, row[3])
    return bool(bench.known[0] <= LISTED)
