"""Where the bodies of a layer start: above the bed, apart from each other, turned at random."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from packgen.arrange.rigid.layer import members_at
from packgen.arrange.rigid.start_kernels import start_places
from packgen.arrange.space.region import Region
from packgen.arrays import BoolArray, Float64Array
from packgen.bodies import Bodies, Form, drawn_bodies
from packgen.portable import components
from packgen.supply.supply import Draw

TRIES = 24
"""Places tried for each body."""

ROUNDS = 4
"""How often points within the walls are drawn for these, before fewer have to do."""

MEMBERS_AT_ONCE = 4_000_000
"""Spheres of tried places that are at hand at once."""


@dataclass(frozen=True, slots=True)
class Slab:
    """Where bodies start: from the lowest to the highest altitude of their centres [m]."""

    low: float
    high: float


def started(
    draw: Draw,
    forms: tuple[Form | None, ...],
    region: Region,
    slab: Slab,
    there: Float64Array,
    rng: np.random.Generator,
) -> tuple[Bodies, BoolArray]:
    """Draw bodies and give each a place where it overlaps neither another one nor a wall.

    Large ones choose first, and each takes the lowest of its places that is free.

    Args:
        draw: The bodies, as spheres of their volumes.
        forms: Shape of each set's particles.
        region: Where they may be.
        slab: The altitudes.
        there: Centres and radii of the spheres that are there before [m], shape (F, 4).
        rng: Source of randomness.

    Returns:
        (the bodies in the order drawn, those with a place at it; which have one, shape (B,)).
    """
    bodies = drawn_bodies(draw.radius, draw.set_index, forms, rng)
    count = len(bodies)
    points = _points(region, slab, TRIES * count, rng)
    tries = len(points) // max(count, 1)
    if count == 0 or (tries == 0 and len(points) == 0):
        return bodies, np.zeros(count, bool)
    if tries == 0:
        # Less room than bodies: the first ones try.
        points, tries = np.resize(points, (count, 3)), 1
    points = points[: tries * count].reshape(count, tries, 3)
    lowest = np.argsort(components(points.reshape(-1, 3), region.frame[2]).reshape(count, tries), axis=1)
    points = np.take_along_axis(points, lowest[:, :, None], axis=1)
    order = np.argsort(-draw.radius, kind="stable")
    position, found = np.array(bodies.position), np.zeros(count, bool)
    share = max(1, MEMBERS_AT_ONCE // (tries * int(bodies.sphere_count.max())))
    for begin in range(0, count, share):
        some = order[begin : begin + share]
        spot, has = _placed(bodies[some], points[some], region, there)
        position[some[has]], found[some[has]] = spot[has], True
        placed = replace(bodies, position=position)[some[has]]
        there = np.concatenate([there, members_at(placed)]) if has.any() else there
    return replace(bodies, position=position), found


def _placed(
    bodies: Bodies, points: Float64Array, region: Region, there: Float64Array
) -> tuple[Float64Array, BoolArray]:
    """Return the place of each body among its points (B, tries, 3), and which have one."""
    tries = points.shape[1]
    rows = np.repeat(np.arange(len(bodies)), tries)
    tried = replace(bodies[rows], position=points.reshape(-1, 3))
    count = bodies.sphere_count[rows]
    first = np.concatenate([[0], np.cumsum(count)])
    ball = members_at(tried)
    inside = within(region, ball)
    allowed = np.logical_and.reduceat(inside, first[:-1])
    ball[:, :3] = region.walls.seams.wrapped(ball[:, :3])
    box = np.array(region.bounds)
    chosen = start_places(ball, first, tries, allowed, there, box, region.walls.seams)
    spot = points[np.arange(len(bodies)), np.maximum(chosen, 0)]
    return spot, chosen >= 0


def within(region: Region, ball: Float64Array) -> BoolArray:
    """Tell which spheres (N, 4) [m] are wholly inside a region, shape (N,)."""
    position = region.walls.seams.wrapped(ball[:, :3])
    return region.encloses(position, np.ascontiguousarray(ball[:, 3]), 0.0)


def _points(region: Region, slab: Slab, count: int, rng: np.random.Generator) -> Float64Array:
    """Return points within the walls between two altitudes [m], up to ``count``, shape (n, 3)."""
    points = np.empty((0, 3))
    for _ in range(ROUNDS):
        missing = count - len(points)
        if missing <= 0:
            break
        # A slender cone fills little of its box.
        share = max(len(points) / count, 0.2)
        found = region.sample(rng, int(missing / share) + 64, slab.low, slab.high)
        points = np.concatenate([points, found])
    return points[:count]
