"""The volume of each ball in each cell of a mesh: one loop over balls, cells and faces.

By Gauss' theorem, three times the volume of the unit ball's part within a polyhedron is its area on the
sphere plus, for each face, the face's distance from the centre times the area of the face within the ball.
Cut up by pyramids on the faces and triangles between the foot of a face's perpendicular and its edges (all
signed), the integrals are elementary. With d the distance of a face, e that of an edge from the foot, and l a
place along the edge as seen from the foot of its own perpendicular, no farther than the ball's surface at
sqrt(1 - d^2 - e^2),

    3 V = solid angle of the cell around the centre
          + sum over cut faces of sign(d) { 2 pi (c - 1) [foot inside the face]
          + sum over cut edges of sign(e) { g(l at the end) - g(l at the start) } },

    c = d (3 - d^2) / 2,   g(l) = d e l / 2 - c atan(l / e) + atan(d l / (e sqrt(d^2 + e^2 + l^2))).

Faces and edges beyond the ball drop out: the angles that they span around the centre and around a foot add
up. Faces are plane and convex; the cell need not be convex, but of one that is the planes tell whether the
centre is inside. Where the centre is on an edge, or a foot on a corner, angles between vectors of no length
decide; there the volume, which is smooth, is interpolated from centres beside it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

BALL = 4.0 / 3.0 * math.pi
# In radii. Of two lengths as small as NEAR, rounding spoils the angle in its tenth digit. A smaller STEP
# between the centres of an interpolation would, too; a larger one would pass where the ball meets a face.
NEAR, STEP = 3e-6, 1e-5


class Polyhedra(NamedTuple):
    """Polyhedra with the same numbers of corners and faces, each as seen from its middle.

    Attributes:
        convex: Whether they are convex. Of others all faces are triangles, counter-clockwise from outside.
        middle: Middle of each [m], shape (C, 3), float64.
        corner: Corners of each from its middle [m], shape (C, K, 3), float64.
        face: Corners of each face in order around it, the last one of a triangle twice, shape (F, 4), int64.
        normal: Outward unit normals, shape (C, F, 3), float64.
        offset: Distance of each face's plane from the middle [m], shape (C, F), float64; infinite: no face.
    """

    convex: bool
    middle: NDArray[np.float64]
    corner: NDArray[np.float64]
    face: NDArray[np.int64]
    normal: NDArray[np.float64]
    offset: NDArray[np.float64]


class Boxes(NamedTuple):
    """A grid of boxes, numbered with x slowest, and the cells in each of them.

    Attributes:
        origin: Lower corner of the grid [m], shape (3,), float64.
        size: Size of the boxes [m].
        shape: Boxes along x, y, z, shape (3,), int64.
        first: Lowest box of each cell along x, y, z, shape (C, 3), int32.
        start: First entry of each of the B boxes, shape (B + 1,), int64; see ``listed_cells``.
        item: Cells in each box, int32.
    """

    origin: NDArray[np.float64]
    size: float
    shape: NDArray[np.int64]
    first: NDArray[np.int32]
    start: NDArray[np.int64]
    item: NDArray[np.int32]


Vector = tuple[float, float, float]


@njit(cache=True, error_model="numpy", inline="always")
def _along(d: float, e: float, c: float, low: float, high: float) -> float:
    """The integral g of the module's text from one place along an edge to a higher one; d, e not negative."""
    slant_low = math.sqrt(d * d + e * e + low * low)
    slant_high = math.sqrt(d * d + e * e + high * high)
    # Each angle is the difference of two below a right angle.
    around_foot = math.atan2(e * (high - low), e * e + low * high)
    around_center = math.atan2(
        d * e * (high * slant_low - low * slant_high), e * e * slant_low * slant_high + d * d * low * high
    )
    return 0.5 * d * e * (high - low) - c * around_foot + around_center


@njit(cache=True, error_model="numpy", inline="always")
def _edge(  # type: ignore[no-untyped-def]
    a: Vector, t: Vector, o: Vector, n: Vector, d: float, c: float
):
    """Return what an edge adds to a face's sum, whether the foot is on its inner side, whether that is sure.

    All in radii: a is the edge's start as seen from the centre, t leads from there to its end and o to the
    face's next corner; n is the face's normal, d its distance, and c is d (3 - d^2) / 2.
    """
    (ax, ay, az), (tx, ty, tz), (ox, oy, oz), (nx, ny, nz) = a, t, o, n
    length = math.sqrt(tx * tx + ty * ty + tz * tz)
    tx, ty, tz = tx / length, ty / length, tz / length
    mx, my, mz = ty * nz - tz * ny, tz * nx - tx * nz, tx * ny - ty * nx
    # m lies in the face across the edge, and away from the next corner. The face is on the edge's left.
    turn = -1.0 if mx * ox + my * oy + mz * oz > 0.0 else 1.0
    away = turn * (mx * ax + my * ay + mz * az)
    e = abs(away)
    half = 1.0 - d * d - e * e
    if half <= 0.0:
        return 0.0, away >= 0.0, True
    half = math.sqrt(half)
    low = turn * (tx * ax + ty * ay + tz * az)
    high = low + turn * length
    if turn < 0.0:
        low, high = high, low
    if low >= half or high <= -half:
        return 0.0, away >= 0.0, True
    sure = e * e + min(d * d, low * low, high * high) >= NEAR * NEAR
    part = _along(d, e, c, max(low, -half), min(high, half))
    return (part if away >= 0.0 else -part), away >= 0.0, sure


