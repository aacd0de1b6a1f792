"""From random points to a bed on the verge of being jammed: quenched, and let expand stage by stage.

The walls stay where they are, and all radii have one common factor: that is the same as radii that stay and
walls that move, and needs no new map of the walls. Spheres that are pressed harder than they can bear come to
rest with overlaps; their pressure falls in proportion to what the solid fraction has above that of jamming,
which two stages tell.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from packgen.arrange.jammed.push_kernels import Soft
from packgen.arrange.jammed.quench_kernels import MIXING, STEP_FIRST, quench
from packgen.arrange.jammed.swap_kernels import exchange
from packgen.arrange.space.region import Region
from packgen.arrays import Float64Array
from packgen.compiled import signals_heard
from packgen.portable import cube_root

STEPS_MAX = 100_000
"""Steps of one stage at most."""

RUN, RUN_LEAST = 10_000_000, 50
"""Spheres times steps of one run of the compiled loop, and least steps: a signal waits for its end."""

STAGES_MAX = 80

SLOPE = 0.7
"""Pressure over the relative excess of the solid fraction, of equal spheres, for a first guess."""

SWAP_ROUNDS, SWAP_STEPS = 120, 40
"""Times that spheres may change places, and steps in between."""

PRESSED, DENSER = 0.02, 1.002
"""Pressure of spheres that change places, and the factor on the solid fraction where it is less."""

FREE = 1.0e-2
"""Overlaps of spheres that press nothing, in those at the end."""


@dataclass(frozen=True, slots=True)
class Care:
    """How closely a bed is to come to the verge of being jammed.

    Attributes:
        fine: Largest overlap at the end, as a fraction of the smaller radius.
        calm: Residual at which a stage ends: root mean square force upon a sphere over that at a contact.
        kept: Share of what the solid fraction has above that of jamming that a stage keeps.
        tighter: Factor on the solid fraction where the spheres are not pressed at all.
    """

    fine: float
    calm: float
    kept: float
    tighter: float


FIRST = Care(5.0e-3, 1.0e-2, 0.3, 1.02)
"""As closely as the careful stages need it."""

COARSE = Care(1.0e-3, 1.0e-2, 0.3, 1.02)
"""As closely as is quick."""

CLOSE = Care(1.0e-7, 1.0e-4, 0.1, 1.002)
"""So closely that a linear programme finds hardly anything to move: soft modes are followed to their ends."""


@dataclass(frozen=True, slots=True)
class Rest:
    """Spheres at rest.

    Attributes:
        grown: Cube of the common factor of the radii.
        residual: Root mean square force upon a sphere over that at a contact.
        pressure: Mean over the spheres of the relative overlaps of their contacts.
        worst: Largest overlap, as a fraction of the smaller radius.
        steps: Steps that they took.
    """

    grown: float
    residual: float
    pressure: float
    worst: float
    steps: int


class SoftBed:
    """Soft spheres in a region.

    Attributes:
        region: The region.
        radius: Radii as given [m], shape (N,).
        steps: Steps done so far.
    """

    def __init__(self, region: Region, center: Float64Array, radius: Float64Array) -> None:
        self.region, self.radius, self.steps = region, radius, 0
        center = np.array(center, np.float64, order="C")
        self._sorted = Soft(
            center, np.zeros_like(center), np.array(radius, np.float64), np.arange(len(radius))
        )

    @property
    def center(self) -> Float64Array:
        """Centres in the order of the radii [m], shape (N, 3)."""
        center = np.empty_like(self._sorted.center)
        center[self._sorted.identity] = self._sorted.center
        return center

    def exchange(self, grown: float, chance: Float64Array) -> int:
        """Let spheres change places; return how many pairs did. See ``swap_kernels.exchange``."""
        with signals_heard():
            changes: int = exchange(self._sorted, self.region.walls, cube_root(grown), chance)
        return changes

    def settle(self, grown: float, calm: float, free: float, steps_max: int = STEPS_MAX) -> Rest:
        """Let the spheres come to rest.

        Args:
            grown: Cube of the common factor of their radii.
            calm: Residual at which they are at rest.
            free: Largest overlap of spheres that press nothing.
            steps_max: Steps at most.
        """
        self._sorted.velocity[:] = 0.0
        pace = np.array([STEP_FIRST, MIXING, 0.0])
        most = max(RUN // len(self.radius), RUN_LEAST)
        done, residual, pressure, worst = 0, 1.0, 0.0, 0.0
        while done < steps_max and residual > calm:
            with signals_heard():
                steps, residual, pressure, worst = quench(
                    self._sorted, self.region.walls, cube_root(grown), pace,
                    min(most, steps_max - done), calm, free,
                )  # fmt: skip
            done += steps
        self.steps += done
        return Rest(grown, residual, pressure, worst, done)


def swapped(bed: SoftBed, grown: float, rng: np.random.Generator, tell: Callable[[float], None]) -> float:
    """Let spheres of a bed change places again and again, denser each time where they are pressed less.

    Args:
        bed: The bed; changes.
        grown: Cube of the common factor of its radii.
        rng: Source of randomness.
        tell: Called after each round with the share of all that is done.

    Returns:
        The cube of their factor at the end.
    """
    start = bed.settle(grown, COARSE.calm, FREE * COARSE.fine).pressure
    for number in range(SWAP_ROUNDS):
        bed.exchange(grown, rng.random((len(bed.radius), 2)))
        rest = bed.settle(grown, COARSE.calm, FREE * COARSE.fine, SWAP_STEPS)
        if rest.pressure < max(start, PRESSED):
            grown *= DENSER
        tell((number + 1) / SWAP_ROUNDS)
    return grown


def decompress(bed: SoftBed, grown: float, tell: Callable[[Rest], None], care: Care) -> Rest:
    """Let a bed come to rest again and again, less pressed each time, until it is hardly jammed.

    Args:
        bed: The bed; changes.
        grown: Cube of the common factor of its radii at the start.
        tell: Called after each stage.
        care: How closely.

    Returns:
        The last stage: pressed, with overlaps up to ``care.fine``.
    """
    before: Rest | None = None
    for _ in range(STAGES_MAX):
        rest = bed.settle(grown, care.calm, FREE * care.fine)
        tell(rest)
        if rest.pressure == 0.0:
            # Not jammed: back halfway to where it was, or, as they have moved since, on to where it may be.
            grown = care.tighter * grown if before is None else 0.5 * (grown + before.grown)
            before = None
            continue
        if rest.worst <= care.fine:
            break
        jammed = _jammed_at(rest, before)
        grown, before = jammed + care.kept * (grown - jammed), rest
    return rest


def _jammed_at(rest: Rest, before: Rest | None) -> float:
    """Return where the pressure will have fallen to nothing, as the cube of the radii's factor."""
    guess = rest.grown * max(1.0 - rest.pressure / SLOPE, 0.5)
    if before is None or not before.pressure > rest.pressure:
        return guess
    fall = (before.pressure - rest.pressure) / (before.grown - rest.grown)
    jammed = rest.grown - rest.pressure / fall
    return jammed if 0.5 * rest.grown < jammed < rest.grown else guess
