"""The measures of a bed in pieces that can be summed over them, and those of parts that fit in memory.

Sums are those of the bed in one piece, to rounding. What hangs on the whole bed at once is left out: which
spheres are loose once others are taken away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.bedfile import Columns
from packgen.check import wall_clearance
from packgen.measure.close_packing import ClosePacking, beside_close_packing
from packgen.measure.contacts import ContactCounter, Contacts, Gaps
from packgen.measure.coordination import Coordination, CoordinationCounter
from packgen.measure.core import Core, center_step, core_between_walls
from packgen.measure.correlation import CorrelationShells, PairCorrelation, correlation_shells
from packgen.measure.forces import ForceCounter, PredictedForces
from packgen.measure.fraction import SolidFraction, solid_volume
from packgen.measure.hertz import STANDARD_GRAVITY
from packgen.measure.order import WALL_REACH, LocalOrder, OrderCounter
from packgen.measure.profile import HeightProfile, profile_of, slab_bounds, solid_below
from packgen.measure.radial import RadialProfile, shells_of
from packgen.measure.roundness import round_part
from packgen.measure.standing import (
    BLOCK_SIZE,
    GAP,
    WHOLE_MAX,
    Standing,
    block_centres,
    can_be_judged,
    sample_step,
    stands_by,
)
from packgen.measure.volumes import container_volume_below, volume_below
from packgen.part import Part
from packgen.pieces.bed import PieceBed
from packgen.pieces.survey import Survey
from packgen.supply.close_packing import close_packing_fraction

LEFT_OUT = ("coordination.rattlers", "coordination.plateau_held")


@dataclass(frozen=True, eq=False, slots=True)
class Found:
    """What is measured; see `packgen.report.Measures`."""

    solid_fraction: SolidFraction
    close_packing: ClosePacking | None
    contacts: tuple[Contacts, ...]
    gaps: Gaps
    coordination: Coordination | None
    profile: HeightProfile
    radial: RadialProfile | None
    pair_correlation: PairCorrelation | None
    order: LocalOrder
    step_zero: PredictedForces | None
    stands_at_friction: Standing | None


def measured(bed: PieceBed, known: Survey, up: Float64Array, *, overlaps: bool) -> Found:
    """Measure a bed in pieces.

    Args:
        bed: The bed.
        known: What the survey has found.
        up: Unit vector against gravity, shape (3,).
        overlaps: Whether the check has found any overlap, of spheres or with a wall.
    """
    centers = bed.every(center_step(bed.count)).position
    core = core_between_walls(bed.container, up, known.top, known.diameter, np.asarray(centers))
    sums = _Sums(bed, known, up, core)
    reach = max(bed.census.radius_max) * OrderCounter.REACH
    for part in bed.parts(reach):
        sums.add(part)
    solid = sums.solid_fraction()
    classes = known.all_classes
    fraction = close_packing_fraction(classes.radius, classes.number.astype(np.float64))
    packing = None
    if solid.filled_volume > 0.0:
        packing = beside_close_packing(bed, solid, fraction, known.diameter)
    contacts, gaps = sums.contacts.result()
    return Found(
        solid, packing, contacts, gaps, sums.coordination.result(), sums.profile(), sums.radial(),
        _pair_correlation(bed, sums), sums.order.result(), _step_zero(bed, overlaps=overlaps), _standing(bed),
    )  # fmt: skip


class _Sums:
    """What is added up part by part."""

    def __init__(self, bed: PieceBed, known: Survey, up: Float64Array, core: Core | None) -> None:
        self.bed, self.known, self.up, self.core = bed, known, up, core
        self.contacts, self.coordination, self.order = (
            ContactCounter(), CoordinationCounter(), OrderCounter(core)
        )  # fmt: skip
        self.core_count, self.core_powers = 0, np.zeros(2)
        self._below_top = self._in_core = 0.0
        low = float((bed.container.surface.vertices @ up).min())
        self._levels = slab_bounds(low, known.highest, known.diameter)
        self._solid = np.zeros(len(self._levels))
        part = round_part(bed.container, up)
        self._shells = None if part is None else shells_of(bed.container, part, known.diameter, known.top)
        self._in_shells: Float64Array | float = 0.0

    def add(self, part: Part) -> None:
        """Add a part with all that is around it."""
        bed, own = part.bed, slice(part.own)
        position, radius = bed.position[own], bed.radius[own]
        clearance = wall_clearance(bed.container, position, WALL_REACH * radius)
        self.contacts.add(part, clearance)
        self.coordination.add(part, clearance)
        self.order.add(part, clearance)
        height = position @ self.up
        self._below_top += float(volume_below(height, radius, self.known.top).sum())
        self._solid += solid_below(height, radius, self._levels)
        if self.core is not None:
            self._in_core += solid_volume(position, radius, self.core)
            inside = radius[self.core.contains(position)]
            self.core_count += len(inside)
            self.core_powers += (inside**3).sum(), (inside**4).sum()
        if self._shells is not None:
            self._in_shells = self._in_shells + self._shells.solid(position, radius)

    def solid_fraction(self) -> SolidFraction:
        """Return the solid fractions of the filled volume and of the core."""
        top, core = self.known.top, self.core
        filled_volume = float(container_volume_below(self.bed.container, self.up, np.array([top]))[0])
        return SolidFraction(
            top=top,
            filled_volume=filled_volume,
            filled=self._below_top / filled_volume if filled_volume > 0.0 else 0.0,
            core=self._in_core / core.volume if core else None,
            core_volume=core.volume if core else None,
            core_rule=core.rule if core else "the bed is too small for a core",
        )

    def profile(self) -> HeightProfile:
        """Return the solid fraction along the height."""
        return profile_of(self.bed.container, self.up, self._levels, self._solid)

    def radial(self) -> RadialProfile | None:
        """Return the porosity over the distance from the wall."""
        return None if self._shells is None else self._shells.profile(np.asarray(self._in_shells))


def _pair_correlation(bed: PieceBed, sums: _Sums) -> PairCorrelation | None:
    """Return g(r) of the core, around the same spheres as in one piece."""
    core, count = sums.core, sums.core_count
    if core is None or count == 0:
        return None
    shells = correlation_shells(core, count, 2.0 * float(sums.core_powers[1] / sums.core_powers[0]))
    if shells is None:
        return None
    weighed, rank = np.zeros(len(shells.middle)), 0
    half = np.abs(core.axes.T) @ core.half
    low, high = core.center - half, core.center + half
    for piece in bed.pieces:
        if (np.array(piece.low) > high).any() or (np.array(piece.high) < low).any():
            continue
        part = bed.part(piece, float(shells.edge[-1]))
        inside = core.contains(part.bed.position)
        own = int(np.count_nonzero(inside[: part.own]))
        local = (part.bed.position[inside] - core.center) @ core.axes.T
        weighed += _weighed(shells, local, np.arange(-rank % shells.every, own, shells.every))
        rank += own
    return shells.correlation(weighed)


def _weighed(shells: CorrelationShells, local: Float64Array, chosen: np.ndarray) -> Float64Array:
    return shells.weighed(local, chosen) if len(chosen) else np.zeros(len(shells.middle))


def _step_zero(bed: PieceBed, *, overlaps: bool) -> PredictedForces | None:
    """Return the predicted forces; where the check found no overlap at all, there are none."""
    if not (bed.gravity.any() and bed.materials and bed.weights_known):
        return None
    cubes = zip(bed.particle_sets, bed.census.cube_sum, strict=True)
    mass = 4.0 / 3.0 * np.pi * sum(each.density * float(cube) for each, cube in cubes)
    counter = ForceCounter(mass / bed.count * (float(np.linalg.norm(bed.gravity)) or STANDARD_GRAVITY))
    if overlaps:
        for part in bed.parts(2.0 * max(bed.census.radius_max)):
            counter.add(part)
    return counter.result()


def _standing(bed: PieceBed) -> Standing | None:
    """Return whether the bed stands, by the same blocks as in one piece."""
    if not can_be_judged(bed):
        return None
    if bed.count <= WHOLE_MAX:
        return stands_by(bed.every(1), GAP, None)
    some = bed.every(sample_step(bed.count))
    centres = block_centres(some.position, some.radius, bed.down)
    blocks = [_around(bed, *_nearest(bed, each)) for each in centres]
    number, first = np.unique(np.concatenate([each.number for each in blocks]), return_index=True)
    around = bed.bed_of([each.columns for each in blocks], first)
    chosen = np.concatenate([each.chosen for each in blocks])
    return stands_by(around, GAP, np.isin(number, chosen))


@dataclass(frozen=True, eq=False, slots=True)
class _Block:
    """The numbers of chosen spheres, and numbers and columns of all that may touch them."""

    chosen: Int64Array
    number: Int64Array
    columns: Columns


def _around(bed: PieceBed, chosen: Int64Array, position: Float64Array) -> _Block:
    """Return a block by its spheres' numbers (n,) and centres [m], (n, 3)."""
    reach = 2.0 * (1.0 + GAP) * max(bed.census.radius_max)
    columns, number = bed.in_box(position.min(axis=0) - reach, position.max(axis=0) + reach)
    return _Block(chosen, number, columns)


def _nearest(bed: PieceBed, centre: Float64Array) -> tuple[Int64Array, Float64Array]:
    """Return numbers and centres of the spheres nearest to a point by the largest coordinate."""
    size = min(BLOCK_SIZE, bed.count)
    best, number, position = np.zeros(0), np.zeros(0, np.int64), np.zeros((0, 3))
    for piece in sorted(bed.pieces, key=lambda each: _apart(each.low, each.high, centre)):
        if len(best) == size and _apart(piece.low, piece.high, centre) > best.max():
            break
        [(start, chunk)] = bed.some([piece])
        position = np.concatenate([position, chunk.position])
        number = np.append(number, start + np.arange(chunk.count))
        best = np.abs(position - centre).max(axis=1)
        kept = np.lexsort((number, best))[:size]
        best, number, position = best[kept], number[kept], position[kept]
    return number, position


def _apart(low: tuple[float, ...], high: tuple[float, ...], centre: Float64Array) -> float:
    """Return how far a box is from a point by the largest coordinate [m]; 0 inside."""
    return float(np.maximum(np.maximum(np.array(low) - centre, centre - np.array(high)), 0.0).max())
