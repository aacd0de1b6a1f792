"""Spheres that come one by one: the cells that they lie in, and which of them are near a point."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.compiled import inlined, inner_loop


class Cells(NamedTuple):
    """A grid whose cells have chains of spheres.

    Attributes:
        low: Lower corner [m], shape (3,).
        size: Size of a cell [m], shape (3,).
        cells: Cells along each axis, shape (3,), int64.
        period: Length after which space repeats [m], 0 where it does not, shape (3,).
        head: Last sphere of each cell, -1 where there is none, int32; x is slowest.
        following: The sphere before it in its cell, one for each sphere, -1: none, int32.
    """

    low: NDArray[np.float64]
    size: NDArray[np.float64]
    cells: NDArray[np.int64]
    period: NDArray[np.float64]
    head: NDArray[np.int32]
    following: NDArray[np.int32]


@inlined
def _span(along: float, reach: float, axis: int, cells: Cells):  # type: ignore[no-untyped-def]
    """Return the first and the last cell along an axis that are nearer to a coordinate than a reach."""
    first = math.floor((along - reach - cells.low[axis]) / cells.size[axis])
    last = math.floor((along + reach - cells.low[axis]) / cells.size[axis])
    if cells.period[axis] == 0.0:
        # What lies beyond the grid is in the outermost cells.
        most = cells.cells[axis] - 1
        first, last = max(min(first, most), 0), max(min(last, most), 0)
    return first, last


@inlined
def _turned(place: int, axis: int, cells: Cells):  # type: ignore[no-untyped-def]
    """Return the cell that stands for one beyond the box, and how far its spheres are moved for it [m]."""
    shift = 0.0
    while place < 0:
        place += cells.cells[axis]
        shift -= cells.period[axis]
    while place >= cells.cells[axis]:
        place -= cells.cells[axis]
        shift += cells.period[axis]
    return place, shift


@inner_loop
def cell_at(cells: Cells, center: NDArray[np.float64]) -> int:
    """Return the cell that a point, shape (3,) or longer, lies in."""
    cell = 0
    for axis in range(3):
        place, _ = _span(center[axis], 0.0, axis, cells)
        place, _ = _turned(place, axis, cells)
        cell = cell * cells.cells[axis] + place
    return int(cell)


@inner_loop
def enter(cells: Cells, ball: NDArray[np.float64], i: int) -> None:
    """Put sphere ``i`` of ``ball``, centres and radii (N, 4) [m], into its cell."""
    cell = cell_at(cells, ball[i])
    cells.following[i] = cells.head[cell]
    cells.head[cell] = i


@inner_loop
def leave(cells: Cells, ball: NDArray[np.float64], i: int) -> None:
    """Take sphere ``i`` out of its cell."""
    cell = cell_at(cells, ball[i])
    j = cells.head[cell]
    if j == i:
        cells.head[cell] = cells.following[i]
        return
    while j >= 0:
        if cells.following[j] == i:
            cells.following[j] = cells.following[i]
            return
        j = cells.following[j]


@inner_loop
def near_spheres(
    cells: Cells,
    ball: NDArray[np.float64],
    center: NDArray[np.float64],
    reach: float,
    radius_max: float,
    apart: NDArray[np.float64],
    number: NDArray[np.int64],
) -> int:
    """List the spheres whose surfaces are closer to a point than a reach, one at the point itself left out.

    Args:
        cells: The cells.
        ball: Centres and radii [m], shape (N, 4).
        center: The point [m], shape (3,) or longer.
        reach: The reach [m].
        radius_max: Largest radius [m].
        apart: Out: centres from the point, and radii [m], shape (M, 4).
        number: Out: their numbers, shape (M,).

    Returns:
        How many; -1: more than there is room for.
    """
    x, y, z = center[0], center[1], center[2]
    wide = reach + radius_max
    first_x, last_x = _span(x, wide, 0, cells)
    first_y, last_y = _span(y, wide, 1, cells)
    first_z, last_z = _span(z, wide, 2, cells)
    found = 0
    for a in range(first_x, last_x + 1):
        cell_x, shift_x = _turned(a, 0, cells)
        for b in range(first_y, last_y + 1):
            cell_y, shift_y = _turned(b, 1, cells)
            row = (cell_x * cells.cells[1] + cell_y) * cells.cells[2]
            for c in range(first_z, last_z + 1):
                cell_z, shift_z = _turned(c, 2, cells)
                j = cells.head[row + cell_z]
                while j >= 0:
                    dx, dy, dz = ball[j, 0] + shift_x - x, ball[j, 1] + shift_y - y, ball[j, 2] + shift_z - z
                    most = reach + ball[j, 3]
                    square = dx * dx + dy * dy + dz * dz
                    if 0.0 < square < most * most:
                        if found == len(number):
                            return -1
                        apart[found, 0], apart[found, 1], apart[found, 2] = dx, dy, dz
                        apart[found, 3] = ball[j, 3]
                        number[found] = j
                        found += 1
                    j = cells.following[j]
    return found


@inner_loop
def is_free(
    cells: Cells,
    ball: NDArray[np.float64],
    center: NDArray[np.float64],
    radius: float,
    radius_max: float,
    slack: float,
) -> bool:
    """Tell whether a sphere overlaps none by more than a slack [m]; see ``near_spheres``."""
    x, y, z = center[0], center[1], center[2]
    wide = radius + radius_max
    first_x, last_x = _span(x, wide, 0, cells)
    first_y, last_y = _span(y, wide, 1, cells)
    first_z, last_z = _span(z, wide, 2, cells)
    for a in range(first_x, last_x + 1):
        cell_x, shift_x = _turned(a, 0, cells)
        for b in range(first_y, last_y + 1):
            cell_y, shift_y = _turned(b, 1, cells)
            row = (cell_x * cells.cells[1] + cell_y) * cells.cells[2]
            for c in range(first_z, last_z + 1):
                cell_z, shift_z = _turned(c, 2, cells)
                j = cells.head[row + cell_z]
                while j >= 0:
                    dx, dy, dz = ball[j, 0] + shift_x - x, ball[j, 1] + shift_y - y, ball[j, 2] + shift_z - z
                    least = radius + ball[j, 3] - slack
                    if dx * dx + dy * dy + dz * dz < least * least:
                        return False
                    j = cells.following[j]
    return True