@njit(cache=True, error_model="numpy", inline="always")
def _solid_angle(  # type: ignore[no-untyped-def]
    x: float, y: float, z: float, cell: int, a: int, b: int, c: int, corner: NDArray[np.float64]
):
    """Return the solid angle of a triangle as seen from a point, 0 to 2 pi.

    Van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125.
    """
    ax, ay, az = corner[cell, a, 0] - x, corner[cell, a, 1] - y, corner[cell, a, 2] - z
    bx, by, bz = corner[cell, b, 0] - x, corner[cell, b, 1] - y, corner[cell, b, 2] - z
    cx, cy, cz = corner[cell, c, 0] - x, corner[cell, c, 1] - y, corner[cell, c, 2] - z
    length_a = math.sqrt(ax * ax + ay * ay + az * az)
    length_b = math.sqrt(bx * bx + by * by + bz * bz)
    length_c = math.sqrt(cx * cx + cy * cy + cz * cz)
    top = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)
    bottom = (
        length_a * length_b * length_c
        + (ax * bx + ay * by + az * bz) * length_c
        + (bx * cx + by * cy + bz * cz) * length_a
        + (cx * ax + cy * ay + cz * az) * length_b
    )
    return 2.0 * math.atan2(abs(top), bottom)


@njit(cache=True, error_model="numpy")
def _ball_in_cell(  # type: ignore[no-untyped-def]
    x: float, y: float, z: float, radius: float, cell: int, cells: Polyhedra
):
    """Return what `ball_in_cell` does, and whether rounding cannot have spoilt it."""
    convex, _, corner, face, normal, offset = cells
    inside, cut = True, False
    for f in range(len(face)):
        depth = offset[cell, f] - normal[cell, f, 0] * x - normal[cell, f, 1] * y - normal[cell, f, 2] * z
        if convex and depth <= -radius:
            return 0.0, True
        inside = inside and depth >= 0.0
        cut = cut or abs(depth) < radius
    total = 4.0 * math.pi * inside
    if not convex:
        total = 0.0
        for f in range(len(face)):
            height = (
                offset[cell, f] - normal[cell, f, 0] * x - normal[cell, f, 1] * y - normal[cell, f, 2] * z
            )
            if height < math.inf:
                angle = _solid_angle(x, y, z, cell, face[f, 0], face[f, 1], face[f, 2], corner)
                # Rounding tells the side of a point on a face, and tells the same one below.
                total += angle if height >= 0.0 else -angle
    if not cut:
        return total / 3.0, True
    scale, sure = 1.0 / radius, True
    for f in range(len(face)):
        nx, ny, nz = normal[cell, f, 0], normal[cell, f, 1], normal[cell, f, 2]
        height = scale * (offset[cell, f] - nx * x - ny * y - nz * z)
        d = abs(height)
        if d >= 1.0:
            continue
        c = 0.5 * d * (3.0 - d * d)
        foot_inside, around = True, 0.0
        for k in range(4):
            start, end, other = face[f, k], face[f, (k + 1) % 4], face[f, (k + 2) % 4]
            if start == end:
                continue
            if other == end:
                other = face[f, (k + 3) % 4]
            sx, sy, sz = corner[cell, start, 0], corner[cell, start, 1], corner[cell, start, 2]
            part, on_inner_side, edge_sure = _edge(
                (scale * (sx - x), scale * (sy - y), scale * (sz - z)),
                (
                    scale * (corner[cell, end, 0] - sx),
                    scale * (corner[cell, end, 1] - sy),
                    scale * (corner[cell, end, 2] - sz),
                ),
                (corner[cell, other, 0] - sx, corner[cell, other, 1] - sy, corner[cell, other, 2] - sz),
                (nx, ny, nz),
                d,
                c,
            )
            around += part
            foot_inside = foot_inside and on_inner_side
            sure = sure and edge_sure
        around += 2.0 * math.pi * (c - 1.0) * foot_inside
        total += around if height >= 0.0 else -around
    return total / 3.0, sure


