"""How many contacts a sphere has, whatever gap counts as one: the plateau of the coordination number.

A contact at a single gap is a convention. Where spheres really touch, the number of contacts hardly changes
over decades of gaps: from what the arrangement leaves between spheres at rest up to where neighbours come in
that do not touch. A bed whose spheres do not rest on each other has no such plateau.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array, add_at
from packgen.bed import Bed, has_clumps
from packgen.check import near_pairs
from packgen.check.wall_contacts import wall_contacts
from packgen.geometry import Mesh
from packgen.part import Part

GAPS_A_DECADE = 8
GAP_LEAST, GAP_LARGEST = 1.0e-8, 1.0e-1  # radii
PLATEAU_RISE = 0.05  # share by which the contacts of a plateau may grow from its first gap to its last
PLATEAU_DECADES = 0.5  # least width of a plateau
PLATEAU_LEAST = 3.0  # contacts a sphere; fewer hold nothing
HELD_RESTING, HELD_FREE = 3, 4  # contacts that hold a sphere: under gravity, and without
SPHERES_MAX = 1_000_000  # of a bed that is measured: its contacts are held in memory


@dataclass(frozen=True, slots=True)
class Coordination:
    """Contacts a sphere over the gap, walls counted, and where they do not depend on it.

    Attributes:
        gap: Largest gaps of a contact, as fractions of the smaller radius, evenly spaced by their logarithms.
        mean: Contacts a sphere at each gap. A wall is one, a mesh one wall.
        plateau: Contacts a sphere on the plateau, at the middle of its gaps; None where there is none. A
            plateau is the widest range of gaps, at least half a decade, over which the contacts, three a
            sphere or more, grow by no more than 5 %.
        plateau_low: Least gap of the plateau; None where there is none.
        plateau_high: Largest gap of the plateau; None where there is none.
        rattlers: Share of the spheres that their contacts at the middle of the plateau cannot hold, taken out
            one after the other: what only such spheres hold is not held. Under gravity three contacts are
            needed, one of them below the centre; without gravity four. None without a plateau, and of a bed
            in pieces.
        plateau_held: Contacts a sphere there without the rattlers and their contacts; None likewise.
    """

    gap: tuple[float, ...]
    mean: tuple[float, ...]
    plateau: float | None
    plateau_low: float | None
    plateau_high: float | None
    rattlers: float | None
    plateau_held: float | None


@dataclass(frozen=True, eq=False, slots=True)
class _Ends:
    """Contacts: both spheres, the second -1 for a wall; gaps in radii; positive where the second is below."""

    first: Int64Array
    second: Int64Array
    gap: Float64Array
    below: Float64Array


def coordination(bed: Bed, clearance: Float64Array) -> Coordination | None:
    """Return the contacts a sphere of a bed over the gap.

    Args:
        bed: The bed; spheres of one body are not in contact.
        clearance: Distance of each centre from the nearest wall [m], exact up to 1.1 radii, shape (N,).

    Returns:
        The contacts; None without spheres, with clumps, or of more than `SPHERES_MAX`.
    """
    if has_clumps(bed) or not 0 < bed.count <= SPHERES_MAX:
        return None
    gap, ends = _gaps(), _ends(Part.whole(bed), clearance)
    mean = _mean(_number(ends, gap), bed.count)
    found = plateau(mean)
    values: list[float | None] = [None] * 5
    if found is not None:
        low, high = found
        middle = (low + high) // 2
        loose = _loose(bed, ends, float(gap[middle]))
        values = [float(each) for each in (mean[middle], gap[low], gap[high], loose.mean())]
        values.append(_mean_without(ends, loose, float(gap[middle])))
    return Coordination(tuple(gap.tolist()), tuple(mean.tolist()), *values)


class CoordinationCounter:
    """Counts contacts over the gap of a bed in parts; rattlers hang on the whole bed and are left open."""

    def __init__(self) -> None:
        self._gap = _gaps()
        self._number = np.zeros(len(self._gap))
        self._spheres = 0

    def add(self, part: Part, clearance: Float64Array) -> None:
        """Count the contacts of a part; clearance as `coordination` has it, of its own spheres, (own,)."""
        self._number += _number(_ends(part, clearance), self._gap)
        self._spheres += part.own

    def result(self) -> Coordination | None:
        """Return what was counted of all parts; None of no spheres."""
        if self._spheres == 0:
            return None
        mean = _mean(self._number, self._spheres)
        found = plateau(mean)
        values: list[float | None] = [None] * 5
        if found is not None:
            low, high = found
            values[:3] = [float(each) for each in (mean[(low + high) // 2], self._gap[low], self._gap[high])]
        return Coordination(tuple(self._gap.tolist()), tuple(mean.tolist()), *values)


def _gaps() -> Float64Array:
    """Return the gaps at which contacts are counted."""
    decades = np.log10(GAP_LARGEST / GAP_LEAST)
    return np.logspace(np.log10(GAP_LEAST), np.log10(GAP_LARGEST), round(decades * GAPS_A_DECADE) + 1)


def _number(ends: _Ends, gap: Float64Array) -> Float64Array:
    """Return how many ends of contacts have each gap, those of larger ones left out, shape of ``gap``."""
    weight = np.where(ends.second < 0, 1.0, 2.0)
    number = np.bincount(np.searchsorted(gap, ends.gap), weights=weight, minlength=len(gap) + 1)
    return np.asarray(number[: len(gap)])


def _mean(number: Float64Array, spheres: int) -> Float64Array:
    return np.asarray(np.cumsum(number) / spheres)


def plateau(mean: Float64Array) -> tuple[int, int] | None:
    """Return the first and last place of the plateau of contacts a sphere, of equals the one at least gaps.

    Args:
        mean: Contacts a sphere, rising with the gap, `GAPS_A_DECADE` a decade.

    Returns:
        Two places; None where there is no plateau.
    """
    # The last place up to which the contacts grow by no more than the share, from each place on.
    last = np.searchsorted(mean, mean * (1.0 + PLATEAU_RISE), side="right") - 1
    width = np.where(mean >= PLATEAU_LEAST, last - np.arange(len(mean)), -1)
    first = int(width.argmax())
    if width[first] < PLATEAU_DECADES * GAPS_A_DECADE:
        return None
    return first, int(last[first])


def _ends(part: Part, clearance: Float64Array) -> _Ends:
    """Return all contacts of a part up to the largest gap."""
    bed = part.bed
    down = bed.down
    periods = np.array([each or 0.0 for each in bed.container.period])
    # Along `down` nothing wraps around in a bed that rests; in others no depth is asked for.
    parts = []
    for pairs in near_pairs(
        bed.position,
        bed.radius,
        gap_fraction=GAP_LARGEST,
        period=bed.container.period,
        body_index=bed.body_index,
    ):
        apart = bed.position[pairs.second] - bed.position[pairs.first]
        apart -= periods * np.round(apart / np.where(periods > 0.0, periods, 1.0))
        smaller = np.minimum(bed.radius[pairs.first], bed.radius[pairs.second])
        found = pairs.first, pairs.second, pairs.gap / smaller, apart @ down
        if not part.is_whole:
            counted = part.counted(pairs.first, pairs.second)
            found = found[0][counted], found[1][counted], found[2][counted], found[3][counted]
        parts.append(found)
    if part.owner is not None:
        owner = part.owner
        parts = [(owner[first], owner[second], gap, below) for first, second, gap, below in parts]
    sphere, away, below = _walls(bed, clearance, down)
    parts.append((sphere, np.full(len(sphere), -1), away, below))
    return _Ends(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _walls(
    bed: Bed, clearance: Float64Array, down: Float64Array
) -> tuple[Int64Array, Float64Array, Float64Array]:
    """Return the spheres at walls, their gaps in radii, and the walls' depth below them, each (W,)."""
    near = np.flatnonzero(clearance <= bed.radius[: len(clearance)] * (1.0 + GAP_LARGEST))
    if isinstance(bed.container.shape, Mesh):
        # What the wall's direction is, is not known: it may be below.
        return near, clearance[near] / bed.radius[near] - 1.0, np.ones(len(near))
    place, normal, away = wall_contacts(bed.container, bed.position[near], bed.radius[near], GAP_LARGEST)
    sphere = near[place]
    return sphere, away / bed.radius[sphere] - 1.0, normal @ down


