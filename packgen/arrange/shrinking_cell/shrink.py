"""One start: random spheres in a random cell, and linear programmes until the cell shrinks no more."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrange.shrinking_cell.lattice import near_pairs, reduced, spacings, volume
from packgen.arrays import Float64Array
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube, cube_root, inverse, matrix_product
from packgen.programmes.solve import NoSolutionError
from packgen.programmes.steps import NO_WALLS, PairRows, Pins, largest_step

TRIES = 200
"""Times that a place is sought for a sphere of a random start."""

SKEW = 0.2
"""Largest change of an entry of a cube's vectors that makes a random cell, in its edges."""

STRAIN_MAX = 0.1
"""Largest entry of the strain of a step."""

GAIN_MAX = 1.0
"""Largest gain of the squares of all radii in a step: a cell shrinks to 0.7 of its lengths at most."""

SMALL = 1.0e-4
"""Gain of the solid fraction below which the next step is half as long."""

DONE, DONE_STEPS = 1.0e-12, 3
"""Gain of the solid fraction that is none, and steps of it after which there are no more."""

STEPS_MAX = 300

SHAKE = 0.3
"""Largest move along an axis with which a cell at rest is shaken, in largest diameters, and twice its strain.

Of 50 starts of four equal spheres 14 % come to rest in a cell that is not the densest, of eight 30 %; shaken
once by this, 2 % and 3 % of 100 (tests/benchmarks/results/shrinking_cell.txt). Smaller shakes lead back to
where they began.
"""

REACH_LAST = 1.0e-12
"""Reach of a step below which nothing is left to gain, in that of the first."""


@dataclass(frozen=True, eq=False, slots=True)
class PeriodicCell:
    """Spheres in a periodic cell.

    Attributes:
        vectors: Vectors of the cell as rows [m], shape (3, 3).
        center: Centres [m], shape (N, 3).
        fraction: Solid fraction.
        steps: Linear programmes that led there.
    """

    vectors: Float64Array
    center: Float64Array
    fraction: float
    steps: int = 0


@dataclass(frozen=True, slots=True)
class Reach:
    """How far steps go.

    Attributes:
        start: Solid fraction of the start.
        influence: Distance of surfaces up to which pairs are kept apart, in largest diameters.
        move: Largest move along an axis of the first step, in largest diameters.
    """

    start: float = 0.1
    influence: float = 1.0
    move: float = 0.3


def random_cell(radius: Float64Array, fraction: float, rng: np.random.Generator) -> PeriodicCell:
    """Return spheres at random places of a random cell, none of which overlap.

    Args:
        radius: Radii [m], shape (N,).
        fraction: Solid fraction; less where no places are found.
        rng: Source of randomness.
    """
    solid = float((UNIT_VOLUME * cube(radius)).sum())
    while True:
        shape = np.eye(3) + SKEW * (2.0 * rng.random((3, 3)) - 1.0)
        cell = reduced(shape * cube_root(solid / fraction / volume(shape)))
        if spacings(cell).min() > 2.0 * radius.max():
            center = _places(radius, cell, rng)
            if center is not None:
                return PeriodicCell(cell, center, solid / volume(cell))
        fraction *= 0.95


def _places(radius: Float64Array, cell: Float64Array, rng: np.random.Generator) -> Float64Array | None:
    """Return a place for each sphere [m], shape (N, 3), large ones first; None: one found none."""
    order = np.argsort(-radius, kind="stable")
    center = np.empty((len(radius), 3))
    for number in range(len(order)):
        some = order[: number + 1]
        for _ in range(TRIES):
            center[some[-1]] = matrix_product(rng.random(3), cell)
            first, _, _ = near_pairs(center[some], radius[some], cell, 0.0)
            if not len(first):
                break
        else:
            return None
    return center


def shrunk(start: PeriodicCell, radius: Float64Array, reach: Reach) -> PeriodicCell:
    """Return the cell that small steps lead to, when none of them makes it smaller any more.

    Args:
        start: The cell; nothing overlaps in it.
        radius: Radii [m], shape (N,).
        reach: How far the first steps go.
    """
    unit = 2.0 * float(radius.max())
    here, share, idle, steps = start, 1.0, 0, 0
    while steps < STEPS_MAX:
        steps += 1
        try:
            there = _step(here, radius, share * reach.move * unit, share, reach.influence * unit)
        except NoSolutionError:
            there = None
        gain = -1.0 if there is None else there.fraction / here.fraction - 1.0
        if there is not None and gain > 0.0:
            here = there
        share *= 0.5 if gain < SMALL else 1.0
        idle = idle + 1 if gain < DONE else 0
        if idle >= DONE_STEPS and (gain > -DONE or share < REACH_LAST):
            break
    return PeriodicCell(here.vectors, here.center, here.fraction, steps)


def shaken(cell: PeriodicCell, radius: Float64Array, rng: np.random.Generator) -> PeriodicCell:
    """Return a cell with its shape and all places changed a little at random, so large that nothing overlaps.

    Args:
        cell: The cell.
        radius: Radii [m], shape (N,).
        rng: Source of randomness.
    """
    change = np.eye(3) + 0.5 * SHAKE * (2.0 * rng.random((3, 3)) - 1.0)
    move = 2.0 * float(radius.max()) * SHAKE * (2.0 * rng.random(cell.center.shape) - 1.0)
    vectors = reduced(matrix_product(cell.vectors, change))
    center = matrix_product(cell.center, change) + move
    factor = largest_factor(center, radius, vectors)
    vectors, center = vectors / factor, center / factor
    return PeriodicCell(vectors, center, cell.fraction * volume(cell.vectors) / volume(vectors))


def _step(
    here: PeriodicCell, radius: Float64Array, move: float, share: float, influence: float
) -> PeriodicCell:
    """Return the cell after a step, so large that nothing overlaps."""
    count = len(radius)
    first, second, way = near_pairs(here.center, radius, here.vectors, influence)
    pairs = PairRows(first, second, way, radius[first] + radius[second])
    pins = Pins(np.zeros(3, np.int64), np.eye(3))
    step = largest_step(count, pairs, NO_WALLS, pins, move, share * STRAIN_MAX, GAIN_MAX)
    strain = np.eye(3) + step.strain
    vectors = reduced(matrix_product(here.vectors, strain))
    place = matrix_product(here.center, inverse(here.vectors))
    center = matrix_product(matrix_product(place - np.floor(place), here.vectors), strain) + step.move
    factor = largest_factor(center, radius, vectors)
    vectors, center = vectors / factor, center / factor
    return PeriodicCell(vectors, center, here.fraction * volume(here.vectors) / volume(vectors))


def largest_factor(center: Float64Array, radius: Float64Array, cell: Float64Array) -> float:
    """Return the largest common factor of the radii at which nothing overlaps."""
    within = float(radius.max())
    while True:
        first, second, way = near_pairs(center, radius, cell, within)
        if len(first):
            factor = float((np.sqrt((way * way).sum(axis=1)) / (radius[first] + radius[second])).min())
            if (factor - 1.0) * 2.0 * radius.max() <= within:
                return factor
        within *= 2.0