@njit(cache=True, error_model="numpy")
def ball_in_cell(x: float, y: float, z: float, radius: float, cell: int, cells: Polyhedra) -> float:
    """Return the volume of a ball within a polyhedron, in units of the radius cubed.

    Args:
        x: Centre of the ball, from the polyhedron's middle [m].
        y: The same.
        z: The same.
        radius: Its radius [m].
        cell: Which of the polyhedra.
        cells: The polyhedra.

    Returns:
        Volume over ``radius**3``.
    """
    volume: float
    volume, sure = _ball_in_cell(x, y, z, radius, cell, cells)
    if sure:
        return volume
    # Towards the cell's middle and away from it: off every edge and corner.
    step, volume = STEP * radius / max(math.sqrt(x * x + y * y + z * z), 1e-300), 0.0
    for share, weight in ((-2.0, -1.0), (-1.0, 4.0), (1.0, 4.0), (2.0, -1.0)):
        to = 1.0 + share * step
        part = _ball_in_cell(to * x, to * y, to * z, radius, cell, cells)[0]
        volume += weight * part / 6.0
    return volume


@njit(cache=True, error_model="numpy")
def listed_cells(  # type: ignore[no-untyped-def]
    first: NDArray[np.int32], last: NDArray[np.int32], count: NDArray[np.int64]
):
    """List for each box of a grid the cells that reach into it.

    Args:
        first: Lowest box of each cell along x, y, z, shape (C, 3).
        last: Highest box of each, shape (C, 3).
        count: Boxes along x, y, z, shape (3,).

    Returns:
        (first entry of each box, int64, shape (boxes + 1,); cells, int32).
    """
    start = np.zeros(count[0] * count[1] * count[2] + 1, np.int64)
    item = np.empty(0, np.int32)
    fill = start
    for counting in (True, False):
        if not counting:
            for box in range(len(start) - 1):
                start[box + 1] += start[box]
            item = np.empty(start[-1], np.int32)
            fill = start[:-1].copy()
        for cell in range(len(first)):
            for bx in range(first[cell, 0], last[cell, 0] + 1):
                for by in range(first[cell, 1], last[cell, 1] + 1):
                    row = (bx * count[1] + by) * count[2]
                    for box in range(row + first[cell, 2], row + last[cell, 2] + 1):
                        if counting:
                            start[box + 1] += 1
                        else:
                            item[fill[box]] = cell
                            fill[box] += 1
    return start, item


@njit(cache=True, error_model="numpy")
def add_balls(
    position: NDArray[np.float64],
    radius: NDArray[np.float64],
    cells: Polyhedra,
    boxes: Boxes,
    volume: NDArray[np.float64],
) -> None:
    """Add to each cell what lies in it of each ball.

    Args:
        position: Centres of the balls [m], shape (N, 3).
        radius: Their radii [m], shape (N,).
        cells: The cells.
        boxes: Which of them are near.
        volume: Volume in each cell [m3], shape (C,); changes.
    """
    middle, corner = cells.middle, cells.corner
    origin, size, count, first, start, item = boxes
    half = np.zeros(middle.shape)  # largest distance of a cell's corners from its middle along x, y, z
    for cell in range(len(corner)):
        for k in range(corner.shape[1]):
            for axis in range(3):
                half[cell, axis] = max(half[cell, axis], abs(corner[cell, k, axis]))
    low, high = np.empty(3, np.int64), np.empty(3, np.int64)
    for i in range(len(radius)):
        for axis in range(3):
            low[axis] = max(math.floor((position[i, axis] - radius[i] - origin[axis]) / size), 0)
            high[axis] = min(
                math.floor((position[i, axis] + radius[i] - origin[axis]) / size), count[axis] - 1
            )
        for bx in range(low[0], high[0] + 1):
            for by in range(low[1], high[1] + 1):
                for bz in range(low[2], high[2] + 1):
                    box = (bx * count[1] + by) * count[2] + bz
                    for k in range(start[box], start[box + 1]):
                        cell = item[k]
                        # They meet in the first of the boxes that both reach into.
                        if (
                            bx != max(low[0], first[cell, 0])
                            or by != max(low[1], first[cell, 1])
                            or bz != max(low[2], first[cell, 2])
                        ):
                            continue
                        x = position[i, 0] - middle[cell, 0]
                        y = position[i, 1] - middle[cell, 1]
                        z = position[i, 2] - middle[cell, 2]
                        beyond_x = max(abs(x) - half[cell, 0], 0.0)
                        beyond_y = max(abs(y) - half[cell, 1], 0.0)
                        beyond_z = max(abs(z) - half[cell, 2], 0.0)
                        if beyond_x**2 + beyond_y**2 + beyond_z**2 >= radius[i] ** 2:
                            continue
                        share = ball_in_cell(x, y, z, radius[i], cell, cells)
                        volume[cell] += share * radius[i] ** 3
