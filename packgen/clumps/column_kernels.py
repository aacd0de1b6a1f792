"""Where upright lines cross a triangulated surface."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.compiled import inner_loop, loop


@inner_loop
def side_of(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> float:
    """Return twice the area of a triangle in the plane; above 0: counter-clockwise."""
    return (bx - ax) * (y - ay) - (by - ay) * (x - ax)


@inner_loop
def look_at_triangle(
    corner: NDArray[np.float64],
    column: NDArray[np.float64],
    low: NDArray[np.float64],
    size: float,
    cells: NDArray[np.int64],
    fill: NDArray[np.int64],
    height: NDArray[np.float64],
    turn: NDArray[np.int64],
) -> None:
    """Count the columns that a triangle crosses, or note where; see `column_crossings`.

    Args:
        corner: Corners of the triangle [m], shape (9,).
        column: As in `column_crossings`.
        low: As in `column_crossings`.
        size: As in `column_crossings`.
        cells: As in `column_crossings`.
        fill: For each column the place of its next crossing; raised by one for each.
        height: Out: heights of crossings [m]; empty: they are counted only.
        turn: Out: 1 where a line enters the body, -1 where it leaves.
    """
    ax, ay, bx, by, cx, cy = corner[0], corner[1], corner[3], corner[4], corner[6], corner[7]
    area = side_of(ax, ay, bx, by, cx, cy)
    if area == 0.0:
        return
    first_x = max(int((min(ax, bx, cx) - low[0]) / size) - 1, 0)
    last_x = min(int((max(ax, bx, cx) - low[0]) / size) + 1, cells[0] - 1)
    first_y = max(int((min(ay, by, cy) - low[1]) / size) - 1, 0)
    last_y = min(int((max(ay, by, cy) - low[1]) / size) + 1, cells[1] - 1)
    for i in range(first_x, last_x + 1):
        for j in range(first_y, last_y + 1):
            k = i * cells[1] + j
            x, y = column[k, 0], column[k, 1]
            u = side_of(bx, by, cx, cy, x, y) / area
            v = side_of(cx, cy, ax, ay, x, y) / area
            if u < 0.0 or v < 0.0 or u + v > 1.0:
                continue
            if len(height):
                height[fill[k]] = u * corner[2] + v * corner[5] + (1.0 - u - v) * corner[8]
                turn[fill[k]] = 1 if area < 0.0 else -1
            fill[k] += 1


@loop
def column_crossings(  # type: ignore[no-untyped-def]
    corner: NDArray[np.float64],
    column: NDArray[np.float64],
    low: NDArray[np.float64],
    size: float,
    cells: NDArray[np.int64],
):
    """Return where lines along z cross triangles.

    Args:
        corner: Corners of the triangles, counter-clockwise from outside [m], shape (F, 9).
        column: Where each line is [m], one in each cell of a grid, y fastest, shape (C, 2).
        low: Lower corner of the grid [m], shape (2,).
        size: Side of its cells [m].
        cells: Cells along x and y, shape (2,).

    Returns:
        (first crossing of each line, shape (C + 1,), int64; heights [m], line by line, float64; 1 where the
        line enters the body, -1 where it leaves it, int64).
    """
    none, no_turn = np.empty(0), np.empty(0, np.int64)
    count = np.zeros(len(column), np.int64)
    for triangle in range(len(corner)):
        look_at_triangle(corner[triangle], column, low, size, cells, count, none, no_turn)
    start = np.zeros(len(column) + 1, np.int64)
    start[1:] = np.cumsum(count)
    fill = start[:-1].copy()
    height, turn = np.empty(start[-1]), np.empty(start[-1], np.int64)
    for triangle in range(len(corner)):
        look_at_triangle(corner[triangle], column, low, size, cells, fill, height, turn)
    return start, height, turn
