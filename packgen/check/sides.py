"""Whether something holds a zone's sides: a zone that stands free in a wider vessel collapses in the solver.

Spheres that lean against a zone's own side are examined. Where neither the container nor another sphere is
beside them they slide out. The room below them tells how far they fall. No code of the core's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array
from packgen.bed import Bed
from packgen.check.support import FALL, FALL_STEPS, SAMPLE, across_gravity, falls, sample
from packgen.check.walls import shape_clearance, wall_clearance
from packgen.geometry import Container, Shape, Slice

SIDE_STEP = 0.5
"""Test displacement sideways, in radii, used to find spheres that lean against the zone's side."""

SIDE_LEVEL = 0.6
"""Loss of clearance over that step that tells a side: it is steeper than 37 degrees, unlike a heap."""

SIDE_SHARE, SIDE_MIN = 0.03, 3
"""Share and number of the spheres at a zone's side from which the zone counts as standing free."""

STACK = 2.0
"""Longest harmless fall of a sphere that has slid out, in largest diameters."""

DIRECTIONS = 16
"""Directions across gravity in which a zone's side is sought."""

MEMBERS_MAX = 50_000
"""Most spheres of a zone among which those at its side are sought; of more, a sample is taken."""


@dataclass(frozen=True, slots=True)
class FreeStandingZone:
    """A zone whose side nothing holds, in part or all around.

    Attributes:
        zone: Its number.
        looked_at: Spheres at its side that were examined.
        free: How many of them could slide out and fall.
        fall: Median distance of their fall [m].
    """

    zone: int
    looked_at: int
    free: int
    fall: float


def free_standing_zones(
    bed: Bed, locations: Sequence[Sequence[Shape | Slice]]
) -> tuple[FreeStandingZone, ...]:
    """Return the zones that lean against sides where neither the container nor other spheres are.

    Args:
        bed: The bed.
        locations: What bounds each zone beside the container; nothing: the whole container.

    Returns:
        Those zones, in their order; none without gravity, or where the container wraps around along it.
    """
    if not bed.acceleration.any():
        return ()
    found = []
    for zone, shapes in enumerate(locations):
        for shape in shapes:
            side = _at_the_side(bed, zone, shape)
            if len(side.radius) < SIDE_MIN:
                continue
            fall = _falls_beside(bed, zone, side)
            free = fall > STACK * 2.0 * bed.radius.max()
            if free.sum() >= SIDE_MIN and free.mean() > SIDE_SHARE:
                fall_there = float(np.median(fall[free]))
                found.append(FreeStandingZone(zone, len(free), int(free.sum()), fall_there))
    return tuple(found)


@dataclass(frozen=True, eq=False, slots=True)
class _Side:
    """Spheres at a zone's side: centres [m], radii [m], and unit vectors across gravity out of the zone."""

    position: Float64Array
    radius: Float64Array
    outward: Float64Array


def _at_the_side(bed: Bed, zone: int, shape: Shape | Slice) -> _Side:
    """Return the spheres that lean against the side of a zone's shape, at most `SAMPLE` of them."""
    flat = across_gravity(bed.down)
    member = sample(np.flatnonzero(bed.zone_index == zone), MEMBERS_MAX)
    if isinstance(shape, Slice) and shape.centers_only:
        member = member[:0]
    position, radius = _in_the_cell(bed.container, bed.position[member]), bed.radius[member]
    # Where a shape crosses a seam, the image that lies in the shape is examined.
    image, clearance = position, np.full(len(position), -np.inf)
    for shift in _shifts(bed.container):
        here = shape_clearance(shape, position + shift, 2.0 * radius)
        image = np.where((here > clearance)[:, None], position + shift, image)
        clearance = np.maximum(here, clearance)
    near = np.flatnonzero((clearance > 0.5 * radius) & (clearance < (1.0 + SIDE_STEP) * radius))
    near = sample(near, 2 * SAMPLE)
    outward, leans = _sideways(shape, image[near], radius[near], flat)
    chosen = sample(np.flatnonzero(leans), SAMPLE)
    return _Side(position[near[chosen]], radius[near[chosen]], outward[chosen])


