"""What no arrangement can exceed, by simple reasons."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np

from packgen.arrange.optimal.descend import descend
from packgen.arrange.optimal.room import Room
from packgen.arrays import Float64Array, Int64Array
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube, cube_root, matrix_product

KEPLER = math.pi / math.sqrt(18.0)
"""Largest solid fraction of equal spheres in space: boxes fill it, and so no box holds more."""

SETS_MAX = 200_000
"""Numbers of spheres of each size that are looked at, at most."""

ROUNDING = 1.0e-12


@dataclass(frozen=True, slots=True)
class Bound:
    """An upper bound, and where it is from."""

    value: float
    reason: str


def inner_radius(room: Room) -> float:
    """Return the radius of the largest sphere in a room [m]: a linear programme finds it."""
    if room.radius > 0.0:
        return room.radius
    size = float(np.ptp(room.bounds, axis=0).min())
    middle = room.points(100, np.random.default_rng(0)).mean(axis=0)[None]
    return 0.25 * size * descend(room, np.array([0.25 * size]), middle).factor


def pair_factor(room: Room, first: float, second: float) -> float:
    """Return the largest common factor at which two radii fit into the box around a room: three lengths.

    Centres that keep from the walls are apart by at most the diagonal of what is left of the box.
    """
    extent, total = np.ptp(room.bounds, axis=0), first + second
    if room.radius > 0.0:
        return 2.0 * room.radius / (2.0 * total)
    low, high = 0.0, float(extent.min()) / total
    for _ in range(100):
        middle = 0.5 * (low + high)
        left = extent - middle * total
        fits = float((left * left).sum()) >= (middle * total) ** 2
        low, high = (middle, high) if fits else (low, middle)
    return high


def scale_bound(room: Room, radius: Float64Array, *, is_box: bool) -> Bound:
    """Return what the common factor of some radii cannot exceed.

    Args:
        room: The room.
        radius: Radii [m], shape (N,).
        is_box: Whether the room fills space with copies of itself.
    """
    solid = float((UNIT_VOLUME * cube(radius)).sum())
    equal = bool((radius == radius[0]).all())
    densest = KEPLER if is_box and equal and len(radius) > 1 else 1.0
    by_volume = "no packing of equal spheres is denser" if densest < 1.0 else "volume of the container"
    largest = np.sort(radius)[::-1]
    found = [
        Bound(float(cube_root(densest * room.volume / solid)), by_volume),
        Bound(inner_radius(room) / float(largest[0]), "its largest sphere alone"),
    ]
    if len(radius) > 1:
        found.append(Bound(pair_factor(room, *largest[:2].tolist()), "its two largest spheres alone"))
    return min(found, key=lambda each: each.value)


def possible_sets(room: Room, size: Float64Array, number: Int64Array) -> Int64Array | None:
    """Return numbers of spheres of each size that may fit, those of the largest volume first.

    Args:
        room: The room.
        size: Radii, each once [m], shape (S,).
        number: How many spheres there are of each, shape (S,).

    Returns:
        Numbers, shape (sets, S); None: they are too many to be looked at.
    """
    if float(np.prod(number + 1.0)) > SETS_MAX:
        return None
    sets = np.array(list(product(*[range(each + 1) for each in number.tolist()])), np.int64)
    inner = inner_radius(room)
    for k in range(len(size)):
        if size[k] > inner * (1.0 + ROUNDING):
            sets = sets[sets[:, k] == 0]
        for other in range(k, len(size)):
            if pair_factor(room, float(size[k]), float(size[other])) < 1.0 - ROUNDING:
                both = sets[:, k] > 1 if other == k else (sets[:, k] > 0) & (sets[:, other] > 0)
                sets = sets[~both]
    volume = matrix_product(sets, UNIT_VOLUME * cube(size))
    kept = volume <= room.volume
    return np.asarray(sets[kept][np.argsort(-volume[kept], kind="stable")])
