"""A zone that is being filled: its space, the spheres to come, and those at rest."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from packgen.arrange.pile import Pile
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.projection.settle import SettleStats, settle
from packgen.arrange.space.region import Region
from packgen.arrange.spheres import Spheres
from packgen.arrays import BoolArray, Float64Array
from packgen.supply.supply import Draw, Supply


class LayerReport(Protocol):
    """Called after each layer: batch number, spheres placed, altitude of the surface [m], thrown back."""

    def __call__(self, batch: int, placed: int, level: float, thrown_back: int) -> None:
        """Take notice."""


def no_report(batch: int, placed: int, level: float, thrown_back: int) -> None:
    """Take no notice."""


@dataclass(slots=True)
class OpenZone:
    """A zone and its spheres while it is filled.

    Attributes:
        index: Number of the zone.
        region: Its space.
        supply: The spheres to place; those that find no place go back to it.
        pile: All spheres placed so far, those of earlier zones included; grows.
        rng: Draws the start positions.
        device: Where the sweeps run; see ``projection.settle``.
        threads: Threads of the sweeps at most.
        stats: Counters of the layers' work.
    """

    index: int
    region: Region
    supply: Supply
    pile: Pile
    rng: np.random.Generator
    device: str = "cpu"
    threads: int = 1
    stats: SettleStats = field(default_factory=SettleStats)

    def newcomers(self, start: Float64Array, draw: Draw, batch: int) -> Spheres:
        """Return spheres of this zone at their start positions [m], shape (n, 3)."""
        count = len(draw.radius)
        zone, batches = np.full(count, self.index, np.int32), np.full(count, batch, np.int32)
        return Spheres(start, draw.radius, draw.set_index, zone, batches, draw.body_index)

    def settled(self, moving: Spheres, fixed: Spheres, recipe: Recipe) -> tuple[Float64Array, BoolArray]:
        """Arrange spheres among fixed ones; see ``settled_in``."""
        return settled_in(
            self.region, moving, fixed, recipe, stats=self.stats, device=self.device, threads=self.threads
        )

    def put_back(self, spheres: Spheres) -> None:
        """Return spheres that found no place to the supply."""
        if len(spheres):
            self.supply.put_back(Draw(spheres.radius, spheres.set_index, spheres.body_index))


def settled_in(
    region: Region,
    moving: Spheres,
    fixed: Spheres,
    recipe: Recipe,
    *,
    stats: SettleStats | None = None,
    device: str = "cpu",
    threads: int = 1,
) -> tuple[Float64Array, BoolArray]:
    """Arrange spheres among fixed ones in a region; see ``projection.settle``.

    Returns:
        (centres [m], shape (n, 3); which of them found a place, shape (n,)).
    """
    ball = np.empty((len(moving) + len(fixed), 4))
    ball[: len(moving), :3], ball[len(moving) :, :3] = moving.position, fixed.position
    ball[: len(moving), 3], ball[len(moving) :, 3] = moving.radius, fixed.radius
    position, kept = settle(
        ball, len(moving), region.walls, region.down, recipe, stats, device=device,
        body_index=moving.body_index, threads=threads,
    )  # fmt: skip
    if recipe.tolerance is None:
        # Nothing has judged the overlaps with walls: a sphere may have been pushed right through one.
        return position, kept & region.contains(position, moving.radius)
    return position, kept & region.holds(position)
