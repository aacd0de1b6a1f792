"""The paper's Algorithm 1, outer loop: batch upon batch, until a zone has its spheres or is full.

Source: "Rapid Random Packing of Poly-disperse Spheres using Adam Stochastic Optimization", Algorithm 1 and
section III-C. Spheres of a batch that fails return to the supply, and the batch size is halved; at size 0 the
zone is full. What the paper leaves open: the start positions of a batch are uniform over the zone's
cross-section in a slab on top of the last layer, as thick as the batch at the solid fraction
``settings.start_fraction``: loose enough to settle freely, thin enough not to fall for long. Where the slab
would rise above the zone it is cut there, but never to less than one diameter: the last spheres then start in
between the tops of the bed. Spheres that were there before the zone take their room from the slab, which
begins at the lowest level that has any left: a zone may lie above, below, beside or around an earlier one.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import numpy as np
import torch
from torch import Tensor

from packgen.arrange.adam.batch import AdamSettings, BatchResult, arrange_batch, batch_accepted
from packgen.arrange.adam.objective import Walls
from packgen.arrays import BoolArray, Float64Array, Int32Array
from packgen.supply.supply import Draw, Supply

FREE_MIN = 0.1  # share of a zone's cross-section, clear of earlier spheres, that a batch needs to start
SLAB_STEPS = 16  # steps, about, that add up the room of a slab

SampleAbove = Callable[[np.random.Generator, int, float, float], Float64Array]
Finish = Callable[[Tensor, Tensor, Tensor, Tensor], tuple[Tensor, Tensor]]


@dataclasses.dataclass(frozen=True, slots=True)
class ZoneSpace:
    """Where a zone's spheres may start, in altitudes: distances against ``down`` from the origin.

    Attributes:
        floor: Altitude of the zone's lowest point [m].
        ceiling: Altitude of its highest point [m].
        area: Returns the zone's horizontal area [m2] at an altitude [m].
        free: Returns the share of that area, 0 to 1, where a centre is clear of the earlier spheres.
        sample_above: ``(rng, count, height, thickness) -> (count, 3)`` centres [m], uniform in the free part
            of the zone with altitudes from ``height`` to ``height + thickness``, within floor and ceiling.
    """

    floor: float
    ceiling: float
    area: Callable[[float], float]
    free: Callable[[float], float]
    sample_above: SampleAbove


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class Surroundings:
    """What a zone's spheres meet.

    Attributes:
        walls: What bounds them.
        space: Where they may start.
        down: Unit vector that points where things fall, shape (3,), float64; its device is used.
        position: Centres of the spheres that are there already [m], shape (f, 3), float64.
        radius: Their radii [m], shape (f,), float64.
    """

    walls: Walls
    space: ZoneSpace
    down: Tensor
    position: Tensor
    radius: Tensor


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class BatchProgress:
    """The outcome of a batch: its size, whether it was accepted, the spheres placed so far, the details."""

    batch_size: int
    accepted: bool
    placed: int
    thrown_back: int
    top: float
    result: BatchResult


@dataclasses.dataclass(frozen=True, eq=False, slots=True)
class AdamZone:
    """The spheres placed in a zone.

    Attributes:
        position: Centres [m], shape (N, 3), float64.
        radius: Radii [m], shape (N,), float64.
        set_index: Particle set of each sphere, shape (N,), int32.
        batch_index: Accepted batch that each sphere came with, from 0, shape (N,), int32.
        thrown_back: How often a sphere was returned to the supply, in failed batches or by the end game.
    """

    position: Float64Array
    radius: Float64Array
    set_index: Int32Array
    batch_index: Int32Array
    thrown_back: int


def pack_zone_adam(
    supply: Supply,
    around: Surroundings,
    settings: AdamSettings,
    rng: np.random.Generator,
    *,
    finish: Finish | None = None,
    on_progress: Callable[[BatchProgress], None] | None = None,
    on_step: Callable[[int, float, float], None] | None = None,
    threads: int = 1,
    all_pairs: bool = False,
) -> AdamZone:
    """Fill a zone from a supply of spheres: Algorithm 1.

    Args:
        supply: The spheres to place; those that find no place go back to it.
        around: What they meet.
        settings: Settings of the algorithm.
        rng: Draws the start positions.
        finish: ``(position, radius, fixed_position, fixed_radius) -> (kept (n,) bool, position (n, 3))``:
            ends an accepted batch and says which spheres stay. None: all do, as Adam left them.
        on_progress: Called after each batch.
        on_step: Called after each step with its number, the objective and the learning rate.
        threads: Threads for torch: the tensors of a batch are small, one is fastest.
        all_pairs: Evaluate eq. 5 over all pairs, as printed.
    """
    walls, space, down = around.walls, around.space, around.down
    arrange = partial(
        arrange_batch, walls=walls, down=down, settings=settings, on_step=on_step, all_pairs=all_pairs
    )
    bed = _Bed(around.position, around.radius, down)
    batch_size, thrown_back, batch_index = settings.batch_size, 0, 0
    with torch_threads(threads), torch.no_grad():
        while not supply.finished and batch_size > 0:
            draw = supply.take(batch_size)
            radius = torch.from_numpy(np.array(draw.radius, dtype=np.float64)).to(down.device)
            if not len(radius):
                break
            slab = _slab(radius, bed.top, space, settings)
            if slab is None:
                supply.put_back(draw)
                break
            start = _start_positions(len(radius), slab, space, rng, down.device)
            fixed = bed.spheres
            result = arrange(start, radius, *fixed)
            kept = torch.full((len(radius),), batch_accepted(result, settings), device=down.device)
            position = result.position
            if finish is not None and bool(kept.any()):
                kept, position = finish(position, radius, *fixed)
            back = ~kept.cpu().numpy()
            if back.any():
                supply.put_back(_part(draw, back))
            if back.all():
                batch_size = len(radius) // 2
            else:
                bed.add(position[kept], radius[kept], draw.set_index[~back], batch_index)
                batch_index += 1
            thrown_back += int(back.sum())
            if on_progress is not None:
                progress = BatchProgress(
                    len(radius), not bool(back.all()), bed.placed, thrown_back, bed.top, result
                )
                on_progress(progress)
    return bed.zone(thrown_back)


@contextmanager
def torch_threads(count: int) -> Iterator[None]:
    """Let torch use ``count`` threads within the block."""
    before = torch.get_num_threads()
    torch.set_num_threads(count)
    try:
        yield
    finally:
        torch.set_num_threads(before)


class _Bed:
    """The fixed spheres: those that were there, and the accepted batches.

    Attributes:
        spheres: Centres [m], shape (f, 3), and radii [m], shape (f,).
        top: Altitude of the highest point of the batches (the paper's max(C' + r')) [m].
    """

    def __init__(self, position: Tensor, radius: Tensor, down: Tensor) -> None:
        self.spheres = position, radius
        self.top = -math.inf
        self._down = down
        self._before = len(radius)
        self._set_index: list[Int32Array] = []
        self._batch_index: list[Int32Array] = []

    @property
    def placed(self) -> int:
        return len(self.spheres[1]) - self._before

    def add(self, position: Tensor, radius: Tensor, set_index: Int32Array, batch_index: int) -> None:
        self.spheres = torch.cat((self.spheres[0], position)), torch.cat((self.spheres[1], radius))
        self._set_index.append(set_index)
        self._batch_index.append(np.full(len(radius), batch_index, dtype=np.int32))
        self.top = max(self.top, float((radius - (position * self._down).sum(dim=1)).max()))

    def zone(self, thrown_back: int) -> AdamZone:
        position, radius = (values[self._before :].cpu().numpy() for values in self.spheres)
        nothing = [np.empty(0, dtype=np.int32)]
        set_index = np.concatenate(self._set_index or nothing)
        batch_index = np.concatenate(self._batch_index or nothing)
        return AdamZone(position, radius, set_index, batch_index, thrown_back)


def _slab(radius: Tensor, top: float, space: ZoneSpace, settings: AdamSettings) -> tuple[float, float] | None:
    """Return altitude and thickness [m] of the slab that a batch starts in; None: there is no room left.

    It is as thick as the batch at ``settings.start_fraction`` of what is free, added up step by step.
    """
    largest = float(radius.max())
    highest = max(space.ceiling - 2.0 * largest, space.floor)
    height = min(max(top, space.floor), highest)
    while space.free(height) < FREE_MIN:
        if height == highest:
            return None
        height = min(height + largest, highest)
    room = 4.0 / 3.0 * math.pi * float((radius * radius * radius).sum()) / settings.start_fraction
    # The tip of a hopper has hardly any area: its slab must not become as high as the hopper.
    step = max(largest, min(room / space.area(height), space.ceiling - height) / SLAB_STEPS)
    thickness = 0.0
    while room > 0.0 and height + thickness < space.ceiling:
        altitude = min(height + thickness, space.ceiling - largest)
        slice_room = step * space.area(altitude) * space.free(altitude)
        thickness += step * min(room / max(slice_room, 1e-300), 1.0)
        room -= slice_room
    return height, min(max(thickness, 2.0 * largest), space.ceiling - height)


def _start_positions(
    count: int, slab: tuple[float, float], space: ZoneSpace, rng: np.random.Generator, device: torch.device
) -> Tensor:
    """Return random centres in a slab [m], shape (count, 3), float64."""
    start = space.sample_above(rng, count, *slab)
    return torch.from_numpy(np.ascontiguousarray(start, dtype=np.float64)).to(device)


def _part(draw: Draw, chosen: BoolArray) -> Draw:
    return dataclasses.replace(draw, radius=draw.radius[chosen], set_index=draw.set_index[chosen])
