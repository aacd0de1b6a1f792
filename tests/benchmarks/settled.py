"""What LIGGGHTS makes of a bed: its verdict; the bed as it settles it; that bed trimmed to no overlap."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

from exporters import liggghts
from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.check import near_pairs, wall_clearance
from packgen.settling import Settled
from packgen.settling import settle as packgen_settle
from packgen.validation import Limits, SolverReport, validate
from packgen.validation.still import free_fall_time

HAIR = 1.0e-12  # of a radius: rounding must not leave an overlap


def judge(bed: Bed, free_fall_times: float) -> SolverReport:
    """Return what LIGGGHTS measures of a bed in a gravity run."""
    limits = Limits(free_fall_times=free_fall_times, work_budget=1.0e18, still_speed=0.0, silence_max=3600.0)
    with tempfile.TemporaryDirectory(prefix="packgen_") as scratch:
        folder = Path(scratch)
        liggghts.write(bed, folder, liggghts.Options())
        return validate(bed, folder, solver="liggghts", limits=limits)


def settle(bed: Bed, free_fall_times: float | None = None) -> Bed:
    """Return a bed as LIGGGHTS leaves it after some times sqrt(2 r / g); None: once it is still.

    Raises:
        SolverError: LIGGGHTS stopped, or lost spheres.
    """
    return settled(bed, free_fall_times).bed


def settled(bed: Bed, free_fall_times: float | None = None) -> Settled:
    """Return what `settle` does, with how it came about."""
    time = None if free_fall_times is None else free_fall_times * free_fall_time(bed)
    with tempfile.TemporaryDirectory(prefix="packgen_") as scratch:
        folder = Path(scratch)
        liggghts.write(bed, folder, liggghts.Options())
        found = packgen_settle(bed, folder, solver="liggghts", time=time)
    return replace(found, bed=replace(found.bed, tolerance=None), restart=None)


def trimmed(bed: Bed) -> Bed:
    """Return a bed without overlap: the same centres, each radius smaller by as little as need be.

    First every radius gives way to half of its deepest overlap (to all of one with a wall); then each in turn
    grows back until it touches something, at most to what it was.
    """
    first, second, distance = _contacts(bed)
    walls = wall_clearance(bed.container, bed.position, bed.radius * (1.0 + HAIR))
    deepest = np.zeros(bed.count)
    overlap = np.maximum(bed.radius[first] + bed.radius[second] - distance, 0.0)
    for end in (first, second):
        np.maximum.at(deepest, end, overlap)
    radius = np.minimum(bed.radius - 0.5 * deepest, walls)
    limit = np.minimum(bed.radius, walls)
    ends = np.concatenate([first, second])
    order = np.argsort(ends, kind="stable")
    others, lengths = np.concatenate([second, first])[order], np.concatenate([distance, distance])[order]
    start = np.searchsorted(ends[order], np.arange(bed.count + 1))
    for index in range(bed.count):
        mine = slice(start[index], start[index + 1])
        room = lengths[mine] - radius[others[mine]]
        radius[index] = min(limit[index], float(room.min(initial=np.inf)))
    return replace(bed, radius=radius * (1.0 - HAIR), tolerance=None)


def _contacts(bed: Bed) -> tuple[Int64Array, Int64Array, Float64Array]:
    """Return the pairs that overlap: their spheres and the distances of their centres [m], each (P,)."""
    found = [
        (pairs.first, pairs.second, pairs.gap + bed.radius[pairs.first] + bed.radius[pairs.second])
        for pairs in near_pairs(bed.position, bed.radius, period=bed.container.period)
    ]
    if not found:
        none = np.zeros(0, np.int64)
        return none, none, np.zeros(0)
    first, second, distance = (np.concatenate(parts) for parts in zip(*found, strict=True))
    return first, second, distance
