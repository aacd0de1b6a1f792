"""How far a sphere is inside one wall feature, and which way back: the closed forms behind every wall.

A feature is a row of twelve numbers and a kind. Gaps are positive inside; ``push`` is the unit vector along
which the gap grows fastest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.compiled import inlined, loop

PLANE, CENTER_PLANE, CONE, BALL, TRIANGLE = 0, 1, 2, 3, 4
FEATURE_WIDTH = 12

HALF_DIAGONAL = 0.5 * 3.0**0.5
"""Half the diagonal of a cube of side 1."""


class Features(NamedTuple):
    """Wall features as the loops take them.

    Attributes:
        kind: Kind of each feature, shape (F,), int8; see ``wall_gap``.
        row: Its numbers, shape (F, FEATURE_WIDTH), float64.
    """

    kind: NDArray[np.int8]
    row: NDArray[np.float64]


@inlined
def closest_on_triangle(  # type: ignore[no-untyped-def]
    px: float, py: float, pz: float, corner: NDArray[np.float64]
):
    """Return the point of a triangle closest to p.

    The seven Voronoi regions of a triangle (Ericson, Real-Time Collision Detection, 2005, section 5.1.5).

    Args:
        px: Point [m].
        py: Point [m].
        pz: Point [m].
        corner: The three corners one after the other [m], shape (9,) or longer.

    Returns:
        Coordinates of the closest point [m].
    """
    ax, ay, az = corner[0], corner[1], corner[2]
    abx, aby, abz = corner[3] - ax, corner[4] - ay, corner[5] - az
    acx, acy, acz = corner[6] - ax, corner[7] - ay, corner[8] - az
    apx, apy, apz = px - ax, py - ay, pz - az
    d1 = abx * apx + aby * apy + abz * apz
    d2 = acx * apx + acy * apy + acz * apz
    if d1 <= 0.0 and d2 <= 0.0:
        return ax, ay, az
    bpx, bpy, bpz = px - corner[3], py - corner[4], pz - corner[5]
    d3 = abx * bpx + aby * bpy + abz * bpz
    d4 = acx * bpx + acy * bpy + acz * bpz
    if d3 >= 0.0 and d4 <= d3:
        return corner[3], corner[4], corner[5]
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        t = d1 / (d1 - d3)
        return ax + t * abx, ay + t * aby, az + t * abz
    cpx, cpy, cpz = px - corner[6], py - corner[7], pz - corner[8]
    d5 = abx * cpx + aby * cpy + abz * cpz
    d6 = acx * cpx + acy * cpy + acz * cpz
    if d6 >= 0.0 and d5 <= d6:
        return corner[6], corner[7], corner[8]
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        t = d2 / (d2 - d6)
        return ax + t * acx, ay + t * acy, az + t * acz
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 - d3 >= 0.0 and d5 - d6 >= 0.0:
        t = (d4 - d3) / ((d4 - d3) + (d5 - d6))
        return (
            corner[3] + t * (corner[6] - corner[3]),
            corner[4] + t * (corner[7] - corner[4]),
            corner[5] + t * (corner[8] - corner[5]),
        )
    scale = 1.0 / (va + vb + vc)
    v, w = vb * scale, vc * scale
    return ax + v * abx + w * acx, ay + v * aby + w * acy, az + v * abz + w * acz


@inlined
def out_of_reach(kind: int, row: NDArray[np.float64], x: float, y: float, z: float, reach: float) -> bool:
    """Tell, for the price of a plane, that a point is ``reach`` or more from a triangle; False: maybe."""
    if kind != TRIANGLE:
        return False
    height = (x - row[0]) * row[9] + (y - row[1]) * row[10] + (z - row[2]) * row[11]
    return bool(abs(height) >= reach)


@loop
def wall_gap(  # type: ignore[no-untyped-def]
    kind: int, row: NDArray[np.float64], x: float, y: float, z: float, radius: float
):
    """Return how far a sphere is inside one feature, and the direction back inside.

    Args:
        kind: PLANE (outward normal, offset), CENTER_PLANE (the same, for the centre alone), CONE (base, axis,
            radius at the base, cosine and sine of the half opening angle), BALL (centre, radius),
            TRIANGLE (three corners).
        row: The feature, shape (FEATURE_WIDTH,).
        x: Sphere centre [m].
        y: Sphere centre [m].
        z: Sphere centre [m].
        radius: Sphere radius [m].

    Returns:
        (gap [m], push x, push y, push z): negative gap means the sphere sticks out by that much.
    """
    if kind <= CENTER_PLANE:
        gap = row[3] - (row[0] * x + row[1] * y + row[2] * z)
        if kind == PLANE:
            gap -= radius
        return gap, -row[0], -row[1], -row[2]
    dx, dy, dz = x - row[0], y - row[1], z - row[2]
    if kind == CONE:
        along = dx * row[3] + dy * row[4] + dz * row[5]
        ox, oy, oz = dx - along * row[3], dy - along * row[4], dz - along * row[5]
        off = math.sqrt(ox * ox + oy * oy + oz * oz)
        # The generator in the meridian plane of the centre is the nearest one.
        gap = (row[6] - off) * row[7] + along * row[8] - radius
        inverse = 1.0 / max(off, 1e-300)
        return (
            gap,
            -ox * inverse * row[7] + row[3] * row[8],
            -oy * inverse * row[7] + row[4] * row[8],
            -oz * inverse * row[7] + row[5] * row[8],
        )
    if kind == BALL:
        off = math.sqrt(dx * dx + dy * dy + dz * dz)
        inverse = 1.0 / max(off, 1e-300)
        return row[3] - off - radius, -dx * inverse, -dy * inverse, -dz * inverse
    cx, cy, cz = closest_on_triangle(x, y, z, row)
    dx, dy, dz = x - cx, y - cy, z - cz
    off = math.sqrt(dx * dx + dy * dy + dz * dz)
    if off > 1e-12 * radius:
        inverse = 1.0 / off
        return off - radius, dx * inverse, dy * inverse, dz * inverse
    # The centre lies on the triangle: only its stored inward normal says which side is home.
    return -radius, row[9], row[10], row[11]
