"""The front: spheres that keep places in line for the next ones, and the best place taken again and again."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.advancing_front.cap_kernels import Bench
from packgen.arrange.advancing_front.cell_kernels import enter, is_free
from packgen.arrange.advancing_front.place_kernels import Aim, Bed, places_at
from packgen.arrange.random_kernels import next_number
from packgen.arrange.space.seams import wrapped_coordinate
from packgen.compiled import inlined, inner_loop, loop

BEST = 3
"""Places among which the next one is chosen at random."""

PLACES_OF_ONE = 8
"""Places that a sphere keeps where each of its radii is another one."""

LOOKED_AT = 16
"""Draws that wait among which a sphere looks for one smaller than those that it had no place for."""

NONE_LEFT, NONE_FITS = -1, -2
"""Why a sphere has no draw to try: there is none, or all are too large."""

SPHERES, DRAWS, LINE_FIRST, LINE_END, PLACES, SPARE = 0, 1, 2, 3, 4, 5
"""Counters: spheres there are; the next draw; first and last of the queue; places kept; rows to spare."""

COUNTERS = 8

DONE, MORE_DRAWS, MORE_ROOM, NO_PLACE = 0, 1, 2, 3
"""Why a run ended: so many are placed; draws are short; arrays are; or no place is left."""


class Front(NamedTuple):
    """What is in line.

    Attributes:
        counter: See COUNTERS, int64.
        draw: Radii in the order in which they were drawn [m], shape (D,).
        line: Draws that found no place and wait, a ring, shape (L,), int64.
        draw_of: Draw of each sphere, -1 of earlier ones, shape (capacity,), int64.
        held: Draw that each sphere holds ready, -1: none, shape (capacity,), int64.
        stamp: How often each has changed it, shape (capacity,), int32.
        open_places: How many places it keeps for it, shape (capacity,), int32.
        hungry: Whether it has none because there were no draws, shape (capacity,).
        closed: Least radius that found no place at it [m]: larger ones are not tried, shape (capacity,).
        key: Heap of places: what is least at the best one [m], shape (P,).
        row: Heap of places: their rows below, shape (P,), int64.
        spare: Rows that are free, shape (P,), int64.
        place: Centres, and radii [m], shape (P, 4).
        owner: Sphere that keeps the place, shape (P,), int64.
        place_stamp: Its stamp then, shape (P,), int32.
        state: State of the random numbers, shape (1,), uint64.
    """

    counter: NDArray[np.int64]
    draw: NDArray[np.float64]
    line: NDArray[np.int64]
    draw_of: NDArray[np.int64]
    held: NDArray[np.int64]
    stamp: NDArray[np.int32]
    open_places: NDArray[np.int32]
    hungry: NDArray[np.bool_]
    closed: NDArray[np.float64]
    key: NDArray[np.float64]
    row: NDArray[np.int64]
    spare: NDArray[np.int64]
    place: NDArray[np.float64]
    owner: NDArray[np.int64]
    place_stamp: NDArray[np.int32]
    state: NDArray[np.uint64]


class Rule(NamedTuple):
    """How places are chosen.

    Attributes:
        aim: Which are best.
        borne: Whether contacts have to bear a sphere's weight.
        equal: Whether all radii are the same.
        tries: Radii that a sphere of the front tries before it leaves the front.
        bench: Room for what is near a sphere.
        found: Room for the places at one, shape (PLACES_MAX, 4).
    """

    aim: Aim
    borne: bool
    equal: bool
    tries: int
    bench: Bench
    found: NDArray[np.float64]


@inner_loop
def pushed(front: Front, key: float, row: int) -> None:
    """Put a row into the heap."""
    at = front.counter[PLACES]
    front.counter[PLACES] += 1
    while at > 0:
        above = (at - 1) // 2
        if front.key[above] <= key:
            break
        front.key[at], front.row[at] = front.key[above], front.row[above]
        at = above
    front.key[at], front.row[at] = key, row


@inner_loop
def popped(front: Front):  # type: ignore[no-untyped-def]
    """Take the best row out of the heap: (key, row)."""
    best, row = front.key[0], front.row[0]
    front.counter[PLACES] -= 1
    count = front.counter[PLACES]
    key, last = front.key[count], front.row[count]
    at = 0
    while True:
        below = 2 * at + 1
        if below >= count:
            break
        if below + 1 < count and front.key[below + 1] < front.key[below]:
            below += 1
        if front.key[below] >= key:
            break
        front.key[at], front.row[at] = front.key[below], front.row[below]
        at = below
    front.key[at], front.row[at] = key, last
    return best, row


@inlined
def _freed(front: Front, row: int) -> None:
    front.spare[front.counter[SPARE]] = row
    front.counter[SPARE] += 1


@inner_loop
def keep_places(front: Front, s: int, radius: float, found: NDArray[np.float64], count: int) -> None:
    """Keep places for a sphere, shape (count, 4)."""
    for k in range(count):
        front.counter[SPARE] -= 1
        row = front.spare[front.counter[SPARE]]
        front.place[row, 0], front.place[row, 1], front.place[row, 2] = found[k, 0], found[k, 1], found[k, 2]
        front.place[row, 3] = radius
        front.owner[row], front.place_stamp[row] = s, front.stamp[s]
        pushed(front, found[k, 3], row)
    front.open_places[s] += count


@inner_loop
def _best_first(found: NDArray[np.float64], count: int, wanted: int) -> int:
    """Bring the best places to the front; return how many of them there are."""
    if count <= wanted:
        return count
    for k in range(wanted):
        best = k
        for m in range(k + 1, count):
            if found[m, 3] < found[best, 3]:
                best = m
        if best != k:
            for axis in range(4):
                found[k, axis], found[best, axis] = found[best, axis], found[k, axis]
    return wanted


@inner_loop
def _next_draw(front: Front) -> int:
    """Take a draw: of those that wait the first, or the next one; -1 where there is none."""
    counter = front.counter
    if counter[LINE_FIRST] < counter[LINE_END]:
        counter[LINE_FIRST] += 1
        return int(front.line[(counter[LINE_FIRST] - 1) % len(front.line)])
    if counter[DRAWS] < len(front.draw):
        counter[DRAWS] += 1
        return int(counter[DRAWS] - 1)
    return -1


@inner_loop
def _wait(front: Front, draw: int) -> None:
    """Let a draw wait."""
    front.line[front.counter[LINE_END] % len(front.line)] = draw
    front.counter[LINE_END] += 1


@inner_loop
def _fitting_draw(front: Front, limit: float) -> int:
    """Take a draw smaller than a limit [m]: of those that wait the first one, or the next one.

    Returns:
        The draw, NONE_LEFT or NONE_FITS.
    """
    counter, line = front.counter, front.line
    first, size = counter[LINE_FIRST], len(front.line)
    waiting = counter[LINE_END] - first
    for k in range(min(waiting, LOOKED_AT)):
        draw = line[(first + k) % size]
        if front.draw[draw] < limit:
            for m in range(k, 0, -1):
                line[(first + m) % size] = line[(first + m - 1) % size]
            counter[LINE_FIRST] += 1
            return int(draw)
    if counter[DRAWS] >= len(front.draw):
        return NONE_FITS if waiting > 0 else NONE_LEFT
    draw = counter[DRAWS]
    counter[DRAWS] += 1
    if front.draw[draw] < limit:
        return int(draw)
    _wait(front, draw)
    return NONE_FITS


@inner_loop
def provide(bed: Bed, front: Front, rule: Rule, s: int) -> bool:
    """Let a sphere hold the next radius ready and keep the places for it; tell whether it has any."""
    if rule.equal:
        radius = front.draw[0]
        count = places_at(bed, s, radius, rule.aim, rule.borne, rule.bench, rule.found)
        keep_places(front, s, radius, rule.found, max(count, 0))
        return bool(count > 0)
    for _ in range(rule.tries):
        draw = _fitting_draw(front, front.closed[s])
        if draw < 0:
            front.hungry[s] = draw == NONE_LEFT
            return False
        radius = front.draw[draw]
        count = places_at(bed, s, radius, rule.aim, rule.borne, rule.bench, rule.found)
        if count > 0:
            front.held[s] = draw
            keep_places(front, s, radius, rule.found, _best_first(rule.found, count, PLACES_OF_ONE))
            return True
        front.closed[s] = radius
        _wait(front, draw)
    return False


@inner_loop
def put(bed: Bed, front: Front, x: float, y: float, z: float, draw: int) -> int:
    """Place a sphere and return its number."""
    i = front.counter[SPHERES]
    front.counter[SPHERES] += 1
    cells = bed.cells
    bed.ball[i, 0] = wrapped_coordinate(x, cells.low[0], cells.period[0])
    bed.ball[i, 1] = wrapped_coordinate(y, cells.low[1], cells.period[1])
    bed.ball[i, 2] = wrapped_coordinate(z, cells.low[2], cells.period[2])
    bed.ball[i, 3] = front.draw[draw]
    front.draw_of[i], front.held[i], front.stamp[i] = draw, -1, 0
    front.open_places[i], front.hungry[i], front.closed[i] = 0, False, np.inf
    enter(cells, bed.ball, i)
    return int(i)


@inner_loop
def _next_valid(bed: Bed, front: Front, rule: Rule):  # type: ignore[no-untyped-def]
    """Take the best place that is still free out of the heap: (key, row); row -1: there is none."""
    while front.counter[PLACES] > 0:
        key, row = popped(front)
        s = front.owner[row]
        if front.place_stamp[row] != front.stamp[s]:
            _freed(front, row)
            continue
        if is_free(
            bed.cells, bed.ball, front.place[row], front.place[row, 3], bed.radius_max[0], bed.slack[0]
        ):
            return key, row
        _freed(front, row)
        front.open_places[s] -= 1
        if front.open_places[s] == 0 and not rule.equal:
            _renew(bed, front, rule, s)
    return 0.0, -1


@inner_loop
def _renew(bed: Bed, front: Front, rule: Rule, s: int) -> None:
    """Find new places for the radius that a sphere holds ready, or let that wait and hold another one."""
    draw = front.held[s]
    radius = front.draw[draw]
    count = places_at(bed, s, radius, rule.aim, rule.borne, rule.bench, rule.found)
    if count > 0:
        count = _best_first(rule.found, count, PLACES_OF_ONE)
        keep_places(front, s, radius, rule.found, count)
        return
    front.held[s] = -1
    front.closed[s] = radius
    provide(bed, front, rule, s)
    _wait(front, draw)


@loop
def enter_all(bed: Bed, count: int) -> None:
    """Put the first spheres into their cells."""
    for i in range(count):
        enter(bed.cells, bed.ball, i)


@loop
def provide_all(bed: Bed, front: Front, rule: Rule, spheres: NDArray[np.int64]) -> None:
    """Let some spheres keep places for the next draws."""
    for s in spheres:
        front.hungry[s] = False
        provide(bed, front, rule, s)


@loop
def advance(bed: Bed, front: Front, rule: Rule, wanted: int, spare_draws: int) -> int:
    """Place spheres, each at one of the best places.

    Args:
        bed: The spheres that there are; changes.
        front: What is in line; changes.
        rule: How places are chosen.
        wanted: How many spheres there are to be at most.
        spare_draws: So many draws have to be left, or the run ends.

    Returns:
        Why it ended: DONE, MORE_DRAWS, MORE_ROOM or NO_PLACE.
    """
    counter = front.counter
    keys, rows = np.empty(BEST), np.empty(BEST, np.int64)
    while counter[SPHERES] < wanted:
        if len(front.draw) - counter[DRAWS] < spare_draws:
            return MORE_DRAWS
        if counter[SPARE] < 4 * len(rule.found):
            return MORE_ROOM
        count = 0
        while count < BEST:
            key, row = _next_valid(bed, front, rule)
            if row < 0:
                break
            keys[count], rows[count] = key, row
            count += 1
        if count == 0:
            return NO_PLACE
        chosen = int(next_number(front.state) % np.uint64(count))
        for k in range(count):
            if k != chosen:
                pushed(front, keys[k], rows[k])
        row = rows[chosen]
        s = front.owner[row]
        draw = _next_draw(front) if rule.equal else front.held[s]
        if draw < 0:
            pushed(front, keys[chosen], row)
            return NO_PLACE
        i = put(bed, front, front.place[row, 0], front.place[row, 1], front.place[row, 2], draw)
        _freed(front, row)
        front.open_places[s] -= 1
        if not rule.equal:
            front.stamp[s] += 1
            front.open_places[s], front.held[s] = 0, -1
            provide(bed, front, rule, s)
        provide(bed, front, rule, i)
    return DONE
