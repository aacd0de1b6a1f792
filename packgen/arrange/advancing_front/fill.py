"""Spheres in the voids that a front leaves: each touches four others or walls, the largest void first.

Four neighbours around a void are the corners of a tetrahedron of the radical Delaunay triangulation, which is
the lower side of a convex hull in four dimensions. Walls take part as mirror images of the spheres near them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial import ConvexHull

from packgen.arrange.advancing_front.fill_kernels import nearest_walls, take_places
from packgen.arrange.advancing_front.front_kernels import enter_all
from packgen.arrange.advancing_front.growth import new_cells, slack_of
from packgen.arrange.advancing_front.place_kernels import Bed
from packgen.arrange.space.region import Region
from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube

ROUNDS_MAX = 12
"""Triangulations, each with the spheres of those before."""

GAIN_LEAST = 0.004
"""Share of the spheres that a round has to add for another one to follow."""

STEPS = 6
"""Steps of Newton's method for a sphere that touches four surfaces."""

SINGULAR = 1.0e-10

GUARD = 3.0
"""Distance along the axes of the points around all spheres, in that of the farthest one."""


@dataclass(frozen=True, eq=False, slots=True)
class _Corners:
    """Corners of a triangulation: spheres, their images across seams, and their mirror images.

    Attributes:
        ball: Centres and radii [m], shape (C, 4).
        mirrored: Which are behind walls, shape (C,).
        wall: Of these: unit vector into the wall, and its offset along that [m], shape (C, 4).
        own: Which are neither images nor mirrored, shape (C,).
    """

    ball: Float64Array
    mirrored: BoolArray
    wall: Float64Array
    own: BoolArray


def fill_voids(
    region: Region,
    ball: Float64Array,
    bounds: tuple[float, float],
    volume: float,
    tell: Callable[[int], None],
) -> Float64Array:
    """Return spheres for the voids between others.

    Args:
        region: The space.
        ball: Centres and radii of the spheres that are there [m], shape (N, 4).
        bounds: Least and largest radius [m].
        volume: Solid volume at which no more are placed [m3].
        tell: Called with the number of new spheres after each round.

    Returns:
        Centres and radii [m], shape (K, 4).
    """
    first, slack = len(ball), slack_of(region, bounds[0])
    for _ in range(ROUNDS_MAX):
        found = _places(region, ball, bounds, slack)
        solid = float((UNIT_VOLUME * cube(ball[first:, 3])).sum())
        before = len(ball)
        ball = _taken(region, ball, found, (volume - solid) / UNIT_VOLUME, slack)
        tell(len(ball) - first)
        if len(ball) - before <= GAIN_LEAST * before:
            break
    return ball[first:]


def _taken(
    region: Region, ball: Float64Array, found: Float64Array, volume: float, slack: float
) -> Float64Array:
    """Return spheres, (N, 4), and those of the found ones that have room, up to a sum of cubes of radii."""
    if len(found) == 0 or volume <= 0.0:
        return ball
    every = np.concatenate([ball, np.zeros_like(found)])
    cells = new_cells(region, float(ball[:, 3].mean()), len(every))
    walls = region.walls
    bed = Bed(
        every, cells, walls.features, walls.near, np.array([float(ball[:, 3].max())]), np.array([slack])
    )
    enter_all(bed, len(ball))
    return every[: take_places(bed, len(ball), np.ascontiguousarray(found), volume)]


