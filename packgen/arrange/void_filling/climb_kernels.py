"""The largest sphere in a void: up from a point in it to where nothing is farther from all that is near.

Where the distance from everything is largest, three, four or more walls and spheres are equally near, and the
way to them leads to all sides. Each round solves for the point that is equally far from all that is known to
be near, by their distances and directions, as Newton's method does, and adds what is nearer there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.space.feature_kernels import closest_on_triangle
from packgen.arrange.void_filling.linear_kernels import solve_small
from packgen.arrange.void_filling.wall_kernels import FACET, FLAT, Walls
from packgen.compiled import inner_loop

NEAR_MAX = 48
"""Walls and spheres that are kept in mind at most."""

EVEN = 1.0e-4
"""Part of its radius by which a sphere may be smaller than the largest one in a void where many are alike,
along the axis of a cylinder for example."""

ROOT3 = math.sqrt(3.0)

BOXED = 6
"""Rows of the programme that bound the step come first."""


class Bench(NamedTuple):
    """Room for climbing.

    Attributes:
        near: What is known to be near, as `nearest_of_all` notes it, shape (NEAR_MAX, 7).
        away: How far it is [m], shape (NEAR_MAX,).
        bend: Largest curvature of that distance [1/m], shape (NEAR_MAX,).
        row: Rows of the programme, shape (BOXED + 1 + NEAR_MAX, 4).
        bound: Their bounds, shape (BOXED + 1 + NEAR_MAX,).
        basis: Rows that hold, shape (4,).
        inverse: Their inverse and dual values, shape (5, 4).
        found: Solution, shape (4,).
        fresh: What is nearest, shape (7,).
        known: How many are known, shape (1,).
    """

    near: NDArray[np.float64]
    away: NDArray[np.float64]
    bend: NDArray[np.float64]
    row: NDArray[np.float64]
    bound: NDArray[np.float64]
    basis: NDArray[np.int64]
    inverse: NDArray[np.float64]
    found: NDArray[np.float64]
    fresh: NDArray[np.float64]
    known: NDArray[np.int64]


def new_bench() -> Bench:
    """Return room for climbing."""
    rows = BOXED + 1 + NEAR_MAX
    return Bench(
        np.zeros((NEAR_MAX, 7)), np.zeros(NEAR_MAX), np.zeros(NEAR_MAX), np.zeros((rows, 4)), np.zeros(rows),
        np.zeros(4, np.int64), np.zeros((5, 4)), np.zeros(4), np.zeros(7), np.zeros(1, np.int64),
    )  # fmt: skip


@inner_loop
def look(walls: Walls, bench: Bench, x: float, y: float, z: float, weight: float) -> float:
    """Write how far all that is known to be near is from a point, and the rows that follow; return the least.

    Args:
        walls: The walls.
        bench: What is near; its distances, bends and rows change.
        x: Point [m].
        y: Point [m].
        z: Point [m].
        weight: The rows' fourth number: 1 where the least distance is the fourth unknown, else 0.
    """
    least = np.inf
    for k in range(bench.known[0]):
        near = bench.near[k]
        if near[0] == FLAT:
            gx, gy, gz = -near[1], -near[2], -near[3]
            away, bend = near[4] + gx * x + gy * y + gz * z, 0.0
        else:
            px, py, pz, radius = near[1], near[2], near[3], near[4]
            if near[0] == FACET:
                px, py, pz = closest_on_triangle(x, y, z, walls.corner[int(near[5])])
                radius = 0.0
            gx, gy, gz = x - px, y - py, z - pz
            length = max(math.sqrt(gx * gx + gy * gy + gz * gz), 1e-300)
            gx, gy, gz = gx / length, gy / length, gz / length
            away, bend = length - radius, 1.0 / length
        bench.away[k], bench.bend[k] = away, bend
        row = bench.row[BOXED + 1 + k]
        row[0], row[1], row[2], row[3] = -gx, -gy, -gz, weight
        least = min(least, away)
    return least


@inner_loop
def keep_in_mind(bench: Bench) -> bool:
    """Add what is nearest to what is known, unless it is there; return whether it was new."""
    fresh = bench.fresh
    if fresh[0] < 0.0:
        return False
    count = bench.known[0]
    for k in range(count):
        near = bench.near[k]
        if near[6] != fresh[6]:
            continue
        if near[5] >= 0.0:
            return False
        apart = abs(near[1] - fresh[1]) + abs(near[2] - fresh[2]) + abs(near[3] - fresh[3])
        if apart + abs(near[4] - fresh[4]) == 0.0:
            return False
    place = count
    if count == NEAR_MAX:  # the farthest that does not hold now is forgotten
        place, farthest = 0, -np.inf
        for k in range(count):
            holds = False
            for i in range(4):
                holds = holds or bench.basis[i] == BOXED + 1 + k
            if not holds and bench.away[k] > farthest:
                place, farthest = k, bench.away[k]
    else:
        bench.known[0] += 1
    bench.near[place, :] = fresh
    bench.away[place] = 0.0  # until the next look: what is new is worth keeping
    return True


@inner_loop
def box_rows(bench: Bench, step: float) -> None:
    """Write the rows that bound a step [m] along each axis, and an idle one."""
    for k in range(3):
        for side in range(2):
            row = bench.row[2 * k + side]
            row[:] = 0.0
            row[k] = 1.0 if side == 0 else -1.0
            bench.bound[2 * k + side] = step
    bench.row[BOXED, :] = 0.0
    bench.row[BOXED, 3] = 1.0
    bench.bound[BOXED] = np.inf


@inner_loop
def highest(bench: Bench, step: float) -> bool:
    """Solve for the step that gets farthest from all that is near; see `solve_small`."""
    count = bench.known[0]
    nearest = 0
    for k in range(count):
        bench.bound[BOXED + 1 + k] = bench.away[k]
        nearest = k if bench.away[k] < bench.away[nearest] else nearest
    box_rows(bench, step)
    first = BOXED + 1 + nearest
    bench.basis[0] = first
    bench.inverse[:, :] = 0.0
    bench.inverse[3, 0] = bench.inverse[4, 0] = 1.0
    for k in range(3):
        up = -bench.row[first, k]
        sign = 1.0 if up >= 0.0 else -1.0
        bench.basis[1 + k] = 2 * k + (0 if up >= 0.0 else 1)
        bench.inverse[k, 1 + k] = sign
        bench.inverse[3, 1 + k] = bench.inverse[4, 1 + k] = abs(up)
    rows = BOXED + 1 + count
    return solve_small(
        bench.row, bench.bound, rows, bench.basis, bench.inverse, bench.found, 1e-16 * bench.away[nearest]
    )


@inner_loop
def distance_to(walls: Walls, near: NDArray[np.float64], x: float, y: float, z: float) -> float:
    """Return how far a point is from one thing that is near [m]; from a triangle on whichever side."""
    if near[0] == FLAT:
        return float(near[4] - near[1] * x - near[2] * y - near[3] * z)
    px, py, pz, radius = near[1], near[2], near[3], near[4]
    if near[0] == FACET:
        px, py, pz = closest_on_triangle(x, y, z, walls.corner[int(near[5])])
        radius = 0.0
    px, py, pz = x - px, y - py, z - pz
    return float(math.sqrt(px * px + py * py + pz * pz) - radius)


@inner_loop
def highest_in_cell(
    walls: Walls, bench: Bench, x: float, y: float, z: float, half: float, least: float, enough: float
) -> float:
    """Return what no point of a cubic cell is farther than from all that is known to be near [m].

    Any mean of these distances is a bound, and the programme's dual values make the mean that bounds best:
    how far the middle is, what the mean direction adds to that towards a corner, and what curvature adds.
    Where that is not low enough, the mean is taken at all corners: it is convex, so no place has more.
    The step to the point that is farthest, the curvature left out, is in ``bench.found``.

    Args:
        walls: The walls.
        bench: What is near, at least one thing, as `look` at the cell's middle has left it.
        x: Middle of the cell [m].
        y: Middle of the cell [m].
        z: Middle of the cell [m].
        half: Half the cell's width [m].
        least: Least of these distances [m].
        enough: What the bound need not be lowered below [m].
    """
    highest(bench, half)
    total, away, bend, gx, gy, gz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(4):
        k = bench.basis[i] - BOXED - 1
        share = bench.inverse[4, i]
        if k >= 0 and share > 0.0:
            row = bench.row[BOXED + 1 + k]
            total += share
            away += share * bench.away[k]
            bend += share * bench.bend[k]
            gx, gy, gz = gx + share * row[0], gy + share * row[1], gz + share * row[2]
    if total <= 0.0:
        return least + ROOT3 * half
    bound = (away + half * (abs(gx) + abs(gy) + abs(gz)) + 1.5 * half * half * bend) / total
    bound = min(bound, least + ROOT3 * half)
    if bound <= enough or bend == 0.0:
        return bound
    most = -np.inf
    for corner in range(8):
        px = x + (half if corner & 1 else -half)
        py = y + (half if corner & 2 else -half)
        pz = z + (half if corner & 4 else -half)
        mean = 0.0
        for i in range(4):
            k = bench.basis[i] - BOXED - 1
            if k >= 0 and bench.inverse[4, i] > 0.0:
                mean += bench.inverse[4, i] * distance_to(walls, bench.near[k], px, py, pz)
        most = max(most, mean)
    return min(bound, most / total * (1.0 + 1e-12))


@inner_loop
def sure_reach(bench: Bench, radius: float) -> float:
    """Return how far from a peak nothing is farther from all than it is, as the rows that hold tell [m].

    The largest of their distances falls by at least ``slope`` a metre to any side, less what their curvature
    adds; where they do not hold it from all sides, it rises by less than `EVEN` of the radius.
    """
    bend = 0.0
    held = True
    for i in range(4):
        k = bench.basis[i] - BOXED - 1
        held = held and k >= 0
        if k >= 0:
            bend = max(bend, bench.bend[k])
    even = math.sqrt(2.0 * EVEN * radius / max(bend, 1e-3 / radius))
    if not held:
        return even
    slope = np.inf
    for i in range(4):
        a = bench.row[bench.basis[(i + 1) % 4]]
        b = bench.row[bench.basis[(i + 2) % 4]]
        c = bench.row[bench.basis[(i + 3) % 4]]
        ux, uy, uz = b[0] - a[0], b[1] - a[1], b[2] - a[2]
        vx, vy, vz = c[0] - a[0], c[1] - a[1], c[2] - a[2]
        nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        if length < 1e-12:
            return even
        slope = min(slope, abs(nx * a[0] + ny * a[1] + nz * a[2]) / length)
    if bend == 0.0:
        return np.inf if slope > 1e-9 else even
    return max(even, 2.0 * slope / bend * (1.0 - 1e-9))
