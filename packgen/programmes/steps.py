"""The largest step that spheres can take without overlaps, all radii growing by one factor.

Two centres r apart that move by u and v stay apart by their sum of radii s, grown to s sqrt(G), where
|r|^2 + 2 r (u - v) >= G s^2: what is left out, |u - v|^2, only parts them further, so that no step that a
programme finds makes an overlap of a pair (Torquato and Jiao, Phys. Rev. E 82 (2010) 061302; Artiaco and
others, SciPost Phys. Codebases 8 (2022), with the cell fixed). A wall is a plane across the way to it, and
sqrt(G) at most (1 + G) / 2. The largest G is found; the duals of the rows are then the forces that balance on
each sphere, and those of all rows that bear none are 0.

A cell may also change its shape: six strains that keep its volume act upon all separations.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array, csr_array

from packgen.arrays import Float64Array, Int64Array
from packgen.programmes.solve import Programme, solve

STRAINS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
"""Entries of the symmetric tensor of strain, column by column."""


@dataclass(frozen=True, eq=False, slots=True)
class PairRows:
    """Pairs of spheres that might come to overlap.

    Attributes:
        first: One sphere, shape (P,), int64.
        second: The other one, shape (P,), int64.
        separation: From the second to the first, or between images of them [m], shape (P, 3).
        apart: Their least distance [m], shape (P,): the sum of their radii.
    """

    first: Int64Array
    second: Int64Array
    separation: Float64Array
    apart: Float64Array


@dataclass(frozen=True, eq=False, slots=True)
class WallRows:
    """Walls that spheres might come to touch.

    Attributes:
        sphere: The sphere, shape (W,), int64.
        gap: Distance from its surface [m], shape (W,).
        normal: Unit vector along which the gap grows, shape (W, 3).
        radius: Radius of the sphere [m], shape (W,).
    """

    sphere: Int64Array
    gap: Float64Array
    normal: Float64Array
    radius: Float64Array


NO_WALLS = WallRows(np.empty(0, np.int64), np.empty(0), np.empty((0, 3)), np.empty(0))
"""Of spheres that no wall bounds."""


@dataclass(frozen=True, eq=False, slots=True)
class Pins:
    """Directions in which spheres must not move: what can move as a whole has no place of its own.

    Attributes:
        sphere: The sphere of each, shape (K,), int64.
        direction: Shape (K, 3).
    """

    sphere: Int64Array
    direction: Float64Array


@dataclass(frozen=True, eq=False, slots=True)
class Step:
    """What spheres can do.

    Attributes:
        move: Displacement of each sphere [m], shape (N, 3).
        gain: What the squares of all radii gain, as a fraction: G - 1.
        strain: Strain of the cell, shape (3, 3); zero where it keeps its shape.
        pair_force: Force along each pair row, shape (P,), at least 0; one unit for all forces.
        wall_force: Force of each wall row, shape (W,).
    """

    move: Float64Array
    gain: float
    strain: Float64Array
    pair_force: Float64Array
    wall_force: Float64Array


def largest_step(
    count: int,
    pairs: PairRows,
    walls: WallRows,
    pins: Pins,
    reach: float,
    strain_max: float = 0.0,
    gain_max: float = np.inf,
) -> Step:
    """Return the step after which the radii can be largest.

    Args:
        count: Number N of spheres.
        pairs: All pairs that might overlap after moves of ``reach``.
        walls: All walls that spheres might be in after such moves.
        pins: What must not move.
        reach: Largest displacement along an axis [m].
        strain_max: Largest entry of the strain; 0: the cell keeps its shape.
        gain_max: Largest gain of the squares of all radii: pairs farther apart than these reach are no rows.

    Raises:
        NoSolutionError: The programme was not solved.
    """
    unit = float(pairs.apart.mean()) if len(pairs.apart) else float(walls.radius.mean())
    strained = strain_max > 0.0
    columns = 3 * count + 1 + (len(STRAINS) if strained else 0)
    of_pairs, pair_room = _pair_rows(pairs, count, unit, strained)
    of_walls, wall_room = _wall_rows(walls, count, unit)
    row = np.concatenate([of_pairs[0], of_walls[0] + len(pairs.apart)])
    column, value = (np.concatenate([of_pairs[k], of_walls[k]]) for k in (1, 2))
    high = np.full(columns, strain_max)
    high[: 3 * count], high[3 * count] = reach / unit, gain_max
    low = -high
    low[3 * count] = -np.inf
    found = solve(
        Programme(
            (np.arange(columns) == 3 * count).astype(float),
            csr_array(coo_array((value, (row, column)), (len(pair_room) + len(wall_room), columns))),
            np.concatenate([pair_room, wall_room]),
            _pinned(pins, count, columns, strained),
            low,
            high,
        )
    )
    strain = np.zeros((3, 3))
    if strained:
        for (one, other), amount in zip(STRAINS, found.value[3 * count + 1 :], strict=True):
            strain[one, other] = strain[other, one] = amount
    of_pair, of_wall = np.split(found.dual, [len(pairs.apart)])
    distance = np.linalg.norm(pairs.separation, axis=1)
    return Step(
        found.value[: 3 * count].reshape(count, 3) * unit,
        float(found.value[3 * count]),
        strain,
        np.maximum(of_pair, 0.0) * 2.0 * distance * unit / (pairs.apart * pairs.apart),
        np.maximum(of_wall, 0.0) * 2.0 * unit / walls.radius,
    )


Entries = tuple[Int64Array, Int64Array, Float64Array]
"""Row, column and value of each entry."""


def _pair_rows(pairs: PairRows, count: int, unit: float, strained: bool) -> tuple[Entries, Float64Array]:
    """Return rows ``G - 1 - 2 (r (u - v) + r e r) / s^2 <= |r|^2 / s^2 - 1``: entries and bounds."""
    number, square = np.arange(len(pairs.apart)), pairs.apart * pairs.apart
    part = 2.0 * pairs.separation / square[:, None]
    axes = np.arange(3)
    row = [np.repeat(number, 3), np.repeat(number, 3), number]
    column = [
        (3 * pairs.first[:, None] + axes).ravel(),
        (3 * pairs.second[:, None] + axes).ravel(),
        np.full(len(number), 3 * count),
    ]
    value = [-unit * part.ravel(), unit * part.ravel(), np.ones(len(number))]
    for place, (one, other) in enumerate(STRAINS if strained else ()):
        twice = 1.0 if one == other else 2.0
        row.append(number)
        column.append(np.full(len(number), 3 * count + 1 + place))
        value.append(-twice * part[:, one] * pairs.separation[:, other])
    room = (pairs.separation * pairs.separation).sum(axis=1) / square - 1.0
    return (np.concatenate(row), np.concatenate(column), np.concatenate(value)), room


def _wall_rows(walls: WallRows, count: int, unit: float) -> tuple[Entries, Float64Array]:
    """Return rows ``(G - 1) r / 2 - n u <= gap``, times 2 / r: entries and bounds."""
    number = np.arange(len(walls.gap))
    row = np.concatenate([np.repeat(number, 3), number])
    column = np.concatenate(
        [(3 * walls.sphere[:, None] + np.arange(3)).ravel(), np.full(len(number), 3 * count)]
    )
    part = -2.0 * unit * walls.normal / walls.radius[:, None]
    value = np.concatenate([part.ravel(), np.ones(len(number))])
    return (row, column, value), 2.0 * walls.gap / walls.radius


def _pinned(pins: Pins, count: int, columns: int, strained: bool) -> csr_array | None:
    """Return the rows of what must not move, and of strains that keep the volume; None: no rows."""
    number = np.arange(len(pins.sphere))
    row = np.repeat(number, 3)
    column, value = (3 * pins.sphere[:, None] + np.arange(3)).ravel(), pins.direction.ravel()
    rows = len(number) + strained
    if strained:
        row = np.concatenate([row, np.full(3, len(number))])
        column = np.concatenate([column, 3 * count + 1 + np.arange(3)])
        value = np.concatenate([value, np.ones(3)])
    return csr_array(coo_array((value, (row, column)), (rows, columns))) if rows else None
