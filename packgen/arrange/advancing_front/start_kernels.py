"""Where a front begins: spheres at walls, places with fewer than three contacts, and their repair."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.advancing_front.cap_kernels import ROWS, caps_around
from packgen.arrange.advancing_front.cell_kernels import enter, is_free, leave, near_spheres
from packgen.arrange.advancing_front.front_kernels import (
    DRAWS,
    SPHERES,
    Front,
    Rule,
    keep_places,
    put,
)
from packgen.arrange.advancing_front.place_kernels import DISTANCE, Aim, Bed, meets_in_wall, places_at, worth
from packgen.arrange.advancing_front.surface_kernels import (
    FLAT,
    SPHERE,
    polished_at_walls,
    wall_room,
)
from packgen.arrange.random_kernels import next_number
from packgen.arrange.space.feature_kernels import wall_gap
from packgen.arrange.space.map_kernels import candidate, cell_of, count_boundless
from packgen.arrange.space.seams import wrapped_coordinate
from packgen.compiled import inner_loop, loop

APPROACHES = 40
"""Steps in which a sphere is brought to a wall."""

FALLS = 20_000
"""Steps in which a sphere is lowered, each of a radius at most."""

LEVEL = 1.0e-9
"""Slope of a gap from which it closes."""

TURNS = 16
"""Random directions in which places with fewer than three contacts are looked for."""

HOLDERS_MAX = 32
"""Spheres at which a place with three contacts is looked for, the nearest first."""

CONTACT_SLACKS = 8.0
"""Gaps up to so many times the slack are contacts."""


@inner_loop
def _to_wall(x: NDArray[np.float64], push: NDArray[np.float64], radius: float, bed: Bed) -> bool:
    """Move a sphere's centre, shape (3,), to the nearest wall until it touches; tell whether it does."""
    for _ in range(APPROACHES):
        gap, f = wall_room(x[0], x[1], x[2], radius, bed.features, bed.near)
        if f < 0:
            return False
        _, push[0], push[1], push[2] = wall_gap(
            bed.features.kind[f], bed.features.row[f], x[0], x[1], x[2], radius
        )
        if abs(gap) <= bed.slack[0]:
            return True
        for axis in range(3):
            x[axis] -= gap * push[axis]
    return False


@loop
def sow(
    bed: Bed,
    front: Front,
    points: NDArray[np.float64],
    least_up: float,
    aim: Aim,
    worth_max: float,
    most: int,
) -> int:
    """Place the next draws at walls near points, where they overlap nothing.

    Args:
        bed: The spheres that there are; changes.
        front: What is in line; changes.
        points: Points inside [m], shape (P, 3).
        least_up: Least component, along ``aim.vector``, of the direction from the wall.
        aim: Which places are best.
        worth_max: Places that are worse are left alone [m].
        most: How many spheres are placed at most.

    Returns:
        How many were placed.
    """
    x, push, placed = np.empty(3), np.empty(3), 0
    for p in range(len(points)):
        draw = front.counter[DRAWS]
        if draw >= len(front.draw) or placed >= most or front.counter[SPHERES] >= len(bed.ball):
            break
        x[:] = points[p]
        radius = front.draw[draw]
        if not _to_wall(x, push, radius, bed):
            continue
        up = push[0] * aim.vector[0] + push[1] * aim.vector[1] + push[2] * aim.vector[2]
        if up < least_up or worth(x[0], x[1], x[2], 0.0, aim) > worth_max:
            continue
        if is_free(bed.cells, bed.ball, x, radius, bed.radius_max[0], 0.0):
            front.counter[DRAWS] += 1
            put(bed, front, x[0], x[1], x[2], draw)
            placed += 1
    return placed


@loop
def free_points(bed: Bed, points: NDArray[np.float64], radius: float) -> NDArray[np.bool_]:
    """Tell at which points, shape (P, 3), a sphere overlaps no other one, shape (P,)."""
    free = np.empty(len(points), np.bool_)
    for p in range(len(points)):
        free[p] = is_free(bed.cells, bed.ball, points[p], radius, bed.radius_max[0], 0.0)
    return free


@loop
def set_down(bed: Bed, front: Front, point: NDArray[np.float64], draw: int) -> int:
    """Place a draw at a point, shape (3,), whatever it touches there; return its number."""
    return put(bed, front, point[0], point[1], point[2], draw)


