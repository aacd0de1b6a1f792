"""A layer of spheres under arrangement, on the fused CPU loops."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.list_kernels import cell_keys, fill_list, gather, level_grids
from packgen.arrange.neighbors.seam_pairs import SeamPairs, no_pairs, seam_pairs
from packgen.arrange.projection.pair_rules import list_reach, pairs_to_part, push_lightness
from packgen.arrange.projection.recipe import Step
from packgen.arrange.projection.sweep_kernels import sphere_overlaps, sweep
from packgen.arrange.space.map_kernels import wall_candidates
from packgen.arrange.space.walls import WallTable
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
        margin: How far each moving sphere may move while the list holds [m], shape (moving,).
    """

    ball: Float64Array
    moving: int
    walls: WallTable
    body_index: Int32Array | None = None
    previous: Float64Array = field(init=False)
    identity: Int64Array = field(init=False)
    reference: float = field(init=False)
    margin: Float64Array = field(init=False)
    shift: Float64Array = field(init=False)
    anchor: Float64Array = field(init=False)
    begin: Int64Array = field(init=False)
    neighbor: Int32Array = field(init=False)
    lightness: Float64Array = field(init=False)
    owner: Int32Array = field(init=False)
    touching: Int32Array = field(init=False)
    wall_begin: Int64Array = field(init=False)
    wall_item: Int32Array = field(init=False)
    wall_room: Float64Array = field(init=False)
    seam: SeamPairs = field(init=False)
    owners: int = 0

    def __post_init__(self) -> None:
        self.previous = self.ball[: self.moving, :3].copy()
        self.identity = np.arange(self.moving)
        self.neighbor = np.empty(24 * len(self.ball) + 4096, np.int32)
        self.wall_item = np.empty(2 * self.moving + 4096, np.int32)
        self.wall_room = np.empty(len(self.wall_item))
        self.seam = no_pairs()
        self.reference = float(self.ball[: self.moving, 3].mean()) if self.moving else 0.0

    def rebuild(self, skin: float) -> None:
        """Sort the spheres by cell and list their neighbours and walls anew."""
        self._close_ranks()
        self._wrap()
        reach = list_reach(self.ball[:, 3], self.moving, skin, self.reference)
        box, level, reaches, size, cells, first = level_grids(self.ball, reach)
        moving = self.moving
        _, start_moving, order = cell_keys(self.ball, 0, moving, box, level, size, cells, first)
        _, start_fixed, order_fixed = cell_keys(
            self.ball, moving, len(self.ball), box, level, size, cells, first
        )
        out = (
            np.empty_like(self.ball),
            np.empty_like(self.previous),
            np.empty_like(self.identity),
            np.empty_like(level),
        )
        gather(self.ball, self.previous, self.identity, level, order, order_fixed, *out)
        self.ball, self.previous, self.identity, level = out
        self.owners = moving if len(size) == 1 else len(self.ball)
        self.begin = np.empty(self.owners + 1, np.int64)
        reach = list_reach(self.ball[:, 3], self.moving, skin, self.reference)
        self.margin = reach[:moving] - self.ball[:moving, 3]
        while (
            fill_list(
                self.ball, reach, moving, self.owners, box, level, reaches, size, cells, first,
                start_moving, start_fixed, self.begin, self.neighbor,
            )
            < 0
        ):  # fmt: skip
            self.neighbor = np.empty(2 * len(self.neighbor), np.int32)
        if self.walls.seams.wraps:
            self.seam = seam_pairs(self.ball, reach, moving, self.walls.seams)
        self._list_walls()
        self.anchor = self.ball[:moving, :3].copy()
        self.lightness = push_lightness(self.ball[:, 3], moving, self.reference)
        self.owner = np.repeat(np.arange(self.owners, dtype=np.int32), np.diff(self.begin))
        if self.body_index is not None:
            self._leave_out_bodies(self.body_index)
        self.touching = np.empty(len(self.owner) + 1, np.int32)
        self.shift = np.empty((len(self.ball), 3))

    def _leave_out_bodies(self, body_index: Int32Array) -> None:
        """Take the pairs of one body out of the lists: its spheres may overlap each other."""
        other, seam, count = self.neighbor[: len(self.owner)], self.seam, len(self.ball)
        apart = pairs_to_part(self.owner, other, body_index, self.identity, count)
        self.neighbor[: np.count_nonzero(apart)] = other[apart]
        self.owner = self.owner[apart]
        self.begin = np.searchsorted(self.owner, np.arange(self.owners + 1))
        apart = pairs_to_part(seam.first, seam.second, body_index, self.identity, count)
        self.seam = SeamPairs(seam.first[apart], seam.second[apart], seam.offset[apart])

    def _wrap(self) -> None:
        if self.walls.seams.wraps:
            position = self.ball[: self.moving, :3]
            inside = self.walls.seams.wrapped(position)
            self.previous += inside - position
            position[:] = inside

    def _list_walls(self) -> None:
        walls = self.walls
        self.wall_begin = np.empty(self.moving + 1, np.int64)
        while (
            wall_candidates(
                self.ball, self.moving, self.margin, walls.kind, walls.row, walls.map_origin,
                walls.map_size, walls.map_cells, walls.map_start, walls.map_item,
                self.wall_begin, self.wall_item, self.wall_room,
            )
            < 0
        ):  # fmt: skip
            self.wall_item = np.empty(2 * len(self.wall_item), np.int32)
            self.wall_room = np.empty(len(self.wall_item))

    def sweep(self, sink: Float64Array, step: Step) -> tuple[float, int]:
        """Run one sweep; see ``kernels.sweep.sweep``."""
        worst, strays = sweep(
            self.ball, self.previous, self.lightness, self.moving,
            self.owner, self.neighbor, self.touching, self.shift, self.anchor, self.margin,
            self.seam.first, self.seam.second, self.seam.offset,
            self.wall_begin, self.wall_item, self.wall_room, self.walls.kind, self.walls.row, self.identity,
            sink, step.momentum, step.relaxation, step.stride, step.roughness, step.far,
        )  # fmt: skip
        return float(worst), int(strays)

    def overlaps(self, scale: float, down: Float64Array) -> tuple[float, Float64Array]:
        """Return the largest overlap of the true spheres, and the one each moving sphere is blamed for."""
        blame = np.empty(self.moving)
        height = -components(self.ball[: self.moving, :3], down)
        worst = sphere_overlaps(
            self.ball, scale, self.moving, self.owner, self.neighbor,
            self.seam.first, self.seam.second, self.seam.offset,
            self.wall_begin, self.wall_item, self.walls.kind, self.walls.row, height, blame,
        )  # fmt: skip
        return float(worst), blame

    def take_out(self, out: NDArray[np.bool_]) -> None:
        """Take moving spheres out of all contacts."""
        self.ball[: self.moving][out, :3] = np.nan  # nearer than no other, never farther than a margin

    def _close_ranks(self) -> None:
        """Forget the spheres that were taken out."""
        keep = ~np.isnan(self.ball[: self.moving, 0])
        if not keep.all():
            self.ball = np.concatenate([self.ball[: self.moving][keep], self.ball[self.moving :]])
            self.previous = self.previous[keep]
            self.identity = self.identity[keep]
            self.moving = int(keep.sum())

    def positions(self) -> Float64Array:
        """Return the centres of the moving spheres, in the layer's own order [m], shape (moving, 3)."""
        return self.walls.seams.wrapped(self.ball[: self.moving, :3])

    def radii(self) -> Float64Array:
        """Return the arranged radii of the moving spheres, in the layer's own order [m], shape (moving,)."""
        return self.ball[: self.moving, 3]
