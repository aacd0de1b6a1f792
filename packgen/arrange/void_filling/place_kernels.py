"""A drawn sphere in a void: from the void's middle down until three walls or spheres hold it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.void_filling.ball_tree_kernels import BallTree
from packgen.arrange.void_filling.cell_kernels import Cells, nearest_at
from packgen.arrange.void_filling.climb_kernels import BOXED, Bench, box_rows, keep_in_mind, look
from packgen.arrange.void_filling.linear_kernels import solve_small
from packgen.arrange.void_filling.search_kernels import (
    DONE,
    MORE_ROOM,
    PAUSED,
    PEAKS,
    READY,
    WAITING,
    Search,
    end_peak,
    has_room,
    look_at_first,
    push,
    put_ball,
)
from packgen.arrange.void_filling.wall_kernels import Walls
from packgen.compiled import inner_loop, loop

ROUNDS = 400
COARSE = 0.5
"""Half diagonal of a cell, in radii of the void found from it, below which that explains it: of two voids in
so small a place either will do."""

STEP = 0.5
NEAR_ENOUGH = 1.0e-13
"""Progress, in radii, at which a sphere is held."""


@inner_loop
def _lowest(bench: Bench, down: NDArray[np.float64], radius: float, step: float) -> bool:
    """Solve for the farthest step down that keeps a sphere apart from all that is near."""
    box_rows(bench, step)
    bench.bound[BOXED] = 0.0
    for k in range(bench.known[0]):
        bench.bound[BOXED + 1 + k] = bench.away[k] - radius
    bench.inverse[:, :] = 0.0
    bench.basis[0] = BOXED
    bench.inverse[3, 0] = bench.inverse[4, 0] = 1.0
    for k in range(3):
        sign = 1.0 if down[k] >= 0.0 else -1.0
        bench.basis[1 + k] = 2 * k + (0 if down[k] >= 0.0 else 1)
        bench.inverse[k, 1 + k] = sign
        bench.inverse[4, 1 + k] = abs(down[k])
    rows = BOXED + 1 + bench.known[0]
    return solve_small(bench.row, bench.bound, rows, bench.basis, bench.inverse, bench.found, 1e-15 * radius)


@inner_loop
def sink(
    walls: Walls, tree: BallTree, cells: Cells, bench: Bench, place: NDArray[np.float64], radius: float,
    down: NDArray[np.float64],
) -> None:  # fmt: skip
    """Move a sphere that fits at a place down to where it is held.

    Args:
        walls: The walls.
        tree: The spheres.
        cells: Cells and what is near them.
        bench: Room for it.
        place: Centre [m], shape (3,); changes.
        radius: Its radius [m].
        down: Unit vector, shape (3,).
    """
    bench.known[0] = 0
    bench.fresh[0] = -1.0
    x, y, z = place[0], place[1], place[2]
    away = nearest_at(walls, tree, cells, x, y, z, np.inf, bench.fresh)
    keep_in_mind(bench)
    step = STEP * away
    for _ in range(ROUNDS):
        look(walls, bench, x, y, z, 0.0)
        if not _lowest(bench, down, radius, step):
            step *= 0.5
            if step < NEAR_ENOUGH * radius:
                break
            continue
        found = bench.found
        gain = found[0] * down[0] + found[1] * down[1] + found[2] * down[2]
        if gain <= NEAR_ENOUGH * radius:
            break
        nx, ny, nz = x + found[0], y + found[1], z + found[2]
        within = look(walls, bench, nx, ny, nz, 0.0)
        bench.fresh[0] = -1.0
        away = nearest_at(walls, tree, cells, nx, ny, nz, within, bench.fresh)
        fresh = away < radius * 3.0 and keep_in_mind(bench)
        if away >= radius:
            x, y, z = nx, ny, nz
            step = STEP * away
        elif not fresh:
            step *= 0.5
            if step < NEAR_ENOUGH * radius:
                break
    place[0], place[1], place[2] = x, y, z


@inner_loop
def smallest_void(search: Search, radius: float) -> int:
    """Return the peak of the smallest void that takes a radius [m]; -1: none does."""
    best = -1
    for k in range(search.size[PEAKS]):
        value = search.peak[k, 3]
        if value >= radius and (best < 0 or value < search.peak[best, 3]):
            best = k
    return best


@inner_loop
def end_voids_at(walls: Walls, search: Search, x: float, y: float, z: float, radius: float) -> None:
    """End the peaks that a new sphere cuts."""
    for k in range(search.size[PEAKS]):
        own = search.peak[k, 3]
        if own <= 0.0:
            continue
        square = 0.0
        for axis in range(3):
            apart = search.peak[k, axis] - (x if axis == 0 else (y if axis == 1 else z))
            period = walls.period[axis]
            if period > 0.0:
                apart -= period * np.round(apart / period)
            square += apart * apart
        reach = (own + radius) * (1.0 - 1e-12)
        if square < reach * reach:
            end_peak(search, k)


@inner_loop
def forget_ended(search: Search) -> None:
    """Take ended peaks out of the list where they are most of it; cells forget their hints."""
    kept = 0
    for k in range(search.size[PEAKS]):
        kept += 1 if search.peak[k, 3] > 0.0 else 0
    if 2 * kept > search.size[PEAKS] or search.size[PEAKS] < 256:
        return
    kept = 0
    for k in range(search.size[PEAKS]):
        if search.peak[k, 3] > 0.0:
            search.peak[kept, :] = search.peak[k]
            search.first_cell[kept] = search.first_cell[k]
            kept += 1
    search.size[PEAKS] = kept
    search.hint[:] = -1
    search.size[READY] = 0


@loop
def fill_drawn(
    walls: Walls, tree: BallTree, bench: Bench, search: Search, radii: NDArray[np.float64],
    placed: NDArray[np.bool_], down: NDArray[np.float64], least: float, slack: float,
    limits: NDArray[np.float64],
) -> int:  # fmt: skip
    """Put spheres of given radii into the smallest voids that take them, one after the other.

    Args:
        walls: The walls.
        tree: The spheres; grows.
        bench: Room for climbing.
        search: Cells and peaks; change.
        radii: Radii, the largest first [m], shape (N,).
        placed: Out: which have found a place, shape (N,).
        down: Unit vector to where a sphere sinks in its void, shape (3,).
        least: Radius below which no void will be wanted later [m].
        slack: Distance that is kept, for rounding [m].
        limits: Sphere to go on with, solid volume to add over 4 pi / 3 [m3], steps; change, shape (3,).

    Returns:
        `DONE`, `MORE_ROOM` or `PAUSED`.
    """
    size = search.size
    place = np.empty(3)
    while limits[0] < len(radii) and limits[1] > 0.0:
        if not has_room(tree, search):
            return MORE_ROOM
        if limits[2] < 1.0:
            return PAUSED
        limits[2] -= 1.0
        number = int(limits[0])
        radius = radii[number] + slack
        if size[WAITING] > 0 and search.bound[0] >= radius:
            look_at_first(walls, tree, bench, search, least, radius * (1.0 - 1e-12), COARSE)
            size[READY] = 0
            continue
        limits[0] += 1.0
        void = smallest_void(search, radius)
        if void < 0:
            continue
        place[0], place[1], place[2] = search.peak[void, 0], search.peak[void, 1], search.peak[void, 2]
        sink(walls, tree, search.cells, bench, place, radius, down)
        placed[number] = True
        put_ball(walls, tree, search, place[0], place[1], place[2], radii[number])
        limits[1] -= radii[number] * radii[number] * radii[number]
        end_voids_at(walls, search, place[0], place[1], place[2], radius)
        forget_ended(search)
    return DONE


@loop
def list_peaks(search: Search) -> None:
    """Put all peaks into the heap, and have those that ended be forgotten."""
    from_list = search.size[PEAKS]
    search.size[READY] = 0
    for k in range(from_list):
        if search.peak[k, 3] > 0.0:
            push(search.ready, search.radius, search.size[READY], k, search.peak[k, 3])
            search.size[READY] += 1
