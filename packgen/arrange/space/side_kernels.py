"""Loops over triangles and cells: which cells a wall enters, winding numbers, segments that cross a wall."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.space.feature_kernels import HALF_DIAGONAL, TRIANGLE, Features, closest_on_triangle
from packgen.arrange.space.map_kernels import STACK, FeatureMap, Grid, cell_of, next_piece
from packgen.compiled import inlined, loop

OUTSIDE, INSIDE, CUT = 0, 1, 2


@loop
def mark_cut(
    corner: NDArray[np.float64],
    grid: Grid,
    label: NDArray[np.int8],
) -> None:
    """Mark the cells whose middle is closer to a triangle than half a cell's diagonal.

    Args:
        corner: Triangles [m], shape (F, 9).
        grid: The grid.
        label: Out: CUT where a triangle is near, shape (cells x * cells y * cells z,).
    """
    origin, size, cells = grid
    reach = HALF_DIAGONAL * size * (1.0 + 1e-9)
    stack = np.empty((STACK, 9))
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for f in range(len(corner)):
        stack[0] = corner[f, :9]
        depth = next_piece(stack, 1, grid, reach, low, high)
        while depth >= 0:
            piece = stack[depth]
            for cz in range(low[2], high[2] + 1):
                z = origin[2] + (cz + 0.5) * size
                for cy in range(low[1], high[1] + 1):
                    y = origin[1] + (cy + 0.5) * size
                    first = (cz * cells[1] + cy) * cells[0]
                    for cx in range(low[0], high[0] + 1):
                        if label[first + cx] == CUT:
                            continue
                        x = origin[0] + (cx + 0.5) * size
                        px, py, pz = closest_on_triangle(x, y, z, piece)
                        px, py, pz = px - x, py - y, pz - z
                        if px * px + py * py + pz * pz < reach * reach:
                            label[first + cx] = CUT
            depth = next_piece(stack, depth, grid, reach, low, high)


@loop
def first_members(  # type: ignore[no-untyped-def]
    region: NDArray[np.int32], count: int
):
    """Return (first cell of each region, shape (count + 1,); number of its cells, shape (count + 1,))."""
    first = np.full(count + 1, -1, np.int64)
    members = np.zeros(count + 1, np.int64)
    for cell in range(len(region)):
        if first[region[cell]] < 0:
            first[region[cell]] = cell
        members[region[cell]] += 1
    return first, members


@inlined
def _volume(  # type: ignore[no-untyped-def]
    ax: float, ay: float, az: float, bx: float, by: float, bz: float, cx: float, cy: float, cz: float
):
    return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)


@loop
def crosses(
    px: float, py: float, pz: float, qx: float, qy: float, qz: float, row: NDArray[np.float64]
) -> bool:
    """Tell whether the segment from p to q meets a triangle; where rounding leaves a doubt, it does.

    By the signs of the tetrahedra of its ends and the triangle's edges; ``row`` has shape (9,) or longer.
    """
    ax, ay, az = row[0] - px, row[1] - py, row[2] - pz
    bx, by, bz = row[3] - px, row[4] - py, row[5] - pz
    cx, cy, cz = row[6] - px, row[7] - py, row[8] - pz
    dx, dy, dz = qx - px, qy - py, qz - pz
    scale = max(abs(ax), abs(ay), abs(az), abs(bx), abs(by), abs(bz), abs(cx), abs(cy), abs(cz))
    length = max(abs(dx), abs(dy), abs(dz))
    doubt = 1e-13 * scale * scale * max(scale, length)
    # The triangle against the segment's ends: p is the origin, q is d.
    at_p = _volume(ax, ay, az, bx, by, bz, cx, cy, cz)
    at_q = _volume(ax - dx, ay - dy, az - dz, bx - dx, by - dy, bz - dz, cx - dx, cy - dy, cz - dz)
    if (at_p > doubt and at_q > doubt) or (at_p < -doubt and at_q < -doubt):
        return False
    doubt = 1e-13 * scale * scale * length
    u = _volume(dx, dy, dz, ax, ay, az, bx, by, bz)
    v = _volume(dx, dy, dz, bx, by, bz, cx, cy, cz)
    w = _volume(dx, dy, dz, cx, cy, cz, ax, ay, az)
    outward = u >= -doubt and v >= -doubt and w >= -doubt
    inward = u <= doubt and v <= doubt and w <= doubt
    return bool(outward or inward)


@loop
def points_inside(
    position: NDArray[np.float64],
    grid: Grid,
    label: NDArray[np.int8],
    reach: float,
    features: Features,
    near: FeatureMap,
) -> NDArray[np.bool_]:
    """Tell which points are inside.

    By the label of the cell where no wall enters it; in the others by sight: a point is inside when the
    middle of an inside cell nearby is seen from it, that is, no triangle lies between.

    Args:
        position: Points [m], shape (N, 3).
        grid: The labelled grid.
        label: OUTSIDE, INSIDE or CUT, of each cell.
        reach: How far the map of features reaches from any point [m].
        features: The wall features.
        near: Which of them are near.

    Returns:
        Which points are inside, shape (N,).
    """
    origin, size, cells = grid
    kind, row = features
    inside = np.zeros(len(position), np.bool_)
    for i in range(len(position)):
        x, y, z = position[i, 0], position[i, 1], position[i, 2]
        cx = math.floor((x - origin[0]) / size)
        cy = math.floor((y - origin[1]) / size)
        cz = math.floor((z - origin[2]) / size)
        if min(cx, cy, cz) < 0 or cx >= cells[0] or cy >= cells[1] or cz >= cells[2]:
            continue
        own = label[(cz * cells[1] + cy) * cells[0] + cx]
        if own != CUT:
            inside[i] = own == INSIDE
            continue
        cell = cell_of(x, y, z, near.grid)
        for ring in range(1, 3):
            for ez in range(max(cz - ring, 0), min(cz + ring, cells[2] - 1) + 1):
                for ey in range(max(cy - ring, 0), min(cy + ring, cells[1] - 1) + 1):
                    for ex in range(max(cx - ring, 0), min(cx + ring, cells[0] - 1) + 1):
                        if inside[i] or label[(ez * cells[1] + ey) * cells[0] + ex] != INSIDE:
                            continue
                        if max(abs(ex - cx), abs(ey - cy), abs(ez - cz)) < ring:
                            continue
                        qx = origin[0] + (ex + 0.5) * size
                        qy = origin[1] + (ey + 0.5) * size
                        qz = origin[2] + (ez + 0.5) * size
                        far = (qx - x) ** 2 + (qy - y) ** 2 + (qz - z) ** 2
                        if far > reach * reach:
                            continue
                        seen = True
                        for k in range(near.start[cell], near.start[cell + 1]):
                            feature = near.item[k]
                            if kind[feature] == TRIANGLE and crosses(x, y, z, qx, qy, qz, row[feature]):
                                seen = False
                                break
                        inside[i] = seen
            if inside[i]:
                break
    return inside
