"""What the neighbours of a sphere leave of the places where another one touches it.

A sphere of radius R that touches one of radius s has its centre on a ball of radius s + R. Each neighbour
and each plane wall takes a cap of that ball: the unit vectors u with n . u > c. Places where the new sphere
touches three at once are the corners of what is left.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.advancing_front.cell_kernels import Cells, near_spheres
from packgen.arrange.advancing_front.surface_kernels import FEATURE, FLAT, HOLLOW, SPHERE, is_curved
from packgen.arrange.space.feature_kernels import (
    BALL,
    CENTER_PLANE,
    PLANE,
    Features,
    out_of_reach,
    wall_gap,
)
from packgen.arrange.space.map_kernels import FeatureMap, candidate, cell_of, count_boundless
from packgen.compiled import inlined, inner_loop

ROWS = 4096
"""Surfaces near one sphere at most."""

FLATS_MAX = 12
"""Plane walls that take caps; where more are near they are many facets, and are treated as curved walls."""

RAY_STEPS = 3

NEAR_WALL = 0.25
"""A ray ends so near to a wall, in radii of the new sphere."""


class Bench(NamedTuple):
    """Room for the surfaces near one sphere; all lengths from its centre.

    Attributes:
        apart: Spheres: centres and radii [m], shape (ROWS, 4).
        number: Their numbers, shape (ROWS,), int64.
        item: Wall features, shape (ROWS,), int64.
        cap: Caps: unit vector, and cosine, shape (ROWS, 4). Those that are certain come first, by rising
            cosine.
        kind: Kind of the surface of each cap, shape (ROWS,), int64; see ``surface_gap``.
        surface: The surface, shape (ROWS, 4).
        maker: Caps whose edges are not covered by one other cap, shape (ROWS,), int64.
        spare: Caps before they are sorted, shape (ROWS, 9).
        ray: Directions in which curved walls are looked for, shape (rays, 3).
    """

    apart: NDArray[np.float64]
    number: NDArray[np.int64]
    item: NDArray[np.int64]
    cap: NDArray[np.float64]
    kind: NDArray[np.int64]
    surface: NDArray[np.float64]
    maker: NDArray[np.int64]
    spare: NDArray[np.float64]
    ray: NDArray[np.float64]


def new_bench() -> Bench:
    """Return room for the surfaces near one sphere."""
    grid = np.stack(np.meshgrid(*[[-1.0, 0.0, 1.0]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    square = (grid * grid).sum(axis=1)
    ray = grid[(square == 1.0) | (square == 3.0)]
    ray /= np.sqrt((ray * ray).sum(axis=1))[:, None]
    return Bench(
        np.empty((ROWS, 4)), np.empty(ROWS, np.int64), np.empty(ROWS, np.int64), np.empty((ROWS, 4)),
        np.empty(ROWS, np.int64), np.empty((ROWS, 4)), np.empty(ROWS, np.int64), np.empty((ROWS, 9)), ray,
    )  # fmt: skip


@inlined
def _put(rows: NDArray[np.float64], at: int, x: float, y: float, z: float, cosine: float, kind: int) -> None:
    rows[at, 0], rows[at, 1], rows[at, 2], rows[at, 3], rows[at, 4] = x, y, z, cosine, kind


@inner_loop
def _caps_of_spheres(
    cells: Cells,
    ball: NDArray[np.float64],
    base: NDArray[np.float64],
    radius: float,
    radius_max: float,
    bench: Bench,
) -> int:
    """List the caps that spheres take; return how many, -1 where nothing is left."""
    far = base[3] + radius
    near = near_spheres(cells, ball, base, far + radius, radius_max, bench.apart, bench.number)
    if near < 0:
        return -1
    count, rows = 0, bench.spare
    for k in range(near):
        x, y, z = bench.apart[k, 0], bench.apart[k, 1], bench.apart[k, 2]
        square = x * x + y * y + z * z
        off = math.sqrt(square)
        least = bench.apart[k, 3] + radius
        cosine = (far * far + square - least * least) / (2.0 * far * off)
        if cosine >= 1.0:
            continue
        if cosine <= -1.0:
            return -1
        inverse = 1.0 / off
        _put(rows, count, x * inverse, y * inverse, z * inverse, cosine, SPHERE)
        rows[count, 5], rows[count, 6], rows[count, 7], rows[count, 8] = x, y, z, least
        count += 1
    return count


@inner_loop
def _near_features(  # type: ignore[no-untyped-def]
    base: NDArray[np.float64], reach: float, features: Features, near: FeatureMap, bench: Bench
):
    """List the features closer to a sphere's surface than a reach: how many, and whether any is curved."""
    kind, row = features
    x, y, z = base[0], base[1], base[2]
    cell = cell_of(x, y, z, near.grid)
    low, boundless = near.start[cell], count_boundless(x, y, z, near)
    count, flats, curved = 0, 0, False
    for k in range(low - boundless, near.start[cell + 1]):
        f = candidate(k, low, boundless, kind, near)
        if f < 0 or count == len(bench.item):
            continue
        if out_of_reach(kind[f], row[f], x, y, z, reach + base[3]):
            continue
        own = 0.0 if kind[f] == CENTER_PLANE else base[3]
        if wall_gap(kind[f], row[f], x, y, z, own)[0] >= reach + base[3] - own:
            continue
        bench.item[count] = f
        count += 1
        curved |= is_curved(kind[f])
        flats += kind[f] <= CENTER_PLANE
    return count, curved or flats > FLATS_MAX


