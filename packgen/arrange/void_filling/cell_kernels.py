"""Cells of an octree, each with a list of the walls and spheres that may be nearest in it.

A list that is complete answers what is nearest to a place by a dozen distances. A cell's list is what of its
parent's list, or of everything, can be nearest somewhere in the cell; each new sphere joins the lists of the
cells in which it may be nearest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.space.feature_kernels import closest_on_triangle
from packgen.arrange.void_filling.ball_tree_kernels import LEVELS, BallTree
from packgen.arrange.void_filling.climb_kernels import BOXED, ROOT3, Bench
from packgen.arrange.void_filling.wall_kernels import (
    BALL_CODE,
    CURVED_CODE,
    FACET,
    FACET_CODE,
    IMAGE_BITS,
    IMAGES,
    PLANE_CODE,
    ROUND,
    TIE,
    Walls,
    ball_code,
    curved_wall,
    has_image,
    image_shift,
    is_inside,
    nearest_of_all,
    nearest_triangle,
    squarer,
    write_near,
)
from packgen.compiled import inner_loop

LISTED = 32
"""What the list of a cell holds at most."""

NEAREST_FEW = 8
"""What it holds where all is too much, and how many spheres to come it keeps room for beside triangles."""

LEAF, ENDED = 0, -1
"""In the place of a cell's first child: it has none; or nothing in it is wanted any more."""

OPEN, COMPLETE, WIDE, LOOSE = 0, 1, 2, 3
"""What a list has of that which is nearest somewhere in its cell: not known; all; not all, which is too much;
all but triangles, of which it has some. Odd: all spheres."""

STACK = 8 * LEVELS

ROUNDING = 1.0e-9
"""Part of a distance by which what is farther may still be listed."""


class Cells(NamedTuple):
    """The cells, of which eight neighbours are one after the other.

    Attributes:
        cell: Middle and half width [m], shape (C, 4).
        child: First child of each cell, or `LEAF` or `ENDED`, shape (C,).
        top: How far from everything no place in it is [m], shape (C,).
        away: How far its middle is from what is listed [m], shape (C,).
        item: Codes of what is listed (see `write_near`), shape (C, LISTED).
        listed: How many these are, shape (C,).
        state: `COMPLETE` and the like, shape (C,).
        stale: Whether the list has grown since the cell was looked at, shape (C,).
        total: Number of cells, shape (1,).
    """

    cell: NDArray[np.float64]
    child: NDArray[np.int32]
    top: NDArray[np.float64]
    away: NDArray[np.float64]
    item: NDArray[np.int32]
    listed: NDArray[np.int32]
    state: NDArray[np.int8]
    stale: NDArray[np.bool_]
    total: NDArray[np.int64]


@inner_loop
def leaf_at(cells: Cells, x: float, y: float, z: float) -> int:
    """Return the cell without children that holds a point, -1: none does."""
    row = cells.cell[0]
    if max(abs(x - row[0]), abs(y - row[1]), abs(z - row[2])) > row[3]:
        return -1
    at = 0
    while cells.child[at] > 0:
        row = cells.cell[at]
        at = cells.child[at] + (
            (1 if x >= row[0] else 0) + (2 if y >= row[1] else 0) + (4 if z >= row[2] else 0)
        )
    return int(at)


