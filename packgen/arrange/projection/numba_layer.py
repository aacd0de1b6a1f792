"""A layer of spheres under arrangement, on the fused CPU loops."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.list_kernels import Pairs
from packgen.arrange.neighbors.seam_pairs import SeamPairs
from packgen.arrange.projection.layer_kernels import (
    blame_alone,
    rebuilt_alone,
    run_sweeps,
    sweep_alone,
)
from packgen.arrange.projection.recipe import Schedule, Step, Tally
from packgen.arrange.projection.shares import Team
from packgen.arrange.projection.sweep_kernels import Anchor, LayerState, Lists, Now, Work
from packgen.arrange.space.map_kernels import WallList
from packgen.arrange.space.walls import WallTable, no_walls
from packgen.arrays import Float64Array, Int64Array
from packgen.team import new_board, together


class FusedLayer:
    """The spheres being arranged, sorted by cell, with their lists; see ``projection.Layer`` for its methods.

    Two layers share no array that either writes to: each may run in a thread of its own. The threads of one
    layer share its state, and each has lists of its own.

    Attributes:
        state: The spheres.
        now: What counts of them.
        lists: What is near the spheres of each thread; nothing before the first rebuild.
        walls: What bounds the moving ones, and where space wraps around.
    """

    def __init__(
        self,
        ball: Float64Array,
        moving: int,
        walls: WallTable,
        body: Int64Array | None = None,
        threads: int = 1,
        *,
        rubs: bool = False,
    ) -> None:
        count = len(ball)
        rubbing = count if rubs else 0
        self.state = LayerState(
            np.stack([ball, np.empty((count, 4))]),
            np.stack([ball[:moving, :3], np.empty((moving, 3))]),
            np.stack([np.arange(moving), np.empty(moving, np.int64)]),
            np.empty((2, count, 4)),
            np.empty(count),
            np.empty(moving),
            np.zeros((2, rubbing, 3)),
            np.zeros((2, rubbing, 3)),
            np.empty(0, np.int64) if body is None else body,
            float(ball[:moving, 3].mean()) if moving else 0.0,
        )
        self.now = Now(0, moving, count)
        self.lists = [no_lists() for _ in range(threads)]
        self.walls = walls
        told, known, outbox = (
            np.zeros((4, threads, 8)),
            np.empty(4, np.int64),
            np.empty((threads, 2), np.int64),
        )
        ends = np.arange(1.0, threads + 1.0) / threads
        self._board = new_board()
        self._teams = [Team(rank, threads, self._board, told, known, outbox, ends) for rank in range(threads)]

    @property
    def moving(self) -> int:
        """How many spheres move; those taken out count until the next rebuild."""
        return self.now.moving

    @property
    def ball(self) -> Float64Array:
        """Centres and arranged radii of all spheres, in the layer's own order [m], shape (N, 4)."""
        return self.state.ball[self.now.side, : self.now.total]

    @property
    def previous(self) -> Float64Array:
        """Centres of the moving spheres one sweep ago, in the layer's own order [m], shape (moving, 3)."""
        return self.state.previous[self.now.side, : self.now.moving]

    @property
    def identity(self) -> Int64Array:
        """Place of each moving sphere in the order given, shape (moving,)."""
        return self.state.identity[self.now.side, : self.now.moving]

    def run(self, down: Float64Array, schedule: Schedule, strays: int) -> Tally:
        """Run the sweeps of a schedule; see ``layer_kernels.run_sweeps``."""
        outcomes = self._together(run_sweeps, self.walls, down, schedule, strays)
        self._take([each[0] for each in outcomes])
        return Tally(*outcomes[0][1])

    def rebuild(self, skin: float) -> None:
        """Sort the spheres by cell and list their neighbours and walls anew."""
        self._take(self._together(rebuilt_alone, self.walls, skin))

    def sweep(self, sink: Float64Array, step: Step) -> tuple[float, int]:
        """Run one sweep; see ``sweep_kernels.sweep``."""
        worst, strays = self._together(sweep_alone, self.walls, sink, step)[0]
        return float(worst), int(strays)

    def overlaps(self, scale: float, down: Float64Array) -> tuple[float, Float64Array]:
        """Return the largest overlap of the true spheres, and the one each moving sphere is blamed for."""
        largest = self._together(blame_alone, self.walls, down, scale)[0]
        return float(largest), self.state.blame[: self.moving].copy()

    def take_out(self, out: NDArray[np.bool_]) -> None:
        """Take moving spheres out of all contacts."""
        # NaN compares false: never in contact, never counted as having outrun the list.
        self.ball[: self.moving][out, :3] = np.nan

    def positions(self) -> Float64Array:
        """Return the centres of the moving spheres, in the layer's own order [m], shape (moving, 3)."""
        return self.walls.seams.wrapped(self.ball[: self.moving, :3])

    def radii(self) -> Float64Array:
        """Return the arranged radii of the moving spheres, in the layer's own order [m], shape (moving,)."""
        return self.ball[: self.moving, 3]

    def _together(self, loop: Callable[..., Any], *arguments: Any) -> list[Any]:
        """Return what each thread's call of a loop returns."""
        state, now = self.state, self.now
        return together(
            loop,
            self._board,
            [
                (state, now, lists, *arguments, team)
                for lists, team in zip(self.lists, self._teams, strict=True)
            ],
        )

    def _take(self, outcomes: list[tuple[Any, ...]]) -> None:
        """Give what a loop has returned its names again; see ``layer_kernels.plain``."""
        self.now = Now(*outcomes[0][0])
        self.lists = [
            Lists(own, Pairs(*pairs), SeamPairs(*seam), WallList(*near), Anchor(*anchor), Work(*work))
            for _, (own, pairs, seam, near, anchor, work) in outcomes
        ]


def no_lists() -> Lists:
    """Return empty lists."""
    none = np.empty(0, np.int32)
    return Lists(
        none,
        Pairs(none, none),
        SeamPairs(none, none, np.empty((0, 3))),
        no_walls(),
        Anchor(np.empty((0, 3)), np.empty(0)),
        Work(none, none, none, np.empty((0, 3)), np.empty((0, 3)), none),
    )