@inner_loop
def _caps_of_walls(
    base: NDArray[np.float64], radius: float, walls: int, count: int, features: Features, bench: Bench,
    flat: bool,
) -> int:  # fmt: skip
    """List the caps that planes and spheres around take; return how many there are, -1: nothing is left."""
    far, rows = base[3] + radius, bench.spare
    for k in range(walls):
        f = bench.item[k]
        kind, row = features.kind[f], features.row[f]
        if kind <= CENTER_PLANE and flat:
            along = row[0] * base[0] + row[1] * base[1] + row[2] * base[2]
            offset = row[3] - along - (radius if kind == PLANE else 0.0)
            cosine = offset / far
            nx, ny, nz = row[0], row[1], row[2]
            rows[count, 5], rows[count, 6], rows[count, 7], rows[count, 8] = nx, ny, nz, offset
            shape = FLAT
        elif kind == BALL:
            cx, cy, cz = row[0] - base[0], row[1] - base[1], row[2] - base[2]
            off, most = math.sqrt(cx * cx + cy * cy + cz * cz), row[3] - radius
            if off + far <= most:
                continue
            if off == 0.0 or most <= 0.0:
                return -1
            cosine = (most * most - far * far - off * off) / (2.0 * far * off)
            nx, ny, nz = -cx / off, -cy / off, -cz / off
            rows[count, 5], rows[count, 6], rows[count, 7], rows[count, 8] = cx, cy, cz, most
            shape = HOLLOW
        else:
            continue
        if cosine >= 1.0:
            continue
        if cosine <= -1.0:
            return -1
        _put(rows, count, nx, ny, nz, cosine, shape)
        count += 1
    return count


@inner_loop
def _nearest(  # type: ignore[no-untyped-def]
    x: float, y: float, z: float, walls: int, features: Features, bench: Bench, flat: bool
):
    """Return a point's distance to the curved features listed [m], and which one is nearest; -1: none."""
    least, which = np.inf, -1
    for k in range(walls):
        f = bench.item[k]
        kind = features.kind[f]
        if kind == BALL or (kind <= CENTER_PLANE and flat):
            continue
        if out_of_reach(kind, features.row[f], x, y, z, least):
            continue
        gap = wall_gap(kind, features.row[f], x, y, z, 0.0)[0]
        if gap < least:
            least, which = gap, f
    return least, which