@inner_loop
def nearest_listed(
    walls: Walls, tree: BallTree, cells: Cells, cell: int, x: float, y: float, z: float, within: float,
    near: NDArray[np.float64],
) -> float:  # fmt: skip
    """Find what is nearest to a point in a cell whose list has all spheres, as `nearest_of_all` does."""
    best, code = within, -1
    facet, square_on, side, least = -1, 0.0, 1.0, np.inf
    for k in range(cells.listed[cell]):
        item = cells.item[cell, k]
        kind, number = item & 3, item >> 2
        if kind == BALL_CODE:
            image, number = number & (1 << IMAGE_BITS) - 1, number >> IMAGE_BITS
            dx, dy, dz = x - tree.ball[number, 0], y - tree.ball[number, 1], z - tree.ball[number, 2]
            if image:
                dx -= image_shift(walls, image, 0)
                dy -= image_shift(walls, image, 1)
                dz -= image_shift(walls, image, 2)
            gap = math.sqrt(dx * dx + dy * dy + dz * dz) - tree.ball[number, 3]
            if gap < best:
                best, code = gap, item
        elif kind == FACET_CODE:
            px, py, pz = closest_on_triangle(x, y, z, walls.corner[number])
            px, py, pz = x - px, y - py, z - pz
            square = px * px + py * py + pz * pz
            if square > least * (1.0 + TIE):
                continue
            normal = walls.normal[number]
            across = px * normal[0] + py * normal[1] + pz * normal[2]
            new = square < least * (1.0 - TIE)
            if new or squarer(across, square_on):
                facet, square_on, side = item, abs(across), 1.0 if across <= 0.0 else -1.0
            least = min(least, square)
        elif kind == PLANE_CODE:
            row = walls.plane[number]
            gap = row[3] - (row[0] * x + row[1] * y + row[2] * z)
            if gap < best:
                best, code = gap, item
        else:
            gap = curved_wall(walls, number, x, y, z, best, near)
            if gap < best:
                best, code = gap, -1
    if code >= 0:
        write_near(walls, tree, code, x, y, z, near)
    if cells.state[cell] != COMPLETE and len(walls.box) and best > 0.0:
        number, away, side = nearest_triangle(walls, x, y, z, min(best, math.sqrt(least)) * (1.0 + 1e-9))
        if number >= 0 and away < best:
            write_near(walls, tree, 4 * number + FACET_CODE, x, y, z, near)
            best = away
        if not is_inside(walls, x, y, z, side):
            best = -best
    elif len(walls.box) and best > 0.0:
        away = math.sqrt(least)
        if facet < 0 or away > best * (1.0 + 1e-9):
            side = 1.0
        if facet >= 0 and away < best:
            write_near(walls, tree, facet, x, y, z, near)
            best = away
        if not is_inside(walls, x, y, z, side):
            best = -best
    return best


@inner_loop
def nearest_at(
    walls: Walls, tree: BallTree, cells: Cells, x: float, y: float, z: float, within: float,
    near: NDArray[np.float64],
) -> float:  # fmt: skip
    """Find what is nearest to a point, as `nearest_of_all` does, by the list of its cell where it can."""
    cell = leaf_at(cells, x, y, z)
    if cell >= 0 and cells.child[cell] == LEAF and cells.state[cell] & 1:
        return nearest_listed(walls, tree, cells, cell, x, y, z, within, near)
    return nearest_of_all(walls, tree, x, y, z, within, near)


@inner_loop
def recall(walls: Walls, tree: BallTree, cells: Cells, cell: int, bench: Bench) -> None:
    """Take what the list of a cell has."""
    row = cells.cell[cell]
    bench.known[0] = cells.listed[cell]
    for k in range(cells.listed[cell]):
        code = int(cells.item[cell, k])
        number = code >> 2 + IMAGE_BITS
        if code & 3 == FACET_CODE:
            bench.near[k, 0], bench.near[k, 5], bench.near[k, 6] = FACET, code >> 2, code
        elif code & ((4 << IMAGE_BITS) - 1) == BALL_CODE:  # itself, not a copy: often, so without a call
            bench.near[k, 0], bench.near[k, 5], bench.near[k, 6] = ROUND, number, code
            bench.near[k, 1], bench.near[k, 2] = tree.ball[number, 0], tree.ball[number, 1]
            bench.near[k, 3], bench.near[k, 4] = tree.ball[number, 2], tree.ball[number, 3]
        else:
            write_near(walls, tree, code, row[0], row[1], row[2], bench.near[k])