def _places(region: Region, ball: Float64Array, bounds: tuple[float, float], slack: float) -> Float64Array:
    """Return spheres that touch four corners of a tetrahedron, the largest first, (F, 4)."""
    corners = _corners(region, ball, bounds[1])
    tetrahedra = _tetrahedra(corners)
    base = corners.ball[tetrahedra[:, 0]]
    place = _first_guess(corners, tetrahedra)
    good = np.isfinite(place).all(axis=1) & (place[:, 3] > 0.5 * bounds[0]) & (place[:, 3] < 2.0 * bounds[1])
    tetrahedra, base, place = tetrahedra[good], base[good], place[good]
    worst = np.empty(0)
    for _ in range(STEPS):
        place, worst = _step(region, corners, tetrahedra, place)
    _, worst = _step(region, corners, tetrahedra, place)
    place[:, :3] += base[:, :3]
    place[:, :3] = region.walls.seams.wrapped(place[:, :3])
    radius = place[:, 3]
    good = (worst <= slack) & (radius >= bounds[0]) & (radius <= bounds[1])
    place = place[good]
    place = place[region.clearance(place[:, :3]) >= place[:, 3] - slack]
    return place[np.argsort(-place[:, 3], kind="stable")]


def _corners(region: Region, ball: Float64Array, radius_max: float) -> _Corners:
    """Return the corners of the triangulation."""
    seams, reach = region.walls.seams, 2.0 * radius_max
    parts = [ball]
    for turn in product(*[(-1.0, 0.0, 1.0) if each > 0.0 else (0.0,) for each in seams.period]):
        if not any(turn):
            continue
        moved = ball.copy()
        moved[:, :3] += np.array(turn) * seams.period
        beyond = moved[:, 3:] + reach + float(ball[:, 3].max())
        low, high = region.bounds
        parts.append(moved[((moved[:, :3] > low - beyond) & (moved[:, :3] < high + beyond)).all(axis=1)])
    spheres = np.concatenate(parts)
    gap, push = nearest_walls(np.ascontiguousarray(ball[:, :3]), region.walls.features, region.walls.near)
    near = np.flatnonzero(gap < ball[:, 3] + reach)
    mirrored = ball[near].copy()
    mirrored[:, :3] -= 2.0 * gap[near, None] * push[near]
    wall = np.zeros((len(spheres) + len(near), 4))
    wall[len(spheres) :, :3] = -push[near]
    wall[len(spheres) :, 3] = gap[near] - (push[near] * ball[near, :3]).sum(axis=1)
    count = len(spheres) + len(near)
    number = np.arange(count)
    return _Corners(np.concatenate([spheres, mirrored]), number >= len(spheres), wall, number < len(ball))


def _tetrahedra(corners: _Corners) -> Int64Array:
    """Return the tetrahedra of the radical Delaunay triangulation, (T, 4), a sphere of the bed first."""
    ball = corners.ball
    scale = float(ball[:, 3].mean())
    center = (ball[:, :3] - ball[:, :3].mean(axis=0)) / scale
    radius = ball[:, 3] / scale
    # Points around all, so that there is a hull however few spheres there are.
    far = GUARD * (np.abs(center).max() + radius.max())
    guards = far * np.array(list(product((-1.0, 1.0), repeat=3)))
    center, radius = np.concatenate([center, guards]), np.append(radius, np.zeros(len(guards)))
    lifted = (center * center).sum(axis=1) - radius * radius
    hull = ConvexHull(np.column_stack([center, lifted]))
    tetrahedra = hull.simplices[hull.equations[:, 3] < -1e-12].astype(np.int64)
    tetrahedra = np.sort(tetrahedra, axis=1)  # those of the bed have the lowest numbers
    tetrahedra = tetrahedra[tetrahedra[:, 3] < len(ball)]
    order = np.lexsort(tetrahedra.T[::-1])
    tetrahedra = tetrahedra[order]
    kept = corners.own[tetrahedra[:, 0]] & (corners.mirrored[tetrahedra].sum(axis=1) <= 2)
    return np.asarray(tetrahedra[kept])


def _solved(rows: Float64Array, right: Float64Array) -> Float64Array:
    """Return the solutions of systems of three equations, rows (T, 3, 3) and right sides (T, 3)."""
    a, b, c = rows[:, 0], rows[:, 1], rows[:, 2]
    over = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    det = (a * over[:, 0]).sum(axis=1)
    size = np.sqrt((rows * rows).sum(axis=2)).prod(axis=1)
    det = np.where(np.abs(det) > SINGULAR * size, det, np.nan)
    return np.asarray((over * right[:, :, None]).sum(axis=1) / det[:, None])


