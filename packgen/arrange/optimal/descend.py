"""Linear programmes that move spheres in a room so that their radii can be largest, until none moves them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrange.optimal.room import Room
from packgen.arrays import Float64Array, Int64Array
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube, cube_root
from packgen.programmes.solve import NoSolutionError
from packgen.programmes.steps import PairRows, Pins, WallRows, largest_step

LOOSE = 0.2
"""Solid fraction at which spheres are far from touching: the first steps are as long as it tells."""

REACH = 0.3
"""Largest move along an axis of the first step, in largest diameters at that fraction."""

INFLUENCE = 1.2
"""Distance of surfaces up to which pairs are rows, in those diameters."""

SMALL = 1.0e-4
"""Gain of the radii below which the next step is half as long."""

DONE, DONE_STEPS = 1.0e-12, 3
"""Gain of the radii that is none, and steps of it after which there are no more."""

STEPS_MAX = 200

HOPE = 3.0
"""Gain that all later steps may bring together, in that of the last one: they shrink fast."""

TOUCHING = 1.0e-8
"""Largest gap of a contact, in radii."""


@dataclass(frozen=True, eq=False, slots=True)
class Placed:
    """Spheres in a room.

    Attributes:
        center: Centres [m], shape (N, 3).
        factor: Largest common factor of the radii at which nothing overlaps.
        programmes: Linear programmes that led there.
    """

    center: Float64Array
    factor: float
    programmes: int = 0


def loose_factor(room: Room, radius: Float64Array) -> float:
    """Return the factor of the radii at which spheres fill a small part of a room."""
    return float(cube_root(LOOSE * room.volume / float((UNIT_VOLUME * cube(radius)).sum())))


def descend(
    room: Room, radius: Float64Array, center: Float64Array, share: float = 1.0, wanted: float = 0.0
) -> Placed:
    """Return where steps lead from some places, when no small one lets the radii grow any more.

    Args:
        room: The room.
        radius: Radii [m], shape (N,).
        center: Centres, inside [m], shape (N, 3); spheres may overlap.
        share: Length of the first step, in the longest one.
        wanted: Factor of the radii that is to be exceeded: what will hardly come near it is not followed.
    """
    loose = loose_factor(room, radius)
    unit = 2.0 * loose * float(radius.max())
    here = Placed(center, largest_factor(room, radius, center))
    idle, steps = 0, 0
    while steps < STEPS_MAX:
        steps += 1
        try:
            there = _step(room, radius, here, max(here.factor, 0.5 * loose), share * REACH * unit, unit)
        except NoSolutionError:
            break
        gain = there.factor / here.factor - 1.0 if here.factor > 0.0 else np.inf
        if gain > 0.0:
            here = there
        elif steps == 1 and here.factor < 0.5 * loose:
            here = there  # out of places that overlap any way leads on
        share *= 0.5 if gain < SMALL else 1.0
        idle = idle + 1 if gain < DONE else 0
        hopeless = steps > 1 and here.factor * (1.0 + HOPE * max(gain, 0.0)) < wanted
        if idle >= DONE_STEPS or hopeless:
            break
    return Placed(here.center, here.factor, steps)


def _step(room: Room, radius: Float64Array, here: Placed, factor: float, reach: float, unit: float) -> Placed:
    center = here.center
    way = center[:, None] - center[None]
    distance = np.sqrt((way * way).sum(axis=2))
    apart = factor * (radius[:, None] + radius)
    first, second = np.nonzero(np.triu(distance - apart < INFLUENCE * unit, 1))
    pairs = PairRows(first, second, way[first, second], apart[first, second])
    gap = room.distances(center) - factor * radius[:, None]
    sphere, wall = np.nonzero(gap < INFLUENCE * unit)
    normal = room.inward(center)[sphere, wall]
    walls = WallRows(sphere, gap[sphere, wall], normal, factor * radius[sphere])
    step = largest_step(len(radius), pairs, walls, NO_PINS, reach, gain_max=GAIN_MAX)
    moved = center + step.move
    return Placed(moved, largest_factor(room, radius, moved))


NO_PINS = Pins(np.empty(0, np.int64), np.empty((0, 3)))
GAIN_MAX = 2.0
"""Largest gain of the squares of all radii in a step: rows are listed as far as that reaches, about."""


def largest_factor(room: Room, radius: Float64Array, center: Float64Array) -> float:
    """Return the largest common factor of the radii at which nothing overlaps; 0 with a centre outside."""
    by_walls = float((room.distances(center).min(axis=1) / radius).min())
    first, second = np.triu_indices(len(radius), 1)
    way = center[first] - center[second]
    by_pairs = np.sqrt((way * way).sum(axis=1)) / (radius[first] + radius[second])
    return max(min(by_walls, float(by_pairs.min(initial=np.inf))), 0.0)


def contact_counts(room: Room, radius: Float64Array, placed: Placed) -> Int64Array:
    """Return the number of contacts of each sphere, walls included, shape (N,)."""
    own = placed.factor * radius
    way = placed.center[:, None] - placed.center[None]
    gap = np.sqrt((way * way).sum(axis=2)) - own[:, None] - own
    np.fill_diagonal(gap, np.inf)
    limit = TOUCHING * float(own.mean())
    at_walls = room.distances(placed.center) - own[:, None] <= limit
    return np.asarray((gap <= limit).sum(axis=1) + at_walls.sum(axis=1))
