"""Spheres of different sizes change places where both together are then pressed less.

Hoy, arXiv 2506.16521 (2025), and others: such moves lead to packings that neither pushes nor chance find.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.jammed.push_kernels import Near, Soft, sorted_by_cell
from packgen.arrange.space.feature_kernels import Features, wall_gap
from packgen.arrange.space.walls import WallTable
from packgen.compiled import inner_loop, loop

SPAN = 4
"""A sphere may change places with one of the next fourth of all by size, as far as its list reaches."""


@inner_loop
def both_ways(near: Near):  # type: ignore[no-untyped-def]
    """Return the pairs of a list, sphere by sphere, each from both sides.

    Returns:
        (first neighbour of each, shape (N + 1,); neighbours; what takes each to its image [m], (K, 3)).
    """
    count = len(near.half)
    begin = np.zeros(count + 1, np.int64)
    for i in range(count):
        begin[i + 1] += near.begin[i + 1] - near.begin[i]
        for k in range(near.begin[i], near.begin[i + 1]):
            begin[near.item[k] + 1] += 1
    for k in range(len(near.first)):
        begin[near.first[k] + 1] += 1
        begin[near.second[k] + 1] += 1
    for i in range(count):
        begin[i + 1] += begin[i]
    fill = begin[:-1].copy()
    item, offset = np.empty(begin[count], np.int64), np.zeros((begin[count], 3))
    for i in range(count):
        for k in range(near.begin[i], near.begin[i + 1]):
            j = near.item[k]
            item[fill[i]], item[fill[j]] = j, i
            fill[i] += 1
            fill[j] += 1
    for k in range(len(near.first)):
        i, j = near.first[k], near.second[k]
        item[fill[i]], item[fill[j]] = j, i
        for axis in range(3):
            offset[fill[i], axis], offset[fill[j], axis] = near.offset[k, axis], -near.offset[k, axis]
        fill[i] += 1
        fill[j] += 1
    return begin, item, offset


@inner_loop
def energy_at(
    i: int,
    own: float,
    other: int,
    center: NDArray[np.float64],
    near: Near,
    around: tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]],
    features: Features,
) -> float:
    """Return the energy of a sphere in the place of sphere ``i`` [m3], all but that with sphere ``other``."""
    begin, item, offset = around
    half, total = near.half, 0.0
    for k in range(begin[i], begin[i + 1]):
        j = item[k]
        if j == other:
            continue
        dx = center[i, 0] - (center[j, 0] + offset[k, 0])
        dy = center[i, 1] - (center[j, 1] + offset[k, 1])
        dz = center[i, 2] - (center[j, 2] + offset[k, 2])
        apart, square = own + half[j], dx * dx + dy * dy + dz * dz
        if square < apart * apart:
            total += 0.5 * apart * (apart - math.sqrt(square)) ** 2
    kind, row = features
    for k in range(near.walls.begin[i], near.walls.begin[i + 1]):
        f = near.walls.item[k]
        gap = wall_gap(kind[f], row[f], center[i, 0], center[i, 1], center[i, 2], own)[0]
        if gap < 0.0:
            total += own * gap * gap
    return total


@loop
def exchange(
    spheres: Soft,
    walls: WallTable,
    grown: float,
    chance: NDArray[np.float64],
) -> int:
    """Let pairs of spheres change places where that lowers the energy.

    Args:
        spheres: The spheres; their arrays change.
        walls: The walls.
        grown: Common factor of all radii.
        chance: Two random numbers from 0 to 1 a try, shape (T, 2): one chooses a sphere, the other one of
            the spheres next in size.

    Returns:
        Number of changes.
    """
    center, _, radius, identity = spheres
    near = sorted_by_cell(spheres, grown, walls)
    around = both_ways(near)
    half, count, changes = near.half, len(radius), 0
    reach = half + near.margin
    by_size = np.argsort(half)
    span = max(count // SPAN, 1)
    for k in range(len(chance)):
        rank = min(int(chance[k, 0] * count), count - 1)
        other = min(rank + 1 + int(chance[k, 1] * span), count - 1)
        i, j = by_size[rank], by_size[other]
        if half[i] == half[j] or half[j] > reach[i] or half[i] > reach[j]:
            continue
        before = energy_at(i, half[i], j, center, near, around, walls.features)
        before += energy_at(j, half[j], i, center, near, around, walls.features)
        if before == 0.0:
            continue
        after = energy_at(i, half[j], j, center, near, around, walls.features)
        after += energy_at(j, half[i], i, center, near, around, walls.features)
        if after < before:
            half[i], half[j] = half[j], half[i]
            radius[i], radius[j] = radius[j], radius[i]
            identity[i], identity[j] = identity[j], identity[i]
            by_size[rank], by_size[other] = j, i
            changes += 1
    return changes
