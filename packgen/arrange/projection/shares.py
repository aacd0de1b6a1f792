"""The shares of the threads in a layer: which spheres each moves, and the pairs that it needs for that.

A layer is cut across its longest side into stripes of about as many moving spheres, one a thread. Each thread
lists the pairs that its own spheres own, hands those that reach into another stripe to that one's thread, and
merges what it gets into its list in the order of the whole layer's: each sphere adds up the same pushes in
the same order, however many threads there are.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from packgen.arrange.neighbors.list_kernels import Pairs
from packgen.arrays import BoolArray, Float64Array, Int32Array, Int64Array
from packgen.compiled import inlined, inner_loop
from packgen.team import lent, meet

LOOKED, PACE = 2, 3
"""Places of what the threads tell of a look at the overlaps, and of how long they take; what they tell of
sweeps alternates before them."""

BINS = 2048
"""Bins by which the stripes are cut: as fine as their equality is."""

SLOWEST, TRUST = 0.25, 0.5
"""Least pace of a thread over that of the fastest; weight of the last sweeps against those before."""

ROWS_CUT = 0.6
"""Length along x over that along another axis that is cut all the same: there each row of cells would be
cut, and the threads would write to neighbouring places in memory."""


class Team(NamedTuple):
    """How the threads of a layer work together.

    Attributes:
        rank: Number of this one, from 0 on.
        size: How many they are.
        board: Where they meet; see ``team.meet``.
        told: What each tells the others of a sweep or a look, shape (4, size, 8), float64.
        known: What the first one tells the others, shape (4,), int64.
        outbox: Where each puts its pairs for the others, address and length, shape (size, 2),
            int64.
        ends: Share of the spheres that each and those before it have, shape (size,), float64.
    """

    rank: int
    size: int
    board: Int64Array
    told: Float64Array
    known: Int64Array
    outbox: Int64Array
    ends: Float64Array


@inner_loop
def agreed(team: Team, place: int, largest: float, strays: int):  # type: ignore[no-untyped-def]
    """Return the largest overlap and the strays of all threads, of which this one tells its own."""
    team.told[place, team.rank, 0], team.told[place, team.rank, 1] = largest, strays
    meet(team.board, team.size)
    total = 0
    for rank in range(team.size):
        largest = max(largest, team.told[place, rank, 0])
        total += int(team.told[place, rank, 1])
    return largest, total


@inner_loop
def stripes(ball: Float64Array, moving: int, box: Float64Array, ends: Float64Array) -> Int32Array:
    """Return the stripe that each sphere lies in, shape (N,); empty where there is but one.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        moving: How many move, which come first.
        box: Lowest and highest centre coordinates [m], shape (6,) or longer.
        ends: Share of the moving spheres in each stripe and those before it, rising to 1, shape (size,).
    """
    if len(ends) == 1:
        return np.empty(0, np.int32)
    axis, longest = 0, ROWS_CUT * (box[3] - box[0])
    for other in range(1, 3):
        if box[3 + other] - box[other] > longest:
            axis, longest = other, box[3 + other] - box[other]
    width = box[3 + axis] - box[axis]
    inverse = BINS / width if width > 0.0 else 0.0
    before = np.zeros(BINS + 1, np.int64)
    for i in range(moving):
        before[min(int((ball[i, axis] - box[axis]) * inverse), BINS - 1) + 1] += 1
    for k in range(BINS):
        before[k + 1] += before[k]
    of_bin, number = np.empty(BINS, np.int32), 0
    for k in range(BINS):
        while number < len(ends) - 1 and before[k] >= ends[number] * moving:
            number += 1
        of_bin[k] = number
    stripe = np.empty(len(ball), np.int32)
    for i in range(len(ball)):
        stripe[i] = of_bin[min(int((ball[i, axis] - box[axis]) * inverse), BINS - 1)]
    return stripe


@inner_loop
def paced(ends: Float64Array, spheres: Float64Array, spent: Float64Array) -> None:
    """Move the ends of the stripes so that all threads take as long: a busy or slow core gets less.

    Args:
        ends: Share of the moving spheres in each stripe and those before it, rising to 1, shape (size,).
            Changes.
        spheres: Spheres that each thread has had, shape (size,).
        spent: How long it has taken for a sweep over them, shape (size,); 0: it is not known.
    """
    size, total, fastest = len(ends), 0.0, 0.0
    pace = np.empty(size)
    for rank in range(size):
        if spent[rank] <= 0.0 or spheres[rank] <= 0.0:
            return
        pace[rank] = spheres[rank] / spent[rank]
        fastest = max(fastest, pace[rank])
    for rank in range(size):
        # None is thought to be slower than a quarter of the fastest: it may be busy for a moment only.
        pace[rank] = max(pace[rank], SLOWEST * fastest)
        total += pace[rank]
    old, new = 0.0, 0.0
    for rank in range(size - 1):
        share = ends[rank] - old
        old = ends[rank]
        new += (1.0 - TRUST) * share + TRUST * pace[rank] / total
        ends[rank] = new


@inner_loop
def own_spheres(stripe: Int32Array, rank: int, moving: int) -> Int32Array:
    """Return the moving spheres of a stripe, rising; all where there is but one."""
    own, count = np.empty(moving, np.int32), 0
    for i in range(moving):
        own[count] = i
        count += len(stripe) == 0 or stripe[i] == rank
    return own[:count]


@inner_loop
def exchanged(  # type: ignore[no-untyped-def]
    pairs: Pairs, stripe: Int32Array, moving: int, team: Team
):
    """Hand pairs to the threads of other stripes, and merge theirs; see the head of the module.

    Args:
        pairs: The pairs that the own spheres own, in the order of the whole layer's.
        stripe: Stripe of each sphere, shape (N,); empty where there is but one.
        moving: How many spheres move, which come first.
        team: The threads, of which each has the stripe of its rank.

    Returns:
        The arrays of the ``Pairs`` with any own sphere.
    """
    owner, neighbor = pairs
    rank, size, outbox = team.rank, team.size, team.outbox
    if size == 1:
        return owner, neighbor
    sent, out, left = np.empty((len(owner) + 1, 2), np.int32), 0, 0
    for k in range(len(owner)):
        i, j = owner[k], neighbor[k]
        sent[out, 0], sent[out, 1] = i, j
        across = j < moving and stripe[j] != rank
        out += across
        owner[left], neighbor[left] = i, j
        # Of a fixed sphere's pairs those alone are its thread's whose other sphere is.
        left += i < moving or not across
    outbox[rank, 0], outbox[rank, 1] = sent.ctypes.data, out
    meet(team.board, size)
    owner, neighbor = owner[:left], neighbor[:left]
    for other in range(size):
        if other != rank and outbox[other, 1] > 0:
            got = taken(lent(outbox[other, 0], outbox[other, 1], 2), stripe, rank)
            if len(got) > 0:
                owner, neighbor = merged(owner, neighbor, got)
    meet(team.board, size)
    sent[0, 0] = 0  # alive until all have read it
    return owner, neighbor


@inner_loop
def taken(sent: Int32Array, stripe: Int32Array, rank: int) -> Int32Array:
    """Return those of another thread's pairs that are for this one, shape (P, 2)."""
    count = 0
    for k in range(len(sent)):
        count += stripe[sent[k, 1]] == rank
    got = np.empty((count, 2), np.int32)
    count = 0
    for k in range(len(sent)):
        if stripe[sent[k, 1]] == rank:
            got[count, 0], got[count, 1] = sent[k, 0], sent[k, 1]
            count += 1
    return got


@inner_loop
def merged(owner: Int32Array, neighbor: Int32Array, got: Int32Array):  # type: ignore[no-untyped-def]
    """Return two lists of pairs as one, both by rising owner; none owns pairs of both."""
    total = len(owner) + len(got)
    first, second = np.empty(total, np.int32), np.empty(total, np.int32)
    a, b = 0, 0
    for k in range(total):
        if b >= len(got) or (a < len(owner) and owner[a] < got[b, 0]):
            first[k], second[k] = owner[a], neighbor[a]
            a += 1
        else:
            first[k], second[k] = got[b, 0], got[b, 1]
            b += 1
    return first, second


@inlined
def has_own(first: Int32Array, second: Int32Array, stripe: Int32Array, moving: int, rank: int) -> BoolArray:
    """Tell which pairs have a moving sphere of a stripe, shape (P,); all where there is but one stripe."""
    found = np.empty(len(first), np.bool_)
    for k in range(len(first)):
        i, j = first[k], second[k]
        found[k] = (
            len(stripe) == 0 or (i < moving and stripe[i] == rank) or (j < moving and stripe[j] == rank)
        )
    return found
