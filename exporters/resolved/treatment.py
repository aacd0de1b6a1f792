"""What becomes of spheres where they touch: shrunk, cut flat, joined by cylinders, or left.

``shrink`` multiplies every radius by a factor. ``caps`` cuts both spheres of a near pair by planes across
their line, so that flats at least the gap lie between them, and spheres near walls likewise; a hollow
cylinder's wall is at least the gap away from all of the flat. ``bridges`` adds a cylinder on the line of a
near pair, and one from a sphere to a wall that it is near.

Volumes are closed forms while features of one sphere do not overlap. Where cuts of a sphere overlap, its
volume is a quadrature; where bridges do, or three spheres, what they share is counted more than once.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from exporters.resolved import volumes
from exporters.resolved.contacts import Pairs, WallContacts
from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.bed import Bed
from packgen.errors import ExportError

CUT_MIN = 0.5  # of a radius: a sphere that has to be cut nearer to its centre is refused
END = 0.5  # bridges begin and end at this share of a radius from the centre


@dataclass(frozen=True, eq=False, slots=True)
class Cuts:
    """Planes that cut spheres flat: index of the sphere, unit normal, distance from the centre [m]."""

    owner: Int64Array
    normal: Float64Array
    distance: Float64Array


@dataclass(frozen=True, eq=False, slots=True)
class Bridges:
    """Cylinders, from the centre of a sphere outwards.

    Attributes:
        owner: Index of the sphere, shape (B,), int64.
        direction: Unit vector of the axis, shape (B, 3).
        start: Where the cylinder begins, from the sphere's centre [m], shape (B,).
        stop: Where it ends [m], shape (B,).
        radius: Its radius [m], shape (B,).
    """

    owner: Int64Array
    direction: Float64Array
    start: Float64Array
    stop: Float64Array
    radius: Float64Array


def no_cuts() -> Cuts:
    """Return no cuts."""
    return Cuts(np.empty(0, np.int64), np.empty((0, 3)), np.empty(0))


def no_bridges() -> Bridges:
    """Return no bridges."""
    return Bridges(np.empty(0, np.int64), np.empty((0, 3)), np.empty(0), np.empty(0), np.empty(0))


@dataclass(frozen=True, eq=False, slots=True)
class Treated:
    """Spheres after treatment.

    Attributes:
        radius: Radii [m], shape (N,).
        cuts: Planes that cut them.
        bridges: Cylinders that join them.
        solid_before: Volume of the spheres as they are, overlaps once [m3].
        solid_after: Volume of what is left of them, with bridges [m3].
        counts: How much was treated, by what it is called.
        method: How the volume after treatment was found.
    """

    radius: Float64Array
    cuts: Cuts = field(default_factory=no_cuts)
    bridges: Bridges = field(default_factory=no_bridges)
    solid_before: float = 0.0
    solid_after: float = 0.0
    counts: dict[str, int] = field(default_factory=dict)
    method: str = "closed form"


def left(bed: Bed, overlaps: Pairs) -> Treated:
    """Return the spheres as they are; ``overlaps`` are the pairs that overlap, or more."""
    solid = solid_volume(bed.radius, overlaps)
    return Treated(bed.radius, solid_before=solid, solid_after=solid)


def shrunk(bed: Bed, overlaps: Pairs, factor: float) -> Treated:
    """Return spheres with radii multiplied by a factor."""
    radius = bed.radius * factor
    touching = radius[overlaps.first] + radius[overlaps.second] > overlaps.distance
    return Treated(
        radius,
        solid_before=solid_volume(bed.radius, overlaps),
        solid_after=solid_volume(radius, overlaps),
        counts={"spheres_shrunk": bed.count, "pairs_still_overlapping": int(touching.sum())},
    )


def capped(bed: Bed, pairs: Pairs, walls: WallContacts, gap: float) -> Treated:
    """Return spheres cut flat at near pairs and near walls, so that gaps are at least a fraction of a radius.

    Args:
        bed: The bed.
        pairs: Near pairs; the gap between them becomes this fraction of the smaller radius.
        walls: Places near walls; the gap there becomes this fraction of the sphere's radius.
        gap: The fraction.

    Raises:
        ExportError: A sphere would lose too much.
    """
    first, second = bed.radius[pairs.first], bed.radius[pairs.second]
    # Both caps have the same height; the middle of the gap stays where it was.
    height = 0.5 * (gap * np.minimum(first, second) - (pairs.distance - first - second))
    own = bed.radius[walls.owner]
    cuts = Cuts(
        np.concatenate([pairs.first, pairs.second, walls.owner]),
        np.concatenate([pairs.direction, -pairs.direction, walls.direction]),
        np.concatenate([first - height, second - height, _wall_cut(own, walls, gap)]),
    )
    real = cuts.distance < bed.radius[cuts.owner]
    order = np.flatnonzero(real)[np.argsort(cuts.owner[real], kind="stable")]
    cuts = Cuts(cuts.owner[order], cuts.normal[order], cuts.distance[order])
    _refuse_deep(bed, cuts)
    after, overlapping = _cut_volume(bed.radius, cuts)
    method = "closed form"
    if overlapping:
        method += f", of {overlapping} spheres whose flats meet quadrature of {volumes.DIRECTIONS} directions"
        method += f" to {volumes.DIRECTIONS_ERROR:g} of a sphere"
    return Treated(
        bed.radius,
        cuts,
        solid_before=solid_volume(bed.radius, pairs),
        solid_after=after,
        counts={"pairs_cut": len(pairs.first), "cuts_at_walls": len(walls.owner)},
        method=method,
    )


def _wall_cut(radius: Float64Array, walls: WallContacts, gap: float) -> Float64Array:
    """Return the distances of planes that cut spheres where they come nearer to a wall than the gap."""
    if not np.isfinite(walls.curvature):
        return np.asarray(walls.distance - gap * radius)
    # Where a sphere meets the cylinder that is narrower by the gap: no point before the plane is beyond it.
    from_axis = np.maximum(walls.curvature - walls.distance, np.finfo(float).tiny)
    inner = walls.curvature - gap * radius
    return np.asarray((inner**2 - from_axis**2 - radius**2) / (2.0 * from_axis))


def _refuse_deep(bed: Bed, cuts: Cuts) -> None:
    deep = np.flatnonzero(cuts.distance < CUT_MIN * bed.radius[cuts.owner])
    if len(deep):
        sphere = int(cuts.owner[deep[0]])
        share = cuts.distance[deep[0]] / bed.radius[sphere]
        raise ExportError(
            f"surface: contacts=caps cuts sphere {sphere + 1} at {share:.3g} of its radius, "
            f"expected at least {CUT_MIN}: it overlaps another sphere or a wall, or a wall is as hollow "
            "as it is; choose contacts=shrink"
        )


def _cut_volume(radius: Float64Array, cuts: Cuts) -> tuple[float, int]:
    """Return the volume of cut spheres [m3], and of how many the cuts overlap."""
    height = np.arccos(np.clip(cuts.distance / radius[cuts.owner], -1.0, 1.0))
    meeting = meeting_owners(cuts.owner, cuts.normal, height)
    alone = ~np.isin(cuts.owner, meeting)
    total = float(volumes.ball(radius).sum())
    total -= float(volumes.cap(radius[cuts.owner[alone]], cuts.distance[alone]).sum())
    for sphere in meeting.tolist():
        own = slice(*np.searchsorted(cuts.owner, [sphere, sphere + 1]))
        left_of_it = volumes.cut_ball(float(radius[sphere]), cuts.normal[own], cuts.distance[own])
        total -= float(volumes.ball(radius[sphere])) - left_of_it
    return total, len(meeting)


def meeting_owners(owner: Int64Array, direction: Float64Array, half_angle: Float64Array) -> Int64Array:
    """Return the spheres on which two features overlap.

    Args:
        owner: Sphere of each feature, shape (K,), rising.
        direction: Unit vector to its middle, shape (K, 3).
        half_angle: Angle that it reaches from there, shape (K,).
    """
    met = np.zeros(len(owner), dtype=bool)
    step = 1
    while step < len(owner) and (same := owner[step:] == owner[:-step]).any():
        along = np.clip((direction[step:] * direction[:-step]).sum(axis=1), -1.0, 1.0)
        met[step:] |= same & (np.arccos(along) < half_angle[step:] + half_angle[:-step])
        step += 1
    return np.unique(owner[met])


def bridged(bed: Bed, pairs: Pairs, walls: WallContacts, share: float) -> Treated:
    """Return spheres joined by cylinders to those that they are near, and to walls.

    Args:
        bed: The bed.
        pairs: Near pairs.
        walls: Places near walls.
        share: Radius of the cylinders, as a fraction of the smaller sphere's.
    """
    first, second = bed.radius[pairs.first], bed.radius[pairs.second]
    cylinder = share * np.minimum(first, second)
    # Spheres whose overlap is wider than the cylinder are joined already.
    open_pair = pairs.distance > np.sqrt(first**2 - cylinder**2) + np.sqrt(second**2 - cylinder**2)
    first, second, cylinder = first[open_pair], second[open_pair], cylinder[open_pair]
    distance, direction = pairs.distance[open_pair], pairs.direction[open_pair]
    chosen = _apart(walls, 2.0 * np.arcsin(share))
    walls = WallContacts(
        walls.owner[chosen], walls.direction[chosen], walls.distance[chosen], walls.curvature
    )
    own, wall_cylinder = bed.radius[walls.owner], share * bed.radius[walls.owner]
    owner = np.concatenate([pairs.first[open_pair], walls.owner])
    bridges = Bridges(
        owner,
        np.concatenate([direction, walls.direction]),
        END * bed.radius[owner],
        np.concatenate([distance - END * second, walls.distance + END * own]),
        np.concatenate([cylinder, wall_cylinder]),
    )
    at_walls = volumes.cylinder_beyond(own, wall_cylinder, walls.distance)
    at_walls += volumes.behind_flat(wall_cylinder, walls.curvature)
    # Up to the plane where the spheres meet, or in the middle of the gap, on either side.
    middle = 0.5 * (distance + first - second)
    between = volumes.cylinder_beyond(first, cylinder, middle)
    between += volumes.cylinder_beyond(second, cylinder, distance - middle)
    before = solid_volume(bed.radius, pairs)
    overlap = np.asarray(volumes.lens(first, second, distance)).sum()
    return Treated(
        bed.radius,
        bridges=bridges,
        solid_before=before,
        solid_after=before + float(overlap) + float(between.sum()) + float(at_walls.sum()),
        counts={"bridges_between_spheres": int(open_pair.sum()), "bridges_to_walls": len(walls.owner)},
        method=_bridge_method(bed, pairs, open_pair, walls, share),
    )


def _bridge_method(bed: Bed, pairs: Pairs, open_pair: BoolArray, walls: WallContacts, share: float) -> str:
    """Return how the volume of bridges was found, and on how many spheres bridges overlap."""
    owner = np.concatenate([pairs.first[open_pair], pairs.second[open_pair], walls.owner])
    direction = np.concatenate(
        [pairs.direction[open_pair], -pairs.direction[open_pair], walls.direction], axis=0
    )
    smaller = np.minimum(bed.radius[pairs.first], bed.radius[pairs.second])[open_pair]
    cylinder = share * np.concatenate([smaller, smaller, bed.radius[walls.owner]])
    order = np.argsort(owner, kind="stable")
    angle = np.arcsin(cylinder / bed.radius[owner])
    meeting = len(meeting_owners(owner[order], direction[order], angle[order]))
    said = "closed form"
    if np.isfinite(walls.curvature) and len(walls.owner):
        said += f", at the wall quadrature of {volumes.WALL_NODES} nodes"
    return said + (f", counted twice where bridges meet on {meeting} spheres" if meeting else "")


def _apart(walls: WallContacts, angle: float) -> Int64Array:
    """Return places near walls of which no two of one sphere are within an angle; the nearest ones stay."""
    order = np.lexsort((walls.distance, walls.owner))
    kept: list[int] = []
    begin = 0
    for index in order.tolist():
        if kept and walls.owner[kept[-1]] != walls.owner[index]:
            begin = len(kept)
        others = walls.direction[kept[begin:]]
        if not len(others) or float((others @ walls.direction[index]).max()) < np.cos(angle):
            kept.append(index)
    return np.array(kept, dtype=np.int64)


def solid_volume(radius: Float64Array, overlaps: Pairs) -> float:
    """Return the volume of balls less what pairs of them share [m3]; exact where no three overlap."""
    shared = volumes.lens(radius[overlaps.first], radius[overlaps.second], overlaps.distance)
    return float(volumes.ball(radius).sum() - np.asarray(shared).sum())