def _sideways(
    shape: Shape | Slice, position: Float64Array, radius: Float64Array, flat: Float64Array
) -> tuple[Float64Array, np.ndarray]:
    """Return the directions across gravity in which a shape ends nearest, and whether spheres lean there.

    Args:
        shape: The shape.
        position: Centres of the spheres [m], shape (n, 3).
        radius: Their radii [m], shape (n,).
        flat: Two unit vectors across gravity, shape (2, 3).

    Returns:
        Unit vectors, shape (n, 3), and booleans, shape (n,).
    """
    count = len(position)
    angle = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    directions = np.column_stack([np.cos(angle), np.sin(angle)]) @ flat
    step = SIDE_STEP * radius
    moved = position[:, None] + step[:, None, None] * directions
    reach = np.repeat(2.0 * radius, DIRECTIONS)
    clearance = shape_clearance(shape, moved.reshape(-1, 3), reach).reshape(count, DIRECTIONS)
    best = clearance.argmin(axis=1)
    rows = np.arange(count)
    # The slope of the clearance there tells the direction more exactly than any number of directions.
    probe = 0.1 * step[:, None, None] * np.concatenate([flat, -flat])
    around = (moved[rows, best][:, None] + probe).reshape(-1, 3)
    slope = shape_clearance(shape, around, np.repeat(2.0 * radius, 4)).reshape(count, 4)
    outward = (slope[:, 2:] - slope[:, :2]) @ flat
    length = np.linalg.norm(outward, axis=1)
    sure = length > 0.1 * SIDE_LEVEL * step
    outward = np.where(sure[:, None], outward / np.where(sure, length, 1.0)[:, None], directions[best])
    return outward, clearance[rows, best] < radius - SIDE_LEVEL * step


def _falls_beside(bed: Bed, zone: int, side: _Side) -> Float64Array:
    """Return how far spheres fall once they have slid out of a zone's side [m]; 0 where they cannot, (n,)."""
    position, radius, outward = side.position, side.radius, side.outward
    own = bed.radius[bed.zone_index == zone]
    # A gap to a wall is measured in the zone's spheres. Hollows between spheres are as deep as the largest.
    gap = FALL * 2.0 * float((own**4).sum() / (own**3).sum())
    hollow = FALL * 2.0 * float(bed.radius.max())
    steps = gap * np.arange(1, FALL_STEPS + 1) / FALL_STEPS
    along = (position[:, None] + steps[:, None] * outward[:, None]).reshape(-1, 3)
    clearance = wall_clearance(bed.container, along, np.repeat(radius, FALL_STEPS))
    free = (clearance.reshape(-1, FALL_STEPS) >= 0.9 * radius[:, None]).all(axis=1)
    fall = np.zeros(len(radius))
    if not free.any():
        return fall
    others = _others(bed, zone, hollow + 2.0 * float(bed.radius.max()))
    index = np.flatnonzero(free)
    index = index[~_met(position[index], radius[index], outward[index], hollow, *others)]
    slid = _in_the_cell(bed.container, position[index] + gap * outward[index])
    fall[index] = falls(bed, slid, radius[index], others, STACK * 2.0 * float(bed.radius.max()))
    return fall


def _met(
    position: Float64Array,
    radius: Float64Array,
    direction: Float64Array,
    way: float,
    others: Float64Array,
    others_radius: Float64Array,
) -> np.ndarray:
    """Tell which spheres meet another one within a distance [m] along their directions, shape (n,)."""
    met = np.zeros(len(position), dtype=bool)
    reach = 0.5 * way + float(radius.max(initial=0.0) + others_radius.max(initial=0.0))
    low, high = (
        each(position, axis=0, initial=start) for each, start in ((np.min, np.inf), (np.max, -np.inf))
    )
    beside = ((others > low - way - reach) & (others < high + way + reach)).all(axis=1)
    others, others_radius = others[beside], others_radius[beside]
    if len(others) == 0:
        return met
    tree = cKDTree(others, balanced_tree=False, compact_nodes=False)
    for index, near in enumerate(tree.query_ball_point(position + 0.5 * way * direction, reach)):
        relative = others[near] - position[index]
        along = relative @ direction[index]
        across = np.einsum("ij,ij->i", relative, relative) - along**2
        apart = (radius[index] + others_radius[near]) ** 2 - across
        met[index] = bool(
            ((apart > 0.0) & (along > 0.0) & (along - np.sqrt(np.maximum(apart, 0.0)) < way)).any()
        )
    return met


def _others(bed: Bed, zone: int, reach: float) -> tuple[Float64Array, Float64Array]:
    """Return the spheres of other zones and all images beyond seams, within reach [m]: centres and radii."""
    other = bed.zone_index != zone
    position = _in_the_cell(bed.container, bed.position)
    centres, radii = [position[other]], [bed.radius[other]]
    low, high = bed.container.bounds
    for shift in _shifts(bed.container)[1:]:
        image = position + shift
        near = ((image > low - reach) & (image < high + reach)).all(axis=1)
        centres.append(image[near])
        radii.append(bed.radius[near])
    return np.concatenate(centres), np.concatenate(radii)


def _in_the_cell(container: Container, position: Float64Array) -> Float64Array:
    """Return positions [m] moved by whole periods into a container that wraps around."""
    if not any(container.periodic):
        return position
    low, high = container.bounds
    wrapped = low + np.mod(position - low, high - low)
    return np.asarray(np.where(container.periodic, wrapped, position))


def _shifts(container: Container) -> Float64Array:
    """Return no shift, and those by a period [m] along all axes that wrap around, shape (k, 3)."""
    steps = product(*[(0, 1, -1) if wraps else (0,) for wraps in container.periodic])
    return np.asarray(np.array(list(steps)) * (container.bounds[1] - container.bounds[0]))