@inner_loop
def _fall(bed: Bed, point: NDArray[np.float64], radius: float, up: NDArray[np.float64]) -> float:
    """Return how far a sphere falls before its gap to anything near closes, by the slopes of the gaps [m].

    Spheres and triangles are not reached by that, planes just so, and walls around are passed by a little:
    what is returned then is negative.
    """
    apart, number = np.empty((ROWS, 4)), np.empty(ROWS, np.int64)
    fall = radius
    near = near_spheres(bed.cells, bed.ball, point, 2.0 * radius, bed.radius_max[0], apart, number)
    for k in range(near):
        off = math.sqrt(apart[k, 0] ** 2 + apart[k, 1] ** 2 + apart[k, 2] ** 2)
        slope = (apart[k, 0] * up[0] + apart[k, 1] * up[1] + apart[k, 2] * up[2]) / -off
        if slope > LEVEL:
            fall = min(fall, (off - apart[k, 3] - radius) / slope)
    kind, row = bed.features
    cell = cell_of(point[0], point[1], point[2], bed.near.grid)
    low, boundless = bed.near.start[cell], count_boundless(point[0], point[1], point[2], bed.near)
    for k in range(low - boundless, bed.near.start[cell + 1]):
        f = candidate(k, low, boundless, kind, bed.near)
        if f >= 0:
            gap, px, py, pz = wall_gap(kind[f], row[f], point[0], point[1], point[2], radius)
            slope = px * up[0] + py * up[1] + pz * up[2]
            if slope > LEVEL:
                fall = min(fall, gap / slope)
    return fall


@loop
def lowered(bed: Bed, point: NDArray[np.float64], radius: float, up: NDArray[np.float64]) -> None:
    """Lower a sphere's centre, shape (3,), until the sphere lies on something; it changes."""
    for _ in range(FALLS):
        fall = _fall(bed, point, radius, up)
        for axis in range(3):
            point[axis] -= fall * up[axis]
        if abs(fall) <= bed.slack[0]:
            return


@inner_loop
def _random_unit(state: NDArray[np.uint64], vector: NDArray[np.float64]) -> None:
    """Write a random unit vector, shape (3,)."""
    square = 0.0
    while not 0.01 < square < 1.0:
        square = 0.0
        for axis in range(3):
            share = float(next_number(state) >> np.uint64(11)) / 9007199254740992.0
            vector[axis] = 2.0 * share - 1.0
            square += vector[axis] * vector[axis]
    root = 1.0 / math.sqrt(square)
    for axis in range(3):
        vector[axis] *= root


@inner_loop
def _across(vector: NDArray[np.float64], normal: NDArray[np.float64]) -> bool:
    """Make a vector a unit vector across another one, both of shape (3,); tell whether that was possible."""
    along = vector[0] * normal[0] + vector[1] * normal[1] + vector[2] * normal[2]
    square = 0.0
    for axis in range(3):
        vector[axis] -= along * normal[axis]
        square += vector[axis] * vector[axis]
    root = 1.0 / math.sqrt(max(square, 1e-300))
    for axis in range(3):
        vector[axis] *= root
    return square > 1e-4


@inner_loop
def _aim_direction(base: NDArray[np.float64], aim: Aim, toward: NDArray[np.float64]) -> None:
    """Write the unit vector, shape (3,), in which places become better."""
    square = 0.0
    for axis in range(3):
        toward[axis] = aim.vector[axis] - base[axis] if aim.kind == DISTANCE else -aim.vector[axis]
        square += toward[axis] * toward[axis]
    for axis in range(3):
        toward[axis] /= math.sqrt(max(square, 1e-300))


