"""The front of a zone: its arrays, where it begins, and its way through the zone until it is full."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from packgen.arrange.advancing_front.cap_kernels import new_bench
from packgen.arrange.advancing_front.cell_kernels import Cells
from packgen.arrange.advancing_front.front_kernels import (
    COUNTERS,
    DONE,
    DRAWS,
    LINE_END,
    LINE_FIRST,
    MORE_DRAWS,
    MORE_ROOM,
    PLACES,
    SPARE,
    SPHERES,
    Front,
    Rule,
    advance,
    enter_all,
    provide_all,
)
from packgen.arrange.advancing_front.place_kernels import PLACES_MAX, Aim, Bed
from packgen.arrange.space.region import Region
from packgen.arrays import Float64Array, Int64Array
from packgen.compiled import signals_heard
from packgen.portable import cube_root

AT_ONCE = 5_000
"""Spheres placed by one run of the compiled loop: a signal waits for its end."""

ROWS_FIRST = 2**14
"""Rows for places at first."""

TRIES = 2
"""Radii that a sphere of the front tries before it leaves the front."""

CELLS_MAX = 30_000_000

SLACK = 2.0e-15
"""Gap that counts as a contact, of the largest coordinate; and five times that of the smallest radius."""


class Growth:
    """The spheres of a zone while the front advances.

    Attributes:
        bed: The spheres, those that were there before first.
        front: What is in line.
        rule: How places are chosen.
        first: How many were there before.
    """

    def __init__(
        self, region: Region, earlier: Float64Array, radius: Float64Array, aim: Aim, borne: bool,
        rng: np.random.Generator,
    ) -> None:  # fmt: skip
        """Make room for the spheres of a zone.

        Args:
            region: The zone.
            earlier: Centres and radii of the spheres that are there [m], shape (E, 4).
            radius: The first radii drawn [m], shape (D,).
            aim: Which places are best.
            borne: Whether contacts have to bear a sphere's weight.
            rng: Source of randomness.
        """
        self.first = len(earlier)
        capacity = self.first + len(radius)
        ball = np.zeros((capacity, 4))
        ball[: self.first] = earlier
        largest = max(float(radius.max()), float(earlier[:, 3].max(initial=0.0)))
        features, near = region.walls.features, region.walls.near
        slack = slack_of(region, float(radius.min()))
        cells = new_cells(region, float(radius.mean()), capacity)
        self.bed = Bed(ball, cells, features, near, np.array([largest]), np.array([slack]))
        equal = bool(radius.min() == radius.max())
        self.rule = Rule(aim, borne, equal, TRIES, new_bench(), np.empty((PLACES_MAX, 4)))
        self.front = _front(radius, capacity, self.first, rng)
        enter_all(self.bed, self.first)

    @property
    def count(self) -> int:
        """How many spheres there are, those of before included."""
        return int(self.front.counter[SPHERES])

    @property
    def waiting(self) -> Int64Array:
        """The draws that wait, shape (W,)."""
        counter, line = self.front.counter, self.front.line
        return np.asarray(line[np.arange(counter[LINE_FIRST], counter[LINE_END]) % len(line)])

    @property
    def draws_left(self) -> int:
        """How many draws have not had their turn yet."""
        return len(self.front.draw) - int(self.front.counter[DRAWS])

    @property
    def has_places(self) -> bool:
        """Whether any sphere keeps a place."""
        return bool(self.front.counter[PLACES] > 0)

    def take(self) -> int:
        """Take a draw: one that waits, or the next one."""
        counter = self.front.counter
        if counter[LINE_FIRST] < counter[LINE_END]:
            counter[LINE_FIRST] += 1
            return int(self.front.line[(counter[LINE_FIRST] - 1) % len(self.front.line)])
        counter[DRAWS] += 1
        return int(counter[DRAWS] - 1)

    def give_back(self, draw: int) -> None:
        """Let a draw wait."""
        counter = self.front.counter
        self.front.line[counter[LINE_END] % len(self.front.line)] = draw
        counter[LINE_END] += 1

    def more_draws(self, radius: Float64Array) -> None:
        """Add draws of some radii [m], shape (D,), and room for as many spheres."""
        front, waiting = self.front, self.waiting
        self.rule = self.rule._replace(equal=self.rule.equal and bool((radius == front.draw[0]).all()))
        capacity = len(self.bed.ball) + len(radius)
        line = np.empty(len(front.draw) + len(radius) + 2 * TRIES, np.int64)
        line[: len(waiting)] = waiting
        front.counter[LINE_FIRST], front.counter[LINE_END] = 0, len(waiting)
        names = ("draw_of", "held", "stamp", "open_places", "hungry", "closed")
        self.front = front._replace(
            draw=np.concatenate([front.draw, radius]),
            line=line,
            **{name: _longer(getattr(front, name), capacity) for name in names},
        )
        cells = self.bed.cells._replace(following=_longer(self.bed.cells.following, capacity))
        self.bed = self.bed._replace(ball=_longer(self.bed.ball, capacity), cells=cells)

    def advance(self, tell: Callable[[int], None], spare_draws: int) -> bool:
        """Place spheres until draws are short; tell whether they are, or no place is left.

        Args:
            tell: Called with the number of spheres now and then.
            spare_draws: So many draws have to be left.
        """
        while True:
            wanted = min(self.count + AT_ONCE, len(self.bed.ball))
            with signals_heard():
                reason = advance(self.bed, self.front, self.rule, wanted, spare_draws)
            tell(self.count)
            if reason == MORE_ROOM:
                self._more_rows()
            elif reason == MORE_DRAWS:
                return True
            elif reason != DONE or wanted == len(self.bed.ball):
                return False

    def provide(self, spheres: Int64Array) -> None:
        """Let some spheres keep places for the next draws."""
        for first in range(0, len(spheres), AT_ONCE):
            chosen = spheres[first : first + AT_ONCE]
            while self.front.counter[SPARE] < (len(chosen) + 8) * PLACES_MAX:
                self._more_rows()
            with signals_heard():
                provide_all(self.bed, self.front, self.rule, chosen)

    def _more_rows(self) -> None:
        front = self.front
        before = len(front.row)
        names = ("key", "row", "spare", "place", "owner", "place_stamp")
        self.front = front._replace(**{name: _longer(getattr(front, name), 2 * before) for name in names})
        spare = int(front.counter[SPARE])
        self.front.spare[spare : spare + before] = np.arange(2 * before - 1, before - 1, -1)
        front.counter[SPARE] += before


def _longer(array: Any, length: int) -> Any:
    """Return an array with more rows, the new ones zero."""
    longer = np.zeros((length, *array.shape[1:]), array.dtype)
    longer[: len(array)] = array
    return longer


def slack_of(region: Region, radius_min: float) -> float:
    """Return the gap that counts as a contact [m]."""
    return 5.0 * SLACK * radius_min + SLACK * float(np.abs(region.bounds).max())


def new_cells(region: Region, mean_radius: float, capacity: int) -> Cells:
    """Return empty cells over a region for a number of spheres."""
    low, high = region.bounds
    extent = high - low
    size = max(2.0 * mean_radius, cube_root(float(np.prod(extent)) / CELLS_MAX))
    count = np.maximum((extent / size).astype(np.int64), 1)
    return Cells(
        np.array(low), extent / count, count, np.array(region.walls.seams.period),
        np.full(int(np.prod(count)), -1, np.int32), np.full(capacity, -1, np.int32),
    )  # fmt: skip


def _front(radius: Float64Array, capacity: int, first: int, rng: np.random.Generator) -> Front:
    """Return a front without places."""
    counter = np.zeros(COUNTERS, np.int64)
    counter[SPHERES], counter[SPARE] = first, ROWS_FIRST
    return Front(
        counter, np.array(radius), np.empty(len(radius) + 2 * TRIES, np.int64),
        np.full(capacity, -1, np.int64), np.full(capacity, -1, np.int64), np.zeros(capacity, np.int32),
        np.zeros(capacity, np.int32), np.zeros(capacity, bool), np.full(capacity, np.inf),
        np.empty(ROWS_FIRST),
        np.empty(ROWS_FIRST, np.int64), np.arange(ROWS_FIRST - 1, -1, -1), np.empty((ROWS_FIRST, 4)),
        np.empty(ROWS_FIRST, np.int64), np.empty(ROWS_FIRST, np.int32), rng.integers(0, 2**64, 1, np.uint64),
    )  # fmt: skip
