"""A layer of spheres under arrangement, on the fused CPU loops."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.list_kernels import Pairs
from packgen.arrange.neighbors.listing import list_pairs
from packgen.arrange.neighbors.seam_pairs import SeamPairs, no_pairs, seam_pairs
from packgen.arrange.projection.pair_rules import list_reach, pairs_to_part, push_weights
from packgen.arrange.projection.ranks import closed_ranks
from packgen.arrange.projection.recipe import Schedule, Step
from packgen.arrange.projection.sweep_kernels import (
    Anchor,
    LayerSpheres,
    Work,
    sphere_overlaps,
    sweep,
    sweeps,
)
from packgen.arrange.space.map_kernels import WallList
from packgen.arrange.space.walls import WallTable, walls_in_reach
from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.portable import components


@dataclass(slots=True)
class FusedLayer:
    """The spheres being arranged, sorted by cell, with their neighbour list.

    Attributes:
        ball: Centres and arranged radii [m], shape (N, 4); the first ``moving`` move.
        moving: How many move.
        walls: What bounds the moving ones, and where space wraps around.
        body_index: Body of each sphere that moved at first, in the order given; None: each sphere is a body.
        previous: Centres of the moving spheres one sweep ago [m], shape (moving, 3).
        identity: Place of each moving sphere in the order given, shape (moving,).
        reference: Mean radius of the moving spheres [m].
        weight: Weight of each sphere in a push, shape (N,).
        pairs: Its neighbour list.
        seam: The pairs that are close across a seam.
        near: The walls that each moving sphere can reach.
        anchor: For how long these lists hold.
        work: Work space of a sweep.
    """

    ball: Float64Array
    moving: int
    walls: WallTable
    body_index: Int32Array | None = None
    previous: Float64Array = field(init=False)
    identity: Int64Array = field(init=False)
    reference: float = field(init=False)
    weight: Float64Array = field(init=False)
    pairs: Pairs = field(init=False)
    seam: SeamPairs = field(init=False, default_factory=no_pairs)
    near: WallList = field(init=False)
    anchor: Anchor = field(init=False)
    work: Work = field(init=False)

    def __post_init__(self) -> None:
        self.previous = self.ball[: self.moving, :3].copy()
        self.identity = np.arange(self.moving)
        self.pairs = Pairs(np.empty(0, np.int32), np.empty(24 * len(self.ball) + 4096, np.int32))
        length = 2 * self.moving + 4096
        self.near = WallList(np.empty(0, np.int64), np.empty(length, np.int32), np.empty(length))
        self.reference = float(self.ball[: self.moving, 3].mean()) if self.moving else 0.0

    def rebuild(self, skin: float) -> None:
        """Sort the spheres by cell and list their neighbours and walls anew."""
        ball, previous, identity = closed_ranks(self.ball, self.previous, self.identity, self.walls.seams)
        moving = self.moving = len(previous)
        reach = list_reach(ball[:, 3], moving, skin, self.reference)
        order, spheres, self.pairs = list_pairs(ball, reach, moving, self.pairs.neighbor)
        self.ball, reach = spheres.ball, spheres.reach
        self.previous = previous.take(order[:moving], axis=0)
        self.identity = identity.take(order[:moving])
        if self.walls.seams.wraps:
            self.seam = seam_pairs(self.ball, reach, moving, self.walls.seams)
        if self.body_index is not None:
            self._leave_out_bodies(self.body_index)
        margin = reach[:moving] - self.ball[:moving, 3]
        self.near = walls_in_reach(self.ball, margin, self.walls, self.near)
        self.anchor = Anchor(self.ball[:moving, :3].copy(), margin)
        self.weight = push_weights(self.ball[:, 3], moving, self.reference)
        count = len(self.pairs.owner)
        self.work = Work(np.empty(count + 1, np.int32), np.empty((len(self.ball), 3)))

    def _leave_out_bodies(self, body_index: Int32Array) -> None:
        """Take the pairs of one body out of the lists: its spheres may overlap each other."""
        pairs, seam, count = self.pairs, self.seam, len(self.ball)
        other = pairs.neighbor[: len(pairs.owner)]
        apart = pairs_to_part(pairs.owner, other, body_index, self.identity, count)
        pairs.neighbor[: np.count_nonzero(apart)] = other[apart]
        self.pairs = Pairs(pairs.owner[apart], pairs.neighbor)
        apart = pairs_to_part(seam.first, seam.second, body_index, self.identity, count)
        self.seam = SeamPairs(seam.first[apart], seam.second[apart], seam.offset[apart])

    def sweep(self, sink: Float64Array, step: Step) -> tuple[float, int]:
        """Run one sweep; see ``sweep_kernels.sweep``."""
        spheres = LayerSpheres(self.ball, self.previous, self.weight, self.identity)
        worst, strays = sweep(
            spheres, self.pairs, self.seam, self.walls.features, self.near, self.anchor, self.work, sink, step
        )
        return float(worst), int(strays)

    def sweeps(self, down: Float64Array, schedule: Schedule) -> tuple[int, float, int]:
        """Run sweeps; see ``sweep_kernels.sweeps``."""
        spheres = LayerSpheres(self.ball, self.previous, self.weight, self.identity)
        done, worst, strays = sweeps(
            spheres, self.pairs, self.seam, self.walls.features, self.near, self.anchor, self.work, down,
            schedule,
        )  # fmt: skip
        return int(done), float(worst), int(strays)

    def overlaps(self, scale: float, down: Float64Array) -> tuple[float, Float64Array]:
        """Return the largest overlap of the true spheres, and the one each moving sphere is blamed for."""
        blame = np.empty(self.moving)
        height = -components(self.ball[: self.moving, :3], down)
        worst = sphere_overlaps(
            self.ball, scale, self.pairs, self.seam, self.walls.features, self.near, height, blame
        )
        return float(worst), blame

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