def _loose(bed: Bed, ends: _Ends, gap: float) -> BoolArray:
    """Return the spheres that their contacts cannot hold, taken out one after the other, shape (N,)."""
    near = ends.gap <= gap
    first, second, below = ends.first[near], ends.second[near], ends.below[near]
    loose = np.zeros(bed.count, dtype=bool)
    while True:
        kept = ~loose[first] & ~((second >= 0) & loose[second])
        first, second, below = first[kept], second[kept], below[kept]
        other = second >= 0
        number = np.zeros(bed.count, dtype=np.int32)
        resting = np.zeros(bed.count, dtype=np.int32)
        add_at(number, first)
        add_at(number, second[other])
        add_at(resting, first[below > 0.0])
        add_at(resting, second[other & (below < 0.0)])
        held = (number >= HELD_RESTING) & (resting > 0) if bed.rests else number >= HELD_FREE
        if not (~held & ~loose).any():
            return loose
        loose |= ~held


def _mean_without(ends: _Ends, loose: BoolArray, gap: float) -> float:
    """Return the contacts a sphere among those that are held; 0 where none is."""
    kept = (ends.gap <= gap) & ~loose[ends.first] & ~((ends.second >= 0) & loose[ends.second])
    number = float(np.where(ends.second[kept] < 0, 1.0, 2.0).sum())
    return number / max(int(np.count_nonzero(~loose)), 1)
