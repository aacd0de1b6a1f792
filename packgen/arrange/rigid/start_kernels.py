"""Places where bodies overlap nothing: tried one after the other, and taken where there is room."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.space.seams import Seams, wrapped_coordinate
from packgen.compiled import inlined, inner_loop, loop

CELLS_MAX = 4_000_000


@inlined
def cell_along(along: float, low: float, size: float, cells: int) -> int:
    """Return the cell of a coordinate along an axis; the nearest one beyond the ends."""
    return min(max(int((along - low) / size), 0), cells - 1)


@inner_loop
def has_room(
    ball: NDArray[np.float64],
    placed: NDArray[np.float64],
    head: NDArray[np.int32],
    after: NDArray[np.int32],
    low: NDArray[np.float64],
    size: NDArray[np.float64],
    cells: NDArray[np.int64],
    seams: Seams,
) -> bool:
    """Tell whether spheres (n, 4) overlap none of those placed; see ``start_places``."""
    for i in range(len(ball)):
        cx = cell_along(ball[i, 0], low[0], size[0], cells[0])
        cy = cell_along(ball[i, 1], low[1], size[1], cells[1])
        cz = cell_along(ball[i, 2], low[2], size[2], cells[2])
        for step in range(27):
            x, y, z = cx + step % 3 - 1, cy + step // 3 % 3 - 1, cz + step // 9 - 1
            x = x % cells[0] if seams.period[0] > 0.0 else x
            y = y % cells[1] if seams.period[1] > 0.0 else y
            z = z % cells[2] if seams.period[2] > 0.0 else z
            if min(x, y, z) < 0 or x >= cells[0] or y >= cells[1] or z >= cells[2]:
                continue
            other = head[(z * cells[1] + y) * cells[0] + x]
            while other >= 0:
                square = 0.0
                for axis in range(3):
                    apart = ball[i, axis] - placed[other, axis]
                    period = seams.period[axis]
                    if period > 0.0:
                        apart -= period * np.rint(apart / period)
                    square += apart * apart
                reach = ball[i, 3] + placed[other, 3]
                if square < reach * reach:
                    return False
                other = after[other]
    return True


@loop
def start_places(
    ball: NDArray[np.float64],
    first: NDArray[np.int64],
    tries: int,
    allowed: NDArray[np.bool_],
    there: NDArray[np.float64],
    box: NDArray[np.float64],
    seams: Seams,
) -> NDArray[np.int64]:
    """Choose for each body the first of its places at which it overlaps nothing that is there before.

    Args:
        ball: Centres, in the box where it wraps around, and radii of the spheres of each body at each of its
            places [m], body by body and place by place, shape (N, 4).
        first: First sphere of each place, and the end of all, shape (bodies * tries + 1,).
        tries: Places of each body.
        allowed: Which places are inside the walls, shape (bodies * tries,).
        there: Centres and radii of spheres that are there before [m], shape (F, 4).
        box: Lowest and highest coordinates of any centre [m], shape (2, 3).
        seams: Where space wraps around.

    Returns:
        Place of each body among its own, or -1, shape (bodies,).
    """
    largest, total = 0.0, len(there)
    for i in range(len(ball)):
        largest = max(largest, ball[i, 3])
    for i in range(len(there)):
        largest = max(largest, there[i, 3])
    low, size, cells = box[0], np.empty(3), np.empty(3, np.int64)
    width = 2.0 * largest
    while True:
        for axis in range(3):
            length = box[1, axis] - low[axis]
            cells[axis] = max(int(length / width), 1)
            size[axis] = max(length / cells[axis], width)
        if cells[0] * cells[1] * cells[2] <= CELLS_MAX:
            break
        width *= 1.26
    head = np.full(cells[0] * cells[1] * cells[2], -1, np.int32)
    placed, after = np.empty((len(there) + len(ball), 4)), np.empty(len(there) + len(ball), np.int32)
    placed[:total] = there
    for i in range(total):
        for axis in range(3):
            placed[i, axis] = wrapped_coordinate(placed[i, axis], seams.low[axis], seams.period[axis])
        enter(placed, i, head, after, low, size, cells)
    chosen = np.full(len(allowed) // tries, -1, np.int64)
    for b in range(len(chosen)):
        for k in range(b * tries, (b + 1) * tries):
            own = ball[first[k] : first[k + 1]]
            if allowed[k] and has_room(own, placed, head, after, low, size, cells, seams):
                chosen[b] = k - b * tries
                for i in range(len(own)):
                    placed[total] = own[i]
                    enter(placed, total, head, after, low, size, cells)
                    total += 1
                break
    return chosen


@inlined
def enter(
    placed: NDArray[np.float64],
    i: int,
    head: NDArray[np.int32],
    after: NDArray[np.int32],
    low: NDArray[np.float64],
    size: NDArray[np.float64],
    cells: NDArray[np.int64],
) -> None:
    """Put a sphere into the list of its cell."""
    cx = cell_along(placed[i, 0], low[0], size[0], cells[0])
    cy = cell_along(placed[i, 1], low[1], size[1], cells[1])
    cz = cell_along(placed[i, 2], low[2], size[2], cells[2])
    cell = (cz * cells[1] + cy) * cells[0] + cx
    after[i], head[cell] = head[cell], i
