"""Start positions in a grid: which candidates a sphere covers, and which of them keep their distance."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.compiled import loop

POINTS_A_CELL = 4.0


class PointGrid(NamedTuple):
    """Points sorted into the cells of a grid, numbered with x slowest.

    Attributes:
        points: The points [m], shape (P, 3), float64.
        period: Length after which space repeats [m], 0 where it does not, shape (3,), float64.
        corner: Lower corner of the grid [m], shape (3,), float64.
        size: Cell size [m], shape (3,), float64.
        cells: Cells along each axis, shape (3,), int64.
        start: First slot of each of the C cells, shape (C + 1,), int64.
        order: Points by cell, shape (P,), int64.
    """

    points: NDArray[np.float64]
    period: NDArray[np.float64]
    corner: NDArray[np.float64]
    size: NDArray[np.float64]
    cells: NDArray[np.int64]
    start: NDArray[np.int64]
    order: NDArray[np.int64]


def point_grid(
    points: NDArray[np.float64], low: NDArray[np.float64], period: NDArray[np.float64]
) -> PointGrid:
    """Sort points into cells.

    Args:
        points: Points [m], shape (P, 3), inside the box along periodic axes.
        low: Lower corner of the box [m], shape (3,); where an axis is not periodic, the points' own counts.
        period: Length after which space repeats [m], 0 where it does not, shape (3,).

    Returns:
        The points in their cells.
    """
    return PointGrid(points, period, *sorted_points(points, low, period))


@loop
def sorted_points(  # type: ignore[no-untyped-def]
    points: NDArray[np.float64], low: NDArray[np.float64], period: NDArray[np.float64]
):
    """Return corner, cell size, cells, first slots and order of points in a grid; see ``PointGrid``."""
    count = len(points)
    corner, extent = np.empty(3), np.empty(3)
    for axis in range(3):
        least, most = points[:, axis].min(), points[:, axis].max()
        corner[axis] = low[axis] if period[axis] > 0.0 else least
        extent[axis] = period[axis] if period[axis] > 0.0 else most - least
    longest = max(extent[0], extent[1], extent[2], 1e-300)
    volume = 1.0
    for axis in range(3):
        volume *= max(extent[axis], 1e-3 * longest)
    width = longest
    while width * width * width * count > POINTS_A_CELL * volume:
        width *= 0.8
    cells, size = np.empty(3, np.int64), np.empty(3)
    for axis in range(3):
        cells[axis] = max(int(extent[axis] / width), 1)
        size[axis] = max(extent[axis], 1e-300) / cells[axis]
    key = np.empty(count, np.int64)
    start = np.zeros(cells[0] * cells[1] * cells[2] + 1, np.int64)
    for p in range(count):
        cell = 0
        for axis in range(3):
            place = int((points[p, axis] - corner[axis]) / size[axis])
            cell = cell * cells[axis] + min(max(place, 0), cells[axis] - 1)
        key[p] = cell
        start[cell + 1] += 1
    for cell in range(len(start) - 1):
        start[cell + 1] += start[cell]
    order, fill = np.empty(count, np.int64), start[:-1].copy()
    for p in range(count):
        order[fill[key[p]]] = p
        fill[key[p]] += 1
    return corner, size, cells, start, order


@loop
def mark_near(center: NDArray[np.float64], reach: float, grid: PointGrid, mark: NDArray[np.bool_]) -> None:
    """Mark the points of a grid, shape (P,), that are closer to a centre, shape (3,), than a reach [m]."""
    points, period, corner, size, cells, start, order = grid
    lowest, count = np.empty(3, np.int64), np.empty(3, np.int64)
    for axis in range(3):
        first = math.floor((center[axis] - reach - corner[axis]) / size[axis])
        last = math.floor((center[axis] + reach - corner[axis]) / size[axis])
        if period[axis] == 0.0:
            # Points on the upper side are in the last cell.
            first, last = min(max(first, 0), cells[axis] - 1), min(max(last, 0), cells[axis] - 1)
        lowest[axis], count[axis] = first, min(last - first + 1, cells[axis])
    for a in range(lowest[0], lowest[0] + count[0]):
        for b in range(lowest[1], lowest[1] + count[1]):
            row = ((a % cells[0]) * cells[1] + b % cells[1]) * cells[2]
            for c in range(lowest[2], lowest[2] + count[2]):
                cell = row + c % cells[2]
                for slot in range(start[cell], start[cell + 1]):
                    p = order[slot]
                    square = 0.0
                    for axis in range(3):
                        away = points[p, axis] - center[axis]
                        if period[axis] > 0.0:
                            away -= period[axis] * np.rint(away / period[axis])
                        square += away * away
                    if square < reach * reach:
                        mark[p] = True


@loop
def close_points(
    position: NDArray[np.float64],
    reach: NDArray[np.float64],
    grid: PointGrid,
    closed: NDArray[np.bool_],
) -> None:
    """Close the points (P,) of a grid within the reach (S,) [m] of any of some centres (S, 3)."""
    for i in range(len(position)):
        mark_near(position[i], reach[i], grid, closed)


@loop
def pick_apart(
    candidates: NDArray[np.int64], wanted: int, apart: float, grid: PointGrid
) -> NDArray[np.int64]:
    """Return the first candidates that are ``apart`` [m] from each other, by random sequential addition.

    Where there is room for fewer than are wanted, the first of the others follow them.

    Args:
        candidates: Points to choose from, in random order.
        wanted: How many.
        apart: Distance [m].
        grid: All points.

    Returns:
        Chosen points, at most ``wanted``.
    """
    blocked = np.zeros(len(grid.points), np.bool_)
    chosen = np.empty(min(wanted, len(candidates)), np.int64)
    rest = np.empty(len(candidates), np.int64)
    count, others = 0, 0
    for p in candidates:
        if count == wanted:
            break
        if blocked[p]:
            rest[others] = p
            others += 1
        else:
            chosen[count] = p
            count += 1
            mark_near(grid.points[p], apart, grid, blocked)
    for k in range(min(others, len(chosen) - count)):
        chosen[count + k] = rest[k]
    return chosen
