"""How large the spheres may be that have their centres in a cell, by what is near it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.void_filling.ball_tree_kernels import BallTree
from packgen.arrange.void_filling.cell_kernels import (
    COMPLETE,
    LISTED,
    LOOSE,
    OPEN,
    WIDE,
    Cells,
    narrow,
    nearest_listed,
    note,
    note_facets,
    recall,
)
from packgen.arrange.void_filling.climb_kernels import ROOT3, Bench, highest_in_cell, keep_in_mind, look
from packgen.arrange.void_filling.gather_kernels import gather, gather_facets
from packgen.arrange.void_filling.wall_kernels import Walls, nearest_of_all
from packgen.compiled import inner_loop

GATHER = 0.7
"""Half diagonal of a cell, in radii of the largest void, from which all that is near it is looked for."""

LOOKS = 4
"""Places of a cell that are looked at before it is halved."""


@inner_loop
def list_facets(walls: Walls, tree: BallTree, bench: Bench, cells: Cells, cell: int) -> None:
    """Complete the list of a cell that has all but triangles, unless these are too many."""
    if cells.state[cell] != LOOSE or cells.listed[cell] == 0:
        return
    row = cells.cell[cell]
    recall(walls, tree, cells, cell, bench)
    away = look(walls, bench, row[0], row[1], row[2], 1.0)
    if gather_facets(walls, tree, cells, cell, away, bench):
        note(cells, cell, bench, COMPLETE)


@inner_loop
def listed_bound(
    walls: Walls,
    tree: BallTree,
    bench: Bench,
    cells: Cells,
    found: NDArray[np.float64],
    cell: int,
    enough: float,
    looks: int,
) -> float:
    """Return how large the spheres may be that have their centres in a cell of a complete list [m].

    The list becomes as short as may be. The place to climb from is in ``found``, its distance from
    everything in ``found[3]``.
    """
    row = cells.cell[cell]
    x, y, z, half = row[0], row[1], row[2], row[3]
    found[0], found[1], found[2], found[3] = x, y, z, -np.inf
    bound, sure = cells.top[cell], cells.state[cell] == COMPLETE
    recall(walls, tree, cells, cell, bench)
    if not sure and looks > 0:
        bench.fresh[0] = -1.0
        away = nearest_listed(walls, tree, cells, cell, x, y, z, np.inf, bench.fresh)
        keep_in_mind(bench)
        found[3], bound = away, min(bound, away + ROOT3 * half)
    if bench.known[0] == 0:
        return float(bound)
    look(walls, bench, x, y, z, 1.0)
    least = narrow(bench, half)
    listed = bench.known[0]
    if listed <= LISTED:
        note(cells, cell, bench, cells.state[cell])
    if found[3] == -np.inf:
        found[3] = least
    cells.away[cell], cells.stale[cell] = least, False
    for k in range(looks + 1):
        bound = min(bound, highest_in_cell(walls, bench, x, y, z, half, least, enough))
        if bound <= enough or k == looks:
            break
        px, py, pz = x + bench.found[0], y + bench.found[1], z + bench.found[2]
        bench.fresh[0] = -1.0
        away = nearest_listed(walls, tree, cells, cell, px, py, pz, np.inf, bench.fresh)
        if away >= found[3]:
            found[0], found[1], found[2], found[3] = px, py, pz, away
        if not keep_in_mind(bench):
            break
        least = min(least, look(walls, bench, x, y, z, 1.0))
    if not sure:
        note_facets(cells, cell, bench, listed)
    cells.top[cell] = bound
    return float(bound)


@inner_loop
def open_bound(
    walls: Walls, tree: BallTree, bench: Bench, cells: Cells, found: NDArray[np.float64], cell: int,
    enough: float,
) -> float:  # fmt: skip
    """Return how large the spheres may be that have their centres in a cell without a complete list [m].

    By what is known to be near, and then by what is found to be nearer to the places that seem farthest from
    that; see `listed_bound`. Where all that may be nearest is little enough, it becomes the cell's list.
    """
    row = cells.cell[cell]
    x, y, z, half = row[0], row[1], row[2], row[3]
    bound = cells.top[cell]
    bench.fresh[0] = -1.0
    away = nearest_of_all(walls, tree, x, y, z, np.inf, bench.fresh)
    found[0], found[1], found[2], found[3] = x, y, z, away
    bound = min(bound, away + ROOT3 * half)
    cells.top[cell] = bound
    if bound <= 0.0 or bench.fresh[0] < 0.0:
        return float(bound)
    nearest = bench.fresh.copy()
    bench.known[0] = 0
    keep_in_mind(bench)
    least = look(walls, bench, x, y, z, 1.0)
    if cells.state[cell] == OPEN and ROOT3 * half <= GATHER * enough:
        if gather(walls, tree, x, y, z, half, least, bench):
            note(cells, cell, bench, LOOSE if len(walls.box) else COMPLETE)
            list_facets(walls, tree, bench, cells, cell)
            return listed_bound(walls, tree, bench, cells, found, cell, enough, LOOKS)
        cells.state[cell] = WIDE
    if bound <= enough:
        return float(bound)
    recall(walls, tree, cells, cell, bench)
    bench.fresh[:] = nearest
    keep_in_mind(bench)
    for _ in range(LOOKS):
        least = look(walls, bench, x, y, z, 1.0)
        bound = min(bound, highest_in_cell(walls, bench, x, y, z, half, least, enough))
        if bound <= enough:
            break
        px, py, pz = x + bench.found[0], y + bench.found[1], z + bench.found[2]
        within = look(walls, bench, px, py, pz, 1.0)
        bench.fresh[0] = -1.0
        reached = nearest_of_all(walls, tree, px, py, pz, within, bench.fresh)
        if reached > found[3]:
            found[0], found[1], found[2], found[3] = px, py, pz, reached
        if not keep_in_mind(bench):
            break
    state = cells.state[cell]
    look(walls, bench, x, y, z, 1.0)
    note(cells, cell, bench, state)
    cells.top[cell], cells.stale[cell] = bound, False
    return float(bound)


@inner_loop
def beyond(walls: Walls, tree: BallTree, bench: Bench, cells: Cells, cell: int) -> bool:
    """Tell whether a cell that no triangle enters is outside the meshes."""
    at = cells.cell[cell]
    bench.fresh[0] = -1.0
    return bool(nearest_listed(walls, tree, cells, cell, at[0], at[1], at[2], np.inf, bench.fresh) < 0.0)