@inner_loop
def _caps_of_curved_walls(
    base: NDArray[np.float64], radius: float, walls: int, count: int, features: Features, bench: Bench,
    flat: bool,
) -> int:  # fmt: skip
    """Add the planes that touch curved walls where rays from the sphere come near them; return all caps.

    They are no caps that are certain, but starting points.
    """
    far, rows, first = base[3] + radius, bench.spare, count
    clear, _ = _nearest(base[0], base[1], base[2], walls, features, bench, flat)
    for r in range(len(bench.ray)):
        ex, ey, ez = bench.ray[r, 0], bench.ray[r, 1], bench.ray[r, 2]
        along = min(0.95 * clear, far)
        x = y = z = gap = 0.0
        f = -1
        for _ in range(RAY_STEPS):
            x, y, z = base[0] + along * ex, base[1] + along * ey, base[2] + along * ez
            gap, f = _nearest(x, y, z, walls, features, bench, flat)
            if gap < NEAR_WALL * radius or along >= far:
                break
            # What is not listed is at least so far.
            along = min(along + 0.95 * min(gap, max(far + radius - along, 0.1 * radius)), far)
        if f < 0:
            continue
        _, px, py, pz = wall_gap(features.kind[f], features.row[f], x, y, z, 0.0)
        wall_radius = 0.0 if features.kind[f] == CENTER_PLANE else radius
        ahead = along * (px * ex + py * ey + pz * ez)
        cosine = (gap - ahead - wall_radius) / far
        if not -1.0 < cosine < 1.0 or count == len(rows):
            continue
        known = False
        for k in range(first, count):
            alike = rows[k, 0] * px + rows[k, 1] * py + rows[k, 2] * pz
            known |= int(rows[k, 5]) == f and alike < -1.0 + 1e-9 and abs(rows[k, 3] - cosine) < 1e-6
        if not known:
            _put(rows, count, -px, -py, -pz, cosine, FEATURE)
            rows[count, 5] = f
            count += 1
    return count


@inner_loop
def _sorted_caps(bench: Bench, count: int, total: int) -> None:
    """Sort the first caps by rising cosine; the other ones keep their places."""
    rows, order = bench.spare, bench.maker
    for k in range(total):
        order[k] = k
    if count > 40:
        order[:count] = np.argsort(rows[:count, 3])
    else:
        for k in range(1, count):
            at = k
            while at > 0 and rows[order[at - 1], 3] > rows[k, 3]:
                order[at] = order[at - 1]
                at -= 1
            order[at] = k
    for k in range(total):
        row = rows[order[k]]
        for axis in range(4):
            bench.cap[k, axis], bench.surface[k, axis] = row[axis], row[5 + axis]
        bench.kind[k] = int(row[4])


@inner_loop
def _makers(bench: Bench, count: int, total: int) -> int:
    """List the caps whose edge no other cap covers; return how many, -1 where caps cover everything.

    Of two planes that touch curved walls it is not certain which one covers the other.
    """
    cap, makers = bench.cap, 0
    for j in range(count):
        cosine = cap[j, 3]
        sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
        covered = False
        for k in range(j):
            turn = cap[j, 0] * cap[k, 0] + cap[j, 1] * cap[k, 1] + cap[j, 2] * cap[k, 2]
            across = math.sqrt(max(1.0 - turn * turn, 0.0))
            if cosine * turn - sine * across > cap[k, 3] + 1e-12:
                if turn < cap[k, 3]:
                    return -1
                covered = True
                break
        if not covered:
            bench.maker[makers] = j
            makers += 1
    for j in range(count, total):
        bench.maker[makers] = j
        makers += 1
    return makers


@inner_loop
def caps_around(  # type: ignore[no-untyped-def]
    cells: Cells,
    ball: NDArray[np.float64],
    base: NDArray[np.float64],
    radius: float,
    radius_max: float,
    features: Features,
    near: FeatureMap,
    bench: Bench,
):
    """List the caps around a sphere that another one cannot touch.

    Args:
        cells: The cells of the spheres.
        ball: Centres and radii of all spheres [m], shape (N, 4).
        base: Those of the sphere to be touched, shape (4,).
        radius: Radius of the other one [m].
        radius_max: Largest radius of all [m].
        features: The features of the walls.
        near: Which of them are near.
        bench: Out: caps and makers.

    Returns:
        How many caps are certain, how many are makers (-1: nothing is left), whether curved walls are near,
        and how many features of walls are.
    """
    count = _caps_of_spheres(cells, ball, base, radius, radius_max, bench)
    if count < 0:
        return 0, -1, False, 0
    walls, curved = _near_features(base, 2.0 * radius, features, near, bench)
    flats = 0
    for k in range(walls):
        flats += features.kind[bench.item[k]] <= CENTER_PLANE
    flat = flats <= FLATS_MAX
    if walls > 0:
        count = _caps_of_walls(base, radius, walls, count, features, bench, flat)
        if count < 0:
            return 0, -1, False, 0
    total = count
    if curved:
        total = _caps_of_curved_walls(base, radius, walls, count, features, bench, flat)
    _sorted_caps(bench, count, total)
    return count, _makers(bench, count, total), curved, walls
