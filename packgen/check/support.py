"""Whether something holds a zone up: a zone's own floor is no floor once the bed is in a solver.

Spheres at a zone's lower end are examined. Where many of them could fall, neither the container nor the rest
of the bed is below. No code of the core's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.check.walls import shape_clearance, wall_clearance
from packgen.geometry import Shape, Slice

STEP = 0.05
"""Test displacement, in radii, used to find spheres resting on the zone's floor."""

LEVEL = 0.8
"""Loss of clearance over that step that tells a floor: it slopes by less than 37 degrees."""

FALL = 1.5
"""Fall, in largest diameters, from which a sphere hangs: hollows of a bed are less deep."""

HANGING_SHARE = 0.2
"""Share of the spheres at a zone's lower end from which the zone counts as held by nothing."""

SAMPLE = 400
"""Most spheres of a zone's lower end that are examined."""

FALL_STEPS = 12
"""Heights at which a wall below is sought."""


@dataclass(frozen=True, slots=True)
class HangingZone:
    """A zone that nothing holds up.

    Attributes:
        zone: Its number.
        looked_at: Spheres at its lower end that were examined.
        hanging: How many of them could fall.
        fall: Median distance of their fall [m].
    """

    zone: int
    looked_at: int
    hanging: int
    fall: float


def hanging_zones(bed: Bed, locations: Sequence[Sequence[Shape | Slice]]) -> tuple[HangingZone, ...]:
    """Return the zones whose lower ends neither the container nor other spheres hold.

    Args:
        bed: The bed.
        locations: What bounds each zone beside the container; nothing: the whole container.

    Returns:
        Those zones, in their order; none without gravity, or where the container wraps around along it.
    """
    if not bed.acceleration.any():
        return ()
    down = bed.down
    found = []
    for zone, shapes in enumerate(locations):
        lowest = _at_the_floor(bed, zone, shapes, down)
        if len(lowest) == 0:
            continue
        limit = FALL * 2.0 * float(bed.radius.max())
        other = bed.zone_index != zone
        others = bed.position[other], bed.radius[other]
        fall = falls(bed, bed.position[lowest], bed.radius[lowest], others, limit)
        hanging = fall > limit
        if hanging.mean() > HANGING_SHARE:
            found.append(HangingZone(zone, len(lowest), int(hanging.sum()), float(np.median(fall[hanging]))))
    return tuple(found)


def _at_the_floor(bed: Bed, zone: int, shapes: Sequence[Shape | Slice], down: Float64Array) -> Int64Array:
    """Return the spheres that stand on a zone's own floor, at most `SAMPLE` of them."""
    member = np.flatnonzero(bed.zone_index == zone)
    position, radius = bed.position[member], bed.radius[member]
    step = STEP * radius
    stands = np.zeros(len(member), dtype=bool)
    for shape in shapes:
        needed = 0.0 if isinstance(shape, Slice) and shape.centers_only else radius
        lowered = shape_clearance(shape, position + step[:, None] * down, radius + step)
        stands |= lowered < needed - LEVEL * step
    return sample(member[stands], SAMPLE)


def across_gravity(down: Float64Array) -> Float64Array:
    """Return two unit vectors across gravity, shape (2, 3)."""
    return np.asarray(np.linalg.svd(down[None])[2][1:])


def sample(index: Int64Array, most: int) -> Int64Array:
    """Return some of the indices, evenly spread, at most as many as asked for."""
    return np.asarray(index[np.linspace(0, len(index) - 1, min(most, len(index))).astype(np.int64)])


def falls(
    bed: Bed,
    position: Float64Array,
    radius: Float64Array,
    others: tuple[Float64Array, Float64Array],
    limit: float,
) -> Float64Array:
    """Return how far spheres fall straight down to one of some others or to a wall.

    Args:
        bed: The bed whose container and gravity count.
        position: Centres of the spheres [m], shape (n, 3).
        radius: Their radii [m], shape (n,).
        others: Centres and radii of the spheres that may be below [m], shapes (k, 3) and (k,).
        limit: How far down walls are sought [m].

    Returns:
        Distances [m], shape (n,).
    """
    down = bed.down
    fall = _fall_to_the_end(bed, position, radius, down)
    centre, other_radius = others
    if len(centre) and len(position):
        flat = across_gravity(down).T
        shadow = cKDTree(centre @ flat)
        reach = radius + other_radius.max()
        for index, near in enumerate(shadow.query_ball_point(position @ flat, reach)):
            apart = radius[index] + other_radius[near]
            relative = centre[near] - position[index]
            along = relative @ down
            across = apart**2 - (np.einsum("ij,ij->i", relative, relative) - along**2)
            met = (across > 0.0) & (along > 0.0)
            way = along[met] - np.sqrt(across[met])
            fall[index] = min(fall[index], max(float(way.min(initial=np.inf)), 0.0))
    for step in np.linspace(0.0, limit, FALL_STEPS + 1)[1:]:
        free = np.flatnonzero(fall > step)
        clearance = wall_clearance(bed.container, position[free] + step * down, radius[free])
        fall[free[clearance < 0.9 * radius[free]]] = step
    return fall


def _fall_to_the_end(
    bed: Bed, position: Float64Array, radius: Float64Array, down: Float64Array
) -> Float64Array:
    """Return how far spheres are above the lowest corner of the container's bounding box [m], shape (n,)."""
    low, high = bed.container.bounds
    lowest = float(np.maximum(low * down, high * down).sum())
    return np.asarray(np.maximum(lowest - position @ down - radius, 0.0))