def _first_guess(corners: _Corners, tetrahedra: Int64Array) -> Float64Array:
    """Return the spheres that touch four corners: centres from the first one, and radii [m], (T, 4).

    The equations of the other corners less that of the first one are linear in centre and radius.
    """
    ball = corners.ball
    base = ball[tetrahedra[:, 0]]
    rows, slope, right = np.empty((len(base), 3, 3)), np.empty((len(base), 3)), np.empty((len(base), 3))
    for k in range(3):
        corner = tetrahedra[:, k + 1]
        flat = corners.mirrored[corner]
        apart = ball[corner, :3] - base[:, :3]
        wall = corners.wall[corner]
        rows[:, k] = np.where(flat[:, None], wall[:, :3], apart)
        slope[:, k] = np.where(flat, 1.0, ball[corner, 3] - base[:, 3])
        square = 0.5 * ((apart * apart).sum(axis=1) - ball[corner, 3] ** 2 + base[:, 3] ** 2)
        right[:, k] = np.where(flat, wall[:, 3] - (wall[:, :3] * base[:, :3]).sum(axis=1), square)
    p, q = _solved(rows, right), -_solved(rows, slope)
    a = (q * q).sum(axis=1) - 1.0
    b = (p * q).sum(axis=1) - base[:, 3]
    c = (p * p).sum(axis=1) - base[:, 3] ** 2
    with np.errstate(invalid="ignore", divide="ignore"):
        root = np.sqrt(b * b - a * c)
        both = np.stack([c / (-b + root), c / (-b - root)])
    radius = np.where(both > 0.0, both, np.inf).min(axis=0)
    radius = np.where(np.isfinite(radius), radius, np.nan)
    return np.column_stack([p + q * radius[:, None], radius])


def _step(
    region: Region, corners: _Corners, tetrahedra: Int64Array, place: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return centres and radii after a step of Newton's method, (T, 4), and the worst gaps before, (T,)."""
    ball = corners.ball
    base = ball[tetrahedra[:, 0]]
    gap, push = np.empty((len(place), 4)), np.empty((len(place), 4, 3))
    for k in range(4):
        corner = tetrahedra[:, k]
        way = place[:, :3] - (ball[corner, :3] - base[:, :3])
        off = np.sqrt((way * way).sum(axis=1))
        gap[:, k] = off - ball[corner, 3] - place[:, 3]
        push[:, k] = way / np.maximum(off, 1e-300)[:, None]
        flat = np.flatnonzero(corners.mirrored[corner])
        points = np.ascontiguousarray(place[flat, :3] + base[flat, :3])
        room, away = nearest_walls(points, region.walls.features, region.walls.near)
        # The wall that the corner stands for, where another one is nearer.
        wall = corners.wall[corner[flat]]
        other = (away * -wall[:, :3]).sum(axis=1) < 0.5
        plane = wall[:, 3] - (wall[:, :3] * points).sum(axis=1)
        gap[flat, k] = np.where(other, plane, room) - place[flat, 3]
        push[flat, k] = np.where(other[:, None], -wall[:, :3], away)
    rows = push[:, 1:] - push[:, :1]
    move = _solved(rows, gap[:, :1] - gap[:, 1:])
    grown = gap[:, 0] + (push[:, 0] * move).sum(axis=1)
    worst = np.abs(gap).max(axis=1)
    moved = np.column_stack([place[:, :3] + move, place[:, 3] + grown])
    wild = ~(np.abs(moved - place).max(axis=1) < place[:, 3])
    return np.where(wild[:, None], place, moved), np.where(np.isfinite(worst), worst, np.inf)
