"""Where spheres touch each other and the walls, or nearly do."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exporters.resolved.channel import Channel, cylinder_of
from exporters.resolved.triangles import triangles_within
from exporters.shared.bonds import find_bonds
from packgen.arrays import Float64Array, Int64Array, unique_rows
from packgen.bed import Bed

SAME_PLACE = 1.0e-9  # of a radius; nearest points of two facets that share an edge are one


@dataclass(frozen=True, eq=False, slots=True)
class Pairs:
    """Pairs of spheres.

    Attributes:
        first: Index of one sphere, shape (P,), int64.
        second: Index of the other one, shape (P,), int64.
        direction: Unit vector from the first to the second, across a seam where that is nearer, shape (P, 3).
        distance: Distance of the centres [m], shape (P,).
    """

    first: Int64Array
    second: Int64Array
    direction: Float64Array
    distance: Float64Array


@dataclass(frozen=True, eq=False, slots=True)
class WallContacts:
    """Places where spheres are near a wall.

    Attributes:
        owner: Index of the sphere, shape (W,), int64, rising.
        direction: Unit vector from the centre to the wall, shape (W, 3).
        distance: Distance of the wall from the centre [m], shape (W,).
        curvature: Radius of the wall around the tube's axis [m], infinite where it is flat.
    """

    owner: Int64Array
    direction: Float64Array
    distance: Float64Array
    curvature: float = np.inf


def near_pairs(bed: Bed, gap: float, name: str) -> Pairs:
    """Return the pairs of spheres whose gap is at most a fraction of the smaller radius, none of one body.

    Args:
        bed: The bed.
        gap: The fraction.
        name: What messages call the format.

    Raises:
        ExportError: The bed wraps around too soon.
    """
    bonds = find_bonds(bed, gap, name)
    apart = bed.position[bonds.second] - bed.position[bonds.first]
    for axis, period in enumerate(bed.container.period):
        if period is not None:
            apart[:, axis] -= np.rint(apart[:, axis] / period) * period
    direction = apart / np.maximum(bonds.distance, np.finfo(float).tiny)[:, None]
    return Pairs(bonds.first, bonds.second, direction, bonds.distance)


def near_walls(bed: Bed, channel: Channel, gap: float) -> WallContacts:
    """Return where spheres are at most a fraction of their radius from a wall.

    The ends of a tube and the sides along which a box wraps around are no walls.
    """
    reach = bed.radius * (1.0 + gap)
    if channel.kind == "box":
        return _near_sides(bed, channel, reach)
    if channel.kind == "cylinder":
        return _near_cylinder(bed, channel, reach)
    surface = channel.container.surface
    owner, place = triangles_within(bed.position, reach, surface.vertices[surface.faces])
    apart = place - bed.position[owner]
    rounded = np.rint(apart / (SAME_PLACE * bed.radius[owner])[:, None])
    chosen = np.sort(unique_rows(np.column_stack([owner, rounded]))[0])
    distance = np.linalg.norm(apart[chosen], axis=1)
    direction = apart[chosen] / np.maximum(distance, np.finfo(float).tiny)[:, None]
    return WallContacts(owner[chosen], direction, distance)


def _near_sides(bed: Bed, channel: Channel, reach: Float64Array) -> WallContacts:
    owners, directions, distances = [], [], []
    flow = int(np.argmax(np.abs(channel.up))) if channel.is_tube else None
    for axis in range(3):
        if bed.container.periodic[axis] or axis == flow:
            continue
        for side, sign in enumerate((-1.0, 1.0)):
            distance = sign * (bed.container.bounds[side, axis] - bed.position[:, axis])
            owner = np.flatnonzero(distance <= reach)
            owners.append(owner)
            directions.append(np.tile(sign * np.eye(3)[axis], (len(owner), 1)))
            distances.append(distance[owner])
    if not owners:
        return WallContacts(np.empty(0, np.int64), np.empty((0, 3)), np.empty(0))
    owner = np.concatenate(owners)
    order = np.argsort(owner, kind="stable")
    return WallContacts(owner[order], np.concatenate(directions)[order], np.concatenate(distances)[order])


def _near_cylinder(bed: Bed, channel: Channel, reach: Float64Array) -> WallContacts:
    axis_point, curvature = cylinder_of(bed.container)
    apart = bed.position - axis_point
    across = apart - (apart @ channel.up)[:, None] * channel.up
    from_axis = np.linalg.norm(across, axis=1)
    owner = np.flatnonzero(curvature - from_axis <= reach)
    direction = across[owner] / np.maximum(from_axis[owner], np.finfo(float).tiny)[:, None]
    return WallContacts(owner, direction, curvature - from_axis[owner], curvature)
