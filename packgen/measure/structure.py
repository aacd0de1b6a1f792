"""A bed as a structure: its spheres' weights, and the contacts that may carry them."""

from __future__ import annotations

from itertools import product

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array, unique_rows
from packgen.bed import Bed, pair_coefficient
from packgen.check import near_pairs
from packgen.check.parts import nearest_part
from packgen.check.wall_contacts import wall_contacts
from packgen.measure.hertz import sphere_mass, wall_type
from packgen.programmes.forces import FIXED, Structure


def structure_of(bed: Bed, gap: float, chosen: BoolArray | None = None) -> Structure:
    """Return the spheres of a bed and their contacts, walls and seams included.

    Args:
        bed: The bed; each of its spheres counts as a body.
        gap: Largest gap of a contact, as a fraction of the smaller radius.
        chosen: Spheres that count, shape (N,); the others they touch are fixed. None: all.

    Returns:
        The structure of the chosen spheres, in their order.
    """
    index, part = _neighbourhood(bed, gap, chosen)
    position, radius = bed.position[index], bed.radius[index]
    first, second, normal = pair_contacts(position, radius, bed.container.period, gap)
    at_wall, to_wall, away = wall_contacts(bed.container, position, radius, gap)
    types = bed.type_index[index]
    table = friction_table(bed)
    foot = position[at_wall] + away[:, None] * to_wall
    of_wall = nearest_part(bed.container, foot, radius[at_wall]) if bed.container.parts else None
    wall = wall_type(bed, len(at_wall), of_wall)
    friction = np.concatenate([table[types[first], types[second]], table[types[at_wall], wall]])
    first, normal = np.concatenate([first, at_wall]), np.concatenate([normal, to_wall])
    second = np.concatenate([second, np.full(len(at_wall), FIXED)])
    # A sphere outside comes second, and is fixed; two of them are no contact.
    turned = ~part[first]
    first, second = np.where(turned, second, first), np.where(turned, first, second)
    normal = np.where(turned[:, None], -normal, normal)
    kept = (first != FIXED) & part[first]
    place = np.append(np.where(part, np.cumsum(part) - 1, FIXED), FIXED)
    inside = index[part]
    mass = sphere_mass(bed)[inside]
    return Structure(
        radius=bed.radius[inside],
        weight=mass[:, None] * bed.acceleration,
        mass=mass,
        first=place[first[kept]],
        second=place[second[kept]],
        normal=np.ascontiguousarray(normal[kept]),
        friction=friction[kept],
    )


def friction_table(bed: Bed) -> Float64Array:
    """Return the friction of each pair of the bed's materials, as decks have it, shape (M, M)."""
    own = [each.friction for each in bed.materials]
    return np.array([[pair_coefficient(first, second) for second in own] for first in own])


def pair_contacts(
    position: Float64Array,
    radius: Float64Array,
    period: tuple[float | None, float | None, float | None],
    gap: float,
) -> tuple[Int64Array, Int64Array, Float64Array]:
    """Return all contacts of two spheres, each image across a seam as a contact of its own.

    Args:
        position: Centres [m], shape (N, 3).
        radius: Radii [m], shape (N,).
        period: Length after which the bed repeats along each axis [m]; None where it does not.
        gap: Largest gap, as a fraction of the smaller radius.

    Returns:
        The spheres of each contact, both (C,), and unit vectors from the first to the second, (C, 3).
        Spheres in one place push each other in no direction: they are no contact.
    """
    found = [
        np.stack([pairs.first, pairs.second], axis=1)
        for pairs in near_pairs(position, radius, gap_fraction=gap, period=period)
    ]
    if not found:
        return np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 3))
    pair = np.sort(np.concatenate(found), axis=1)
    lengths = np.array([each or 0.0 for each in period])
    wraps = lengths > 0.0
    if wraps.any():  # a pair that touches across two seams came twice
        pair = pair[unique_rows(pair)[0]]
    first, second = pair.T
    apart = position[second] - position[first]
    apart[:, wraps] -= lengths[wraps] * np.round(apart[:, wraps] / lengths[wraps])
    reach = radius[first] + radius[second] + gap * np.minimum(radius[first], radius[second])
    parts = []
    for shift in product(*[(-1, 0, 1) if wrap else (0,) for wrap in wraps]):
        way = apart + np.array(shift) * lengths
        # A sphere's two images at opposite sides are one contact: with itself.
        length = np.linalg.norm(way, axis=1)
        near = (length > 0.0) & (length <= reach) & ((first != second) | (shift > (0, 0, 0)))
        parts.append((first[near], second[near], way[near]))
    first, second, way = (np.concatenate(each) for each in zip(*parts, strict=True))
    return first, second, way / np.linalg.norm(way, axis=1)[:, None]


def _neighbourhood(bed: Bed, gap: float, chosen: BoolArray | None) -> tuple[Int64Array, BoolArray]:
    """Return chosen spheres and all that may touch them: indices (K,), and which of them are chosen, (K,)."""
    if chosen is None:
        return np.arange(bed.count), np.ones(bed.count, dtype=bool)
    low, high = bed.container.bounds
    lengths = np.where(bed.container.periodic, high - low, 0.0)
    reach = 2.0 * (1.0 + gap) * float(bed.radius.max())
    corners = bed.position[chosen].min(axis=0), bed.position[chosen].max(axis=0)
    middle, half = 0.5 * (corners[0] + corners[1]), 0.5 * (corners[1] - corners[0]) + reach
    apart = np.abs(bed.position - middle)
    apart = np.where(lengths > 0.0, np.minimum(apart, np.abs(lengths - apart)), apart)
    near = (apart <= half).all(axis=1) | chosen
    index = np.flatnonzero(near)
    return index, chosen[index]
