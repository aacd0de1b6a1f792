"""How far a point is from everything, walls and spheres, and what is nearest."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.space.feature_kernels import closest_on_triangle
from packgen.arrange.space.side_kernels import CUT, INSIDE
from packgen.arrange.void_filling.ball_tree_kernels import BallTree, nearest_ball
from packgen.clumps.tree_kernels import LEAF, STACK, box_distance
from packgen.compiled import inlined, inner_loop, loop

FLAT, ROUND, FACET = 0.0, 1.0, 2.0
"""Kinds of what is near: a plane, the outside of a ball, a triangle."""

BALL_CODE, FACET_CODE, PLANE_CODE, CURVED_CODE = 0, 1, 2, 3
"""What a code is one of, in its last two bits: see `Walls` and `write_near`."""

IMAGES = 27
"""Copies of a sphere in a periodic box and around it."""

IMAGE_BITS = 5
"""Bits of a ball's code that tell the copy."""

TIE = 1.0e-12
"""Part of a squared distance by which two triangles are equally near."""


class Walls(NamedTuple):
    """What bounds the space.

    Attributes:
        plane: Outward unit normals and offsets [m], shape (P, 4).
        cone: Base, axis, radius at the base, cosine and sine of the half opening angle, shape (C, 9).
        hollow: Centres and radii of balls that everything is in [m], shape (B, 4).
        box: Boxes of the triangles' tree [m], shape (2 L - 1, 6); none: no triangles.
        corner: Its triangles [m], shape (T, 9).
        normal: Their outward unit normals, shape (T, 3).
        origin: Corner of the grid that tells sides, and size of its cells [m], shape (4,).
        cells: Its numbers of cells, shape (3,).
        label: OUTSIDE, INSIDE or CUT of each cell.
        low: Lower corner of a periodic box [m], shape (3,).
        period: Length after which it repeats [m], 0: not, shape (3,).
    """

    plane: NDArray[np.float64]
    cone: NDArray[np.float64]
    hollow: NDArray[np.float64]
    box: NDArray[np.float64]
    corner: NDArray[np.float64]
    normal: NDArray[np.float64]
    origin: NDArray[np.float64]
    cells: NDArray[np.int64]
    label: NDArray[np.int8]
    low: NDArray[np.float64]
    period: NDArray[np.float64]


@inner_loop
def _note_plane(near: NDArray[np.float64], x: float, y: float, z: float, gap: float, code: int) -> None:
    """Complete the plane whose inward normal is noted, and that is ``gap`` [m] from a point."""
    near[1], near[2], near[3] = -near[1], -near[2], -near[3]
    near[0], near[5], near[6] = FLAT, -1.0, code
    near[4] = gap + near[1] * x + near[2] * y + near[3] * z


@inner_loop
def curved_wall(
    walls: Walls, number: int, x: float, y: float, z: float, within: float, near: NDArray[np.float64]
) -> float:
    """Return how far a cone or a hollow ball is from a point [m], and note its tangent plane there.

    It bounds a convex space, which the tangent plane holds.

    Args:
        walls: The walls.
        number: Which cone, or of which ball, which come after the cones.
        x: Point [m].
        y: Point [m].
        z: Point [m].
        within: Only what is nearer is noted [m].
        near: Out: see `nearest_of_all`.
    """
    if number < len(walls.cone):
        row = walls.cone[number]
        dx, dy, dz = x - row[0], y - row[1], z - row[2]
        along = dx * row[3] + dy * row[4] + dz * row[5]
        ox, oy, oz = dx - along * row[3], dy - along * row[4], dz - along * row[5]
        off = math.sqrt(ox * ox + oy * oy + oz * oz)
        gap = (row[6] - off) * row[7] + along * row[8]
        if gap < within:
            if off <= 1e-12 * row[6]:  # on the axis any side is as near
                if abs(row[3]) < 0.9:
                    ox, oy, oz = 1.0 - row[3] * row[3], -row[3] * row[4], -row[3] * row[5]
                else:
                    ox, oy, oz = -row[4] * row[3], 1.0 - row[4] * row[4], -row[4] * row[5]
                off = math.sqrt(ox * ox + oy * oy + oz * oz)
            near[1] = row[3] * row[8] - ox / off * row[7]
            near[2] = row[4] * row[8] - oy / off * row[7]
            near[3] = row[5] * row[8] - oz / off * row[7]
            _note_plane(near, x, y, z, gap, 4 * number + CURVED_CODE)
        return float(gap)
    row = walls.hollow[number - len(walls.cone)]
    dx, dy, dz = x - row[0], y - row[1], z - row[2]
    off = math.sqrt(dx * dx + dy * dy + dz * dz)
    gap = row[3] - off
    if gap < within:
        near[1], near[2], near[3] = -1.0, 0.0, 0.0
        if off > 1e-300:
            near[1], near[2], near[3] = -dx / off, -dy / off, -dz / off
        _note_plane(near, x, y, z, gap, 4 * number + CURVED_CODE)
    return float(gap)