@inner_loop
def loose_places(bed: Bed, front: Front, rule: Rule, s: int, radius: float) -> int:
    """Find places at a sphere with one or two contacts, in random directions; return how many.

    They are written to ``rule.found``.
    """
    base, bench, slack = bed.ball[s], rule.bench, bed.slack[0]
    far = base[3] + radius
    _, makers, _, walls = caps_around(
        bed.cells, bed.ball, base, radius, bed.radius_max[0], bed.features, bed.near, bench
    )
    if makers < 0:
        return 0
    first, second, third, toward, found = np.empty(3), np.empty(3), np.empty(3), np.empty(3), 0
    x, kind, surface, push = np.empty(3), np.empty(3, np.int64), np.empty((3, 4)), np.empty((3, 3))
    item = bench.item[:walls]
    _aim_direction(base, rule.aim, toward)
    extremes = 2 * min(makers, TURNS)
    for attempt in range(extremes + TURNS):
        i = -1
        if makers > 0:
            i = bench.maker[(attempt // 2 if attempt < extremes else attempt) % makers]
        if i >= 0:
            first[:] = bench.cap[i, :3]
        else:
            _random_unit(front.state, first)
        if attempt < extremes:
            # The best and the worst point of the circle of places.
            sign = 1.0 if attempt % 2 == 0 else -1.0
            for axis in range(3):
                third[axis] = sign * toward[axis]
        else:
            _random_unit(front.state, third)
        if not _across(third, first):
            continue
        for axis in range(3):
            a, b = (axis + 1) % 3, (axis + 2) % 3
            second[axis] = third[a] * first[b] - third[b] * first[a]
        # A plane through the middle of the sphere is the surface that is missing.
        cosine = bench.cap[i, 3] if i >= 0 else 0.0
        sine = math.sqrt(max(1.0 - cosine * cosine, 0.0))
        kind[0], kind[1], kind[2] = SPHERE, FLAT, FLAT
        surface[:] = 0.0
        surface[0, 3] = far
        surface[1, :3] = first
        if i >= 0:
            kind[1] = bench.kind[i]
            surface[1] = bench.surface[i]
        surface[2, :3] = second
        for axis in range(3):
            x[axis] = far * (cosine * first[axis] + sine * third[axis])
        if not polished_at_walls(x, kind, surface, push, base, radius, bed.features, item, slack):
            continue
        center = base[:3] + x
        if meets_in_wall(x, base, radius, bed.features, item):
            continue
        if is_free(bed.cells, bed.ball, center, radius, bed.radius_max[0], slack):
            rule.found[found, :3] = center
            rule.found[found, 3] = worth(center[0], center[1], center[2], radius, rule.aim)
            found += 1
    return found


@loop
def loosen(bed: Bed, front: Front, rule: Rule, s: int, draw: int) -> int:
    """Let a sphere keep places with fewer than three contacts for a draw; return how many there are."""
    radius = front.draw[draw]
    count = loose_places(bed, front, rule, s, radius)
    if count > 0:
        best = 0
        for k in range(1, count):
            if rule.found[k, 3] < rule.found[best, 3]:
                best = k
        rule.found[0] = rule.found[best].copy()
        if not rule.equal:
            front.held[s] = draw
        keep_places(front, s, radius, rule.found, 1)
    return count


@inner_loop
def _touching(bed: Bed, i: int, apart: NDArray[np.float64], number: NDArray[np.int64]) -> int:
    """List the spheres that a sphere touches; return how many."""
    ball = bed.ball[i]
    limit = CONTACT_SLACKS * bed.slack[0]
    return near_spheres(bed.cells, bed.ball, ball, ball[3] + limit, bed.radius_max[0], apart, number)


@inner_loop
def _walls_touched(bed: Bed, i: int) -> int:
    """Return how many features of walls a sphere touches."""
    x, y, z, radius = bed.ball[i, 0], bed.ball[i, 1], bed.ball[i, 2], bed.ball[i, 3]
    kind, row = bed.features
    near, touched = bed.near, 0
    cell = cell_of(x, y, z, near.grid)
    low, boundless = near.start[cell], count_boundless(x, y, z, near)
    for k in range(low - boundless, near.start[cell + 1]):
        f = candidate(k, low, boundless, kind, near)
        if f >= 0:
            touched += wall_gap(kind[f], row[f], x, y, z, radius)[0] <= CONTACT_SLACKS * bed.slack[0]
    return touched


@loop
def contact_counts(bed: Bed, first: int, end: int) -> NDArray[np.int64]:
    """Return how many spheres and walls each of some spheres touches."""
    apart, number = np.empty((ROWS, 4)), np.empty(ROWS, np.int64)
    counts = np.empty(end - first, np.int64)
    for i in range(first, end):
        counts[i - first] = _touching(bed, i, apart, number) + _walls_touched(bed, i)
    return counts


@loop
def repair(bed: Bed, rule: Rule, i: int) -> bool:
    """Move a sphere that touches fewer than three things to where it touches three; tell whether it could be.

    It goes on touching all spheres that it touches, for they may need it.
    """
    apart, number = np.empty((ROWS, 4)), np.empty(ROWS, np.int64)
    before, radius = bed.ball[i].copy(), bed.ball[i, 3]
    touched = _touching(bed, i, apart, number)
    held = number[:touched].copy()
    if touched == 0:
        reach = 3.0 * radius + 2.0 * bed.radius_max[0]
        touched = near_spheres(bed.cells, bed.ball, before, reach, bed.radius_max[0], apart, number)
        order = np.argsort((apart[:touched, :3] ** 2).sum(axis=1))
    else:
        order = np.arange(touched)
    leave(bed.cells, bed.ball, i)
    best, x = np.inf, before.copy()
    limit = CONTACT_SLACKS * bed.slack[0]
    for k in range(min(touched, HOLDERS_MAX)):
        count = places_at(bed, number[order[k]], radius, rule.aim, False, rule.bench, rule.found)
        for m in range(count):
            place = rule.found[m]
            square = (place[0] - before[0]) ** 2 + (place[1] - before[1]) ** 2 + (place[2] - before[2]) ** 2
            if square >= best:
                continue
            keeps = True
            for j in held:
                off = 0.0
                for axis in range(3):
                    way = bed.ball[j, axis] - place[axis]
                    period = bed.cells.period[axis]
                    if period > 0.0:
                        way -= period * np.rint(way / period)
                    off += way * way
                keeps &= math.sqrt(off) - bed.ball[j, 3] - radius <= limit
            if keeps:
                best = square
                x[:3] = place[:3]
        if best < np.inf and len(held) == 0:
            break
    for axis in range(3):
        bed.ball[i, axis] = wrapped_coordinate(x[axis], bed.cells.low[axis], bed.cells.period[axis])
    enter(bed.cells, bed.ball, i)
    return bool(best < np.inf)
