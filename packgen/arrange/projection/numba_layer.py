"""A layer of spheres under arrangement, on the fused CPU loops."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.list_kernels import Pairs
from packgen.arrange.neighbors.seam_pairs import SeamPairs
from packgen.arrange.projection.layer_kernels import rebuilt_plain, run_sweeps
from packgen.arrange.projection.recipe import Schedule, Step, Tally
from packgen.arrange.projection.sweep_kernels import (
    Anchor,
    LayerSpheres,
    Lists,
    Work,
    sphere_overlaps,
    sweep,
)
from packgen.arrange.space.map_kernels import WallList
from packgen.arrange.space.walls import WallTable, no_walls
from packgen.arrays import Float64Array, Int64Array


class FusedLayer:
    """The spheres being arranged, sorted by cell, with their lists; see ``projection.Layer`` for its methods.

    Two layers share no array that either writes to: each may run in a thread of its own.

    Attributes:
        spheres: The spheres.
        lists: What is near them; none before the first rebuild.
        walls: What bounds the moving ones, and where space wraps around.
    """

    def __init__(
        self, ball: Float64Array, moving: int, walls: WallTable, body: Int64Array | None = None
    ) -> None:
        body = np.empty(0, np.int64) if body is None else body
        reference = float(ball[:moving, 3].mean()) if moving else 0.0
        previous, identity = ball[:moving, :3].copy(), np.arange(moving)
        self.spheres = LayerSpheres(ball, previous, np.empty(0), identity, body, reference)
        self.lists = no_lists()
        self.walls = walls

    @property
    def moving(self) -> int:
        """How many spheres move; those taken out count until the next rebuild."""
        return len(self.spheres.previous)

    @property
    def identity(self) -> Int64Array:
        """Place of each moving sphere in the order given, shape (moving,)."""
        return self.spheres.identity

    def run(self, down: Float64Array, schedule: Schedule, strays: int) -> Tally:
        """Run the sweeps of a schedule; see ``layer_kernels.run_sweeps``."""
        state, tally = run_sweeps(self.spheres, self.lists, self.walls, down, schedule, strays)
        self._take(*state)
        return Tally(*tally)

    def rebuild(self, skin: float) -> None:
        """Sort the spheres by cell and list their neighbours and walls anew."""
        self._take(*rebuilt_plain(self.spheres, self.lists, self.walls, skin))

    def _take(self, spheres: tuple[Any, ...], lists: tuple[Any, ...]) -> None:
        """Give what a loop has returned its names again; see ``layer_kernels.plain``."""
        pairs, seam, near, anchor, work = lists
        self.spheres = LayerSpheres(*spheres)
        self.lists = Lists(Pairs(*pairs), SeamPairs(*seam), WallList(*near), Anchor(*anchor), Work(*work))

    def sweep(self, sink: Float64Array, step: Step) -> tuple[float, int]:
        """Run one sweep; see ``sweep_kernels.sweep``."""
        worst, strays = sweep(self.spheres, self.lists, self.walls.features, sink, step)
        return float(worst), int(strays)

    def overlaps(self, scale: float, down: Float64Array) -> tuple[float, Float64Array]:
        """Return the largest overlap of the true spheres, and the one each moving sphere is blamed for."""
        worst, blame = sphere_overlaps(self.spheres, self.lists, self.walls.features, down, scale)
        return float(worst), blame

    def take_out(self, out: NDArray[np.bool_]) -> None:
        """Take moving spheres out of all contacts."""
        # NaN compares false: never in contact, never counted as having outrun the list.
        self.spheres.ball[: self.moving][out, :3] = np.nan

    def positions(self) -> Float64Array:
        """Return the centres of the moving spheres, in the layer's own order [m], shape (moving, 3)."""
        return self.walls.seams.wrapped(self.spheres.ball[: self.moving, :3])

    def radii(self) -> Float64Array:
        """Return the arranged radii of the moving spheres, in the layer's own order [m], shape (moving,)."""
        return self.spheres.ball[: self.moving, 3]


def no_lists() -> Lists:
    """Return empty lists."""
    none = np.empty(0, np.int32)
    return Lists(
        Pairs(none, none),
        SeamPairs(none, none, np.empty((0, 3))),
        no_walls(),
        Anchor(np.empty((0, 3)), np.empty(0)),
        Work(none, np.empty((0, 3))),
    )
