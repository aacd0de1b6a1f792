"""Which voids there are: cells that may hold the middle of a large sphere, halved until a peak explains them.

How far a place in a cell can be from everything is bounded by how far it is from what is near the cell; a
cell whose bound is too low need not be looked at. Cells wait in the order of their bounds. A bound may be
old: spheres only make it smaller.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.void_filling.ball_tree_kernels import LEVELS, BallTree, add_ball
from packgen.arrange.void_filling.bound_kernels import (
    GATHER,
    LOOKS,
    beyond,
    list_facets,
    listed_bound,
    open_bound,
)
from packgen.arrange.void_filling.cell_kernels import COMPLETE, ENDED, LEAF, LOOSE, OPEN, Cells, list_ball
from packgen.arrange.void_filling.climb_kernels import EVEN, ROOT3, Bench
from packgen.arrange.void_filling.peak_kernels import climb
from packgen.arrange.void_filling.wall_kernels import Walls, nearest_of_all
from packgen.compiled import inner_loop, loop

WAITING, PEAKS, READY, CLIMBS, LOOKED = 0, 1, 2, 3, 4
"""Places in ``Search.size``."""

FINEST = 0.02
"""Half diagonal of a cell, in radii of the sphere found from it, below which that explains it."""

DONE, EXHAUSTED, MORE_ROOM, PAUSED = 0, 1, 2, 3
"""How a search ends: spheres are placed, no void is left, arrays are too short, or steps are used up."""


class Search(NamedTuple):
    """Cells and peaks.

    Attributes:
        cells: The cells.
        hint: Peak found near each cell, -1: none, shape (C,).
        next_cell: Next cell that the same peak explains, -1: none, shape (C,).
        waiting: Heap of cells that no peak explains, shape (C,).
        bound: Largest radius that each of them may have [m], the heap's keys, shape (C,).
        peak: Centres, radii and sure reach [m], shape (P, 5); radius 0: it is no more.
        first_cell: First cell that each peak explains, -1: none, shape (P,).
        ready: Heap of peaks, shape (P,).
        radius: Their radii [m], the heap's keys, shape (P,).
        size: Numbers of all these; see `WAITING` and the like.
        found: Room for a peak, shape (5,).
    """

    cells: Cells
    hint: NDArray[np.int64]
    next_cell: NDArray[np.int64]
    waiting: NDArray[np.int64]
    bound: NDArray[np.float64]
    peak: NDArray[np.float64]
    first_cell: NDArray[np.int64]
    ready: NDArray[np.int64]
    radius: NDArray[np.float64]
    size: NDArray[np.int64]
    found: NDArray[np.float64]


@inner_loop
def push(item: NDArray[np.int64], key: NDArray[np.float64], count: int, new: int, value: float) -> None:
    """Put an item into a heap of ``count`` items, the largest key first, of equal ones the smallest item."""
    at = count
    while at > 0:
        above = (at - 1) // 2
        if key[above] > value or (key[above] == value and item[above] < new):
            break
        item[at], key[at] = item[above], key[above]
        at = above
    item[at], key[at] = new, value


@inner_loop
def pop(item: NDArray[np.int64], key: NDArray[np.float64], count: int) -> None:
    """Take the first item out of a heap of ``count`` items."""
    last, value = item[count - 1], key[count - 1]
    at = 0
    while True:
        below = 2 * at + 1
        if below >= count - 1:
            break
        if below + 1 < count - 1 and (
            key[below + 1] > key[below] or (key[below + 1] == key[below] and item[below + 1] < item[below])
        ):
            below += 1
        if value > key[below] or (value == key[below] and last < item[below]):
            break
        item[at], key[at] = item[below], key[below]
        at = below
    item[at], key[at] = last, value


@inner_loop
def wait(search: Search, cell: int, bound: float) -> None:
    """Have a cell wait to be looked at."""
    push(search.waiting, search.bound, search.size[WAITING], cell, bound)
    search.size[WAITING] += 1


@inner_loop
def explain(search: Search, cell: int, peak: int) -> None:
    """Have a peak explain a cell: nothing in it is larger while the peak is there."""
    search.next_cell[cell] = search.first_cell[peak]
    search.first_cell[peak] = cell


@inner_loop
def end_peak(search: Search, peak: int) -> None:
    """End a peak; the cells that it explains wait again."""
    bound = search.peak[peak, 3] * (1.0 + EVEN)
    search.peak[peak, 3] = 0.0
    cell = search.first_cell[peak]
    while cell >= 0:
        following = search.next_cell[cell]
        wait(search, cell, bound)
        cell = following
    search.first_cell[peak] = -1


@inner_loop
def explains(search: Search, peak: int, cell: int) -> bool:
    """Tell whether a peak that is there explains a cell."""
    if peak < 0 or search.peak[peak, 3] <= 0.0:
        return False
    row, at = search.cells.cell[cell], search.peak[peak]
    dx, dy, dz = row[0] - at[0], row[1] - at[1], row[2] - at[2]
    return bool(math.sqrt(dx * dx + dy * dy + dz * dz) + ROOT3 * row[3] <= at[4])


@inner_loop
def halve(
    walls: Walls,
    tree: BallTree,
    bench: Bench,
    search: Search,
    cell: int,
    hint: int,
    least: float,
    goal: float,
) -> None:
    """Put eight cells of half the width in the place of one; they know what it knows."""
    cells = search.cells
    row = cells.cell[cell]
    x, y, z, half = row[0], row[1], row[2], 0.5 * row[3]
    first = int(cells.total[0])
    cells.total[0] += 8
    if 2.0 * ROOT3 * half <= GATHER * goal:
        list_facets(walls, tree, bench, cells, cell)
    listed, state, bound = cells.listed[cell], cells.state[cell], cells.top[cell]
    for octant in range(8):
        new = first + octant
        at = cells.cell[new]
        at[0] = x + (half if octant & 1 else -half)
        at[1] = y + (half if octant & 2 else -half)
        at[2] = z + (half if octant & 4 else -half)
        at[3] = half
        cells.top[new], cells.child[new], cells.away[new] = bound, LEAF, np.inf
        cells.state[new] = state if state == COMPLETE else (LOOSE if state & 1 else OPEN)
        cells.stale[new] = True
        cells.listed[new] = listed
        cells.item[new, :listed] = cells.item[cell, :listed]
        search.hint[new] = hint
        own = bound
        if state & 1:
            own = listed_bound(walls, tree, bench, cells, search.found, new, goal, 0)
            apart = state == COMPLETE and cells.away[new] > ROOT3 * half
            if own < least or (apart and len(walls.box) and beyond(walls, tree, bench, cells, new)):
                cells.child[new] = ENDED
                continue
        wait(search, new, own)
    cells.child[cell] = first


@inner_loop
def look_at_first(
    walls: Walls, tree: BallTree, bench: Bench, search: Search, least: float, enough: float, finest: float
) -> None:
    """Look at the cell that waits first: drop it, lower its bound, find its peak, or halve it.

    Args:
        walls: The walls.
        tree: The spheres.
        bench: Room for climbing.
        search: Cells and peaks.
        least: Radius below which nothing is wanted [m].
        enough: What a bound need not be lowered below now [m].
        finest: Half diagonal of a cell, in radii of the sphere found from it, below which that explains it.
    """
    size, cells = search.size, search.cells
    cell = search.waiting[0]
    pop(search.waiting, search.bound, size[WAITING])
    size[WAITING] -= 1
    if cells.child[cell] != LEAF:
        return
    size[LOOKED] += 1
    others = search.bound[0] if size[WAITING] > 0 else 0.0
    hint = search.hint[cell]
    if explains(search, hint, cell):
        explain(search, cell, hint)
        return
    goal = max(enough, least, others * (1.0 - 1e-9))
    if not cells.stale[cell] and cells.top[cell] <= goal:
        bound = cells.top[cell]
    elif cells.state[cell] & 1:
        bound = listed_bound(walls, tree, bench, cells, search.found, cell, goal, LOOKS)
    else:
        bound = open_bound(walls, tree, bench, cells, search.found, cell, goal)
    if bound < least:
        cells.child[cell] = ENDED
        return
    if bound <= goal:
        wait(search, cell, bound)
        return
    found = search.found
    reach = ROOT3 * cells.cell[cell, 3]
    if reach <= found[3]:
        radius = climb(walls, tree, cells, bench, found[:3].copy(), np.inf, found)
        size[CLIMBS] += 1
        if radius >= least:
            hint = peak_of(search, hint, found)
            if reach <= finest * radius or bound <= radius * (1.0 + EVEN) or explains(search, hint, cell):
                explain(search, cell, hint)
                return
        elif reach <= FINEST * least:
            cells.child[cell] = ENDED
            return
    halve(walls, tree, bench, search, cell, hint, least, goal)


@inner_loop
def peak_of(search: Search, hint: int, found: NDArray[np.float64]) -> int:
    """Return the number of a peak that was found: that of ``hint`` where it is the same, or a new one."""
    if hint >= 0 and search.peak[hint, 3] > 0.0:
        at = search.peak[hint]
        apart = max(abs(found[0] - at[0]), abs(found[1] - at[1]), abs(found[2] - at[2]))
        if apart <= 1e-7 * found[3]:
            return hint
    number = int(search.size[PEAKS])
    search.size[PEAKS] += 1
    search.peak[number, :] = found
    search.first_cell[number] = -1
    push(search.ready, search.radius, search.size[READY], number, found[3])
    search.size[READY] += 1
    return number


@inner_loop
def has_room(tree: BallTree, search: Search) -> bool:
    """Tell whether the arrays have room for one more step."""
    return bool(
        tree.size[0] < len(tree.ball)
        and tree.size[1] + LEVELS < len(tree.first)
        and search.cells.total[0] + 8 < len(search.cells.cell)
        and search.size[PEAKS] + 1 < len(search.peak)
    )


@inner_loop
def put_ball(
    walls: Walls, tree: BallTree, search: Search, x: float, y: float, z: float, radius: float
) -> None:
    """Add a ball, of which the cells come to know."""
    add_ball(tree, x, y, z, radius)
    list_ball(walls, tree, search.cells, tree.size[0] - 1)


@loop
def fill_freely(
    walls: Walls, tree: BallTree, bench: Bench, search: Search, least: float, slack: float,
    limits: NDArray[np.float64],
) -> int:  # fmt: skip
    """Add the largest sphere that fits, again and again.

    Args:
        walls: The walls.
        tree: The spheres; grows.
        bench: Room for climbing.
        search: Cells and peaks; change.
        least: Least radius [m].
        slack: What a radius is smaller than the void, for rounding [m].
        limits: Spheres to add, solid volume to add over 4 pi / 3 [m3], steps; change, shape (3,).

    Returns:
        `DONE`, `EXHAUSTED`, `MORE_ROOM` or `PAUSED`.
    """
    size = search.size
    while limits[0] >= 1.0 and limits[1] > 0.0:
        if not has_room(tree, search):
            return MORE_ROOM
        if limits[2] < 1.0:
            return PAUSED
        limits[2] -= 1.0
        best = search.radius[0] if size[READY] > 0 else 0.0
        if size[WAITING] > 0 and search.bound[0] > best * (1.0 + EVEN):
            look_at_first(walls, tree, bench, search, least, best * (1.0 + EVEN), FINEST)
            continue
        if size[READY] == 0:
            return EXHAUSTED
        number = search.ready[0]
        pop(search.ready, search.radius, size[READY])
        size[READY] -= 1
        peak = search.peak[number]
        bench.fresh[0] = -1.0
        x, y, z, radius = peak[0], peak[1], peak[2], peak[3]
        away = nearest_of_all(walls, tree, x, y, z, radius, bench.fresh)
        if away < radius * (1.0 - 1e-13):
            end_peak(search, number)
            continue
        radius = away - slack
        put_ball(walls, tree, search, x, y, z, radius)
        end_peak(search, number)
        limits[0] -= 1.0
        limits[1] -= radius * radius * radius
    return DONE