@inner_loop
def note_plane_wall(walls: Walls, number: int, near: NDArray[np.float64]) -> None:
    """Note one of the planes."""
    row = walls.plane[number]
    near[0], near[1], near[2], near[3], near[4], near[5] = FLAT, row[0], row[1], row[2], row[3], number
    near[6] = 4 * number + PLANE_CODE


@inner_loop
def smooth_walls(
    walls: Walls, x: float, y: float, z: float, within: float, near: NDArray[np.float64]
) -> float:
    """Find the nearest plane, cone or hollow ball; note it as `nearest_of_all` does.

    Returns:
        How far it is [m], negative beyond it; else ``within``.
    """
    best, number = within, -1
    for k in range(len(walls.plane)):
        row = walls.plane[k]
        gap = row[3] - (row[0] * x + row[1] * y + row[2] * z)
        if gap < best:
            best, number = gap, k
    if number >= 0:
        note_plane_wall(walls, number, near)
    for k in range(len(walls.cone) + len(walls.hollow)):
        best = min(best, curved_wall(walls, k, x, y, z, best, near))
    return best


@inner_loop
def nearest_triangle(  # type: ignore[no-untyped-def]
    walls: Walls, x: float, y: float, z: float, within: float
):
    """Return (the triangle nearest to a point, how far [m], on which side: 1 inside, -1 outside).

    Of equally near ones the triangle seen most squarely tells the side; where both faces of a sheet are,
    the point is inside. Triangle -1: none is nearer than ``within``, which is returned then.
    """
    box = walls.box
    inner = (len(box) - 1) // 2
    stack = np.empty(STACK, np.int64)
    bound = np.empty(STACK)
    best, number, square_on, side = within * within, -1, 0.0, 1.0
    depth = 1
    stack[0], bound[0] = 0, 0.0
    while depth > 0:
        depth -= 1
        node = stack[depth]
        if bound[depth] > best * (1.0 + TIE):
            continue
        if node < inner:
            left = 2 * node + 1
            to_left, to_right = box_distance(box, left, x, y, z), box_distance(box, left + 1, x, y, z)
            near, far = (left, left + 1) if to_left <= to_right else (left + 1, left)
            stack[depth], bound[depth] = far, max(to_left, to_right)
            stack[depth + 1], bound[depth + 1] = near, min(to_left, to_right)
            depth += 2
            continue
        first = (node - inner) * LEAF
        for t in range(first, first + LEAF):
            px, py, pz = closest_on_triangle(x, y, z, walls.corner[t])
            px, py, pz = x - px, y - py, z - pz
            square = px * px + py * py + pz * pz
            if square > best * (1.0 + TIE):
                continue
            across = px * walls.normal[t, 0] + py * walls.normal[t, 1] + pz * walls.normal[t, 2]
            new = square < best * (1.0 - TIE)
            if not new and number >= 0:
                new = squarer(across, square_on)
            if new or (number < 0 and square < best):
                number, square_on, side = t, abs(across), 1.0 if across <= 0.0 else -1.0
            best = min(best, square)
    return number, math.sqrt(best), side


@inner_loop
def is_inside(walls: Walls, x: float, y: float, z: float, side: float) -> bool:
    """Tell whether a point is inside the meshes: by its cell, or by the side of the nearest triangle."""
    size = walls.origin[3]
    cx = math.floor((x - walls.origin[0]) / size)
    cy = math.floor((y - walls.origin[1]) / size)
    cz = math.floor((z - walls.origin[2]) / size)
    if min(cx, cy, cz) < 0 or cx >= walls.cells[0] or cy >= walls.cells[1] or cz >= walls.cells[2]:
        return False
    label = walls.label[(cz * walls.cells[1] + cy) * walls.cells[0] + cx]
    return bool(side > 0.0 if label == CUT else label == INSIDE)


@inlined
def squarer(across: float, square_on: float) -> bool:
    """Tell whether a triangle faces a point more squarely than one as near, or alike and from inside."""
    return abs(across) > square_on * (1.0 + TIE) or (abs(across) >= square_on * (1.0 - TIE) and across < 0.0)