@inner_loop
def narrow(bench: Bench, half: float) -> float:
    """Forget what is nowhere nearest in a cell at whose middle `look` was called; return the least distance.

    What is farther than the nearest thing by more than the difference of their directions makes up for,
    within the cell, and by more than the curvature of the latter adds, is not. Distances are convex, but for
    those of curved walls, of which only tangent planes are known.
    """
    count = bench.known[0]
    nearest = 0
    for k in range(count):
        nearest = k if bench.away[k] < bench.away[nearest] else nearest
    least, first = bench.away[nearest], BOXED + 1 + nearest
    gx, gy, gz = bench.row[first, 0], bench.row[first, 1], bench.row[first, 2]
    extra = min(1.5 * half * half * bench.bend[nearest], 2.0 * ROOT3 * half) + ROUNDING * (abs(least) + half)
    kept = 0
    for k in range(count):
        at = BOXED + 1 + k
        limit = 2.0 * ROOT3 * half
        if int(bench.near[k, 6]) & 3 != CURVED_CODE:
            apart = abs(bench.row[at, 0] - gx) + abs(bench.row[at, 1] - gy) + abs(bench.row[at, 2] - gz)
            limit = min(limit, half * apart + extra)
        if bench.away[k] - least > limit + ROUNDING * half:
            continue
        if kept < k:
            bench.near[kept, :] = bench.near[k]
            bench.away[kept], bench.bend[kept] = bench.away[k], bench.bend[k]
            bench.row[BOXED + 1 + kept, :] = bench.row[at]
        kept += 1
    bench.known[0] = kept
    return float(least)


@inner_loop
def note(cells: Cells, cell: int, bench: Bench, state: int) -> None:
    """List in a cell what is known to be near it; where that is too much, the nearest few."""
    count = bench.known[0]
    if count <= LISTED:
        for k in range(count):
            cells.item[cell, k] = int(bench.near[k, 6])
        cells.listed[cell], cells.state[cell] = count, state
        return
    cells.state[cell] = WIDE
    listed = 0
    for place in range(NEAREST_FEW):
        best = -1
        for k in range(count):
            if bench.away[k] < np.inf and (best < 0 or bench.away[k] < bench.away[best]):
                best = k
        if best < 0:
            break
        cells.item[cell, place] = int(bench.near[best, 6])
        bench.away[best] = np.inf
        listed += 1
    cells.listed[cell] = listed


@inner_loop
def note_facets(cells: Cells, cell: int, bench: Bench, first: int) -> None:
    """List in a cell the triangles known since there were ``first`` things, as far as it has room."""
    for k in range(first, bench.known[0]):
        if bench.near[k, 0] == FACET and cells.listed[cell] < LISTED - NEAREST_FEW:
            cells.item[cell, cells.listed[cell]] = int(bench.near[k, 6])
            cells.listed[cell] += 1


@inner_loop
def _list_ball(cells: Cells, code: int, x: float, y: float, z: float, radius: float) -> None:
    """Have a ball join the lists of the cells in which it may be nearest; end those that it covers."""
    stack = np.empty(STACK, np.int64)
    stack[0] = 0
    depth = 1
    while depth > 0:
        depth -= 1
        at = stack[depth]
        child = cells.child[at]
        if child == ENDED:
            continue
        row = cells.cell[at]
        half = row[3]
        dx, dy, dz = abs(x - row[0]), abs(y - row[1]), abs(z - row[2])
        ox, oy, oz = max(dx - half, 0.0), max(dy - half, 0.0), max(dz - half, 0.0)
        limit = radius + cells.top[at]
        if ox * ox + oy * oy + oz * oz > limit * limit * (1.0 + ROUNDING):
            continue
        if child > 0:
            for k in range(8):
                stack[depth + k] = child + k
            depth += 8
            continue
        fx, fy, fz = dx + half, dy + half, dz + half
        if fx * fx + fy * fy + fz * fz < radius * radius:
            cells.child[at] = ENDED
            continue
        away = math.sqrt(dx * dx + dy * dy + dz * dz) - radius
        if cells.state[at] & 1 == 0:
            cells.stale[at] = True
            continue
        if away - cells.away[at] > 2.0 * ROOT3 * half * (1.0 + ROUNDING):
            continue
        cells.stale[at] = True
        if cells.listed[at] == LISTED:
            cells.state[at] = OPEN
            continue
        cells.item[at, cells.listed[at]] = code
        cells.listed[at] += 1
        cells.away[at] = min(cells.away[at], away)


@inner_loop
def list_ball(walls: Walls, tree: BallTree, cells: Cells, number: int) -> None:
    """Have a ball and its copies join the lists of the cells in which they may be nearest."""
    ball = tree.ball[number]
    for image in range(IMAGES):
        if not has_image(walls, image):
            continue
        _list_ball(
            cells, ball_code(number, image),
            ball[0] + image_shift(walls, image, 0), ball[1] + image_shift(walls, image, 1),
            ball[2] + image_shift(walls, image, 2), ball[3],
        )  # fmt: skip
