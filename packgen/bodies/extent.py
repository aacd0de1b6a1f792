"""How wide a body is: the sieve that it passes, and whether it fits between walls."""

from __future__ import annotations

from functools import cache

import numpy as np

from packgen.arrays import Float64Array
from packgen.bodies.draw import random_turns
from packgen.bodies.placed import rotations

__all__ = ["fits_within", "sieve_size"]

TURNS = 1024
"""Orientations that are looked at first, spread at random over all rotations."""

BEST, ROUNDS, TRIES = 8, 60, 24
"""How many of them are made better, in how many rounds, and how many smaller turns each tries in a round."""

SHRINK = 0.8
"""Factor on these turns from one round to the next: the last ones are below 1e-5."""


def sieve_size(spheres: Float64Array) -> float:
    """Return the side of the smallest square hole that a body of spheres passes, turned as it likes [m].

    It is the smallest square that any projection of the body fits into, found by trial: of 1024 orientations
    the best are improved by ever smaller turns. It is too large by less than 1e-4 of itself.

    Args:
        spheres: Centres and radii [m], shape (N, 4).
    """
    return _least(spheres, np.array([1.0, 1.0, 0.0]))


def fits_within(spheres: Float64Array, room: Float64Array, slack: float = 1.0e-3) -> bool:
    """Return whether a body of spheres fits into a box, turned as it likes.

    Args:
        spheres: Centres and radii [m], shape (N, 4).
        room: Sides of the box [m], shape (3,); infinite where it has no walls.
        slack: Share of the room by which the body may be too wide: the search is not exact.
    """
    widest = 2.0 * float((np.linalg.norm(spheres[:, :3], axis=1) + spheres[:, 3]).max())
    if widest <= float(np.min(room)):
        return True
    return _least(spheres, 1.0 / np.asarray(room, np.float64)) <= 1.0 + slack


def _least(spheres: Float64Array, weight: Float64Array) -> float:
    """Return the least, over all orientations, of the largest of a body's extents times weights (3,)."""
    if len(spheres) == 1:
        return float(2.0 * spheres[0, 3] * weight.max())
    turn = _first_turns()
    size = _weighted(spheres, turn, weight)
    best = np.argsort(size, kind="stable")[:BEST]
    turn, size = turn[best], size[best]
    rng, step = np.random.default_rng(0), 0.25
    for _ in range(ROUNDS):
        tried = turn[:, None] + step * rng.uniform(-1.0, 1.0, (len(turn), TRIES, 4))
        tried = (tried / np.linalg.norm(tried, axis=2, keepdims=True)).reshape(-1, 4)
        found = _weighted(spheres, tried, weight).reshape(len(turn), TRIES)
        chosen = np.argmin(found, axis=1)
        better = found[np.arange(len(turn)), chosen] < size
        turn[better] = tried.reshape(len(turn), TRIES, 4)[np.arange(len(turn)), chosen][better]
        size[better] = found[np.arange(len(turn)), chosen][better]
        step *= SHRINK
    return float(size.min())


def _weighted(spheres: Float64Array, turn: Float64Array, weight: Float64Array) -> Float64Array:
    """Return the largest weighted extent of a body in each of some orientations (K, 4), shape (K,)."""
    size = np.zeros(len(turn))
    for start in range(0, len(turn), 256):
        some = slice(start, start + 256)
        place = np.einsum("kij,nj->kni", rotations(turn[some]), spheres[:, :3])
        extent = (place + spheres[:, 3:]).max(axis=1) - (place - spheres[:, 3:]).min(axis=1)
        size[some] = (extent * weight).max(axis=1)
    return size


@cache
def _first_turns() -> Float64Array:
    return random_turns(np.random.default_rng(0), TURNS)