@inner_loop
def image_shift(walls: Walls, image: int, axis: int) -> float:
    """Return how far the copy of a sphere is from it along an axis [m]."""
    step = image // (9 if axis == 0 else (3 if axis == 1 else 1)) % 3
    return float((-1.0 if step == 1 else (1.0 if step == 2 else 0.0)) * walls.period[axis])


@inner_loop
def has_image(walls: Walls, image: int) -> bool:
    """Tell whether spheres have such a copy: only along axes that wrap around; 0 is themselves."""
    ix, iy, iz = image // 9, image // 3 % 3, image % 3
    return bool(
        (ix == 0 or walls.period[0] > 0.0)
        and (iy == 0 or walls.period[1] > 0.0)
        and (iz == 0 or walls.period[2] > 0.0)
    )


@inner_loop
def ball_code(number: int, image: int) -> int:
    """Return the code of a copy of a ball."""
    return int((((number << IMAGE_BITS) + image) << 2) + BALL_CODE)


@inner_loop
def write_near(
    walls: Walls, tree: BallTree, code: int, x: float, y: float, z: float, near: NDArray[np.float64]
) -> None:
    """Note what a code stands for; see `nearest_of_all`.

    Args:
        walls: The walls.
        tree: The spheres.
        code: Four times a number and its kind: a ball (see `ball_code`), a triangle, a plane, or a curved
            wall.
        x: Point, for the tangent plane of a curved wall [m].
        y: Point [m].
        z: Point [m].
        near: Out: the note, shape (7,).
    """
    kind, number = code & 3, code >> 2
    if kind == BALL_CODE:
        image, number = number & (1 << IMAGE_BITS) - 1, number >> IMAGE_BITS
        ball = tree.ball[number]
        near[0], near[4], near[5], near[6] = ROUND, ball[3], number, code
        near[1], near[2], near[3] = ball[0], ball[1], ball[2]
        if image:
            near[1] += image_shift(walls, image, 0)
            near[2] += image_shift(walls, image, 1)
            near[3] += image_shift(walls, image, 2)
    elif kind == FACET_CODE:
        near[0], near[5], near[6] = FACET, number, code
    elif kind == PLANE_CODE:
        note_plane_wall(walls, number, near)
    else:
        curved_wall(walls, number, x, y, z, np.inf, near)


@inner_loop
def nearest_of_all(
    walls: Walls, tree: BallTree, x: float, y: float, z: float, within: float, near: NDArray[np.float64]
) -> float:
    """Find what is nearest to a point, of walls and spheres.

    Args:
        walls: The walls.
        tree: The spheres.
        x: Point [m].
        y: Point [m].
        z: Point [m].
        within: Only what is nearer counts [m].
        near: Out: FLAT, outward normal, offset; ROUND, centre, radius, its number; or FACET, four numbers
            of no meaning, its number; then its code (see `write_near`); shape (7,). As it was where nothing
            is nearer.

    Returns:
        How far it is [m], negative beyond a wall or in a sphere; else ``within``.
    """
    best = smooth_walls(walls, x, y, z, within, near)
    for ix in range(3 if walls.period[0] > 0.0 else 1):
        sx = x + (ix if ix < 2 else -1) * walls.period[0]
        for iy in range(3 if walls.period[1] > 0.0 else 1):
            sy = y + (iy if iy < 2 else -1) * walls.period[1]
            for iz in range(3 if walls.period[2] > 0.0 else 1):
                sz = z + (iz if iz < 2 else -1) * walls.period[2]
                number, away = nearest_ball(tree, sx, sy, sz, best)
                if number >= 0:
                    best = away
                    code = ball_code(number, 9 * ix + 3 * iy + iz)
                    write_near(walls, tree, code, x, y, z, near)
    if len(walls.box) and best > 0.0:
        # A little farther, so that a triangle that is known to be the nearest still tells the side.
        number, away, side = nearest_triangle(walls, x, y, z, best * (1.0 + 1e-9))
        if number >= 0 and away < best:
            near[0], near[5], near[6] = FACET, number, 4 * number + FACET_CODE
            best = away
        if not is_inside(walls, x, y, z, side):
            best = -best
    return best


@loop
def distances_of_all(walls: Walls, tree: BallTree, point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how far points (N, 3) are from all walls and spheres [m], negative beyond or in one, (N,)."""
    near = np.empty(7)
    found = np.empty(len(point))
    for k in range(len(point)):
        found[k] = nearest_of_all(walls, tree, point[k, 0], point[k, 1], point[k, 2], np.inf, near)
    return found
