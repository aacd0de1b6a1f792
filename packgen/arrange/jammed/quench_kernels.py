"""Soft spheres brought to rest by FIRE (Bitzek and others, Phys. Rev. Lett. 97 (2006) 170201) in one loop.

Each sphere's mass is the stiffness of what holds it, so that one step of time suits all sizes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.jammed.push_kernels import Near, Soft, Strain, push, sorted_by_cell
from packgen.arrange.space.walls import WallTable
from packgen.compiled import inner_loop, loop

STEP_FIRST, STEP_MAX = 0.3, 1.0
"""First and longest step of time: stable below sqrt(2)."""

MIXING, MIXING_FALL = 0.1, 0.99
LONGER, SHORTER, PATIENCE = 1.1, 0.5, 5
"""Share of the force in the velocity, and factors of the step: the authors' own."""

STRIDE = 0.2
"""Longest way in a step, in radii."""


@inner_loop
def flow(
    spheres: Soft, near: Near, force: NDArray[np.float64], pace: NDArray[np.float64]
) -> tuple[bool, float]:
    """Move all spheres by one step.

    Args:
        spheres: The spheres; centres and velocities change.
        near: What is near them.
        force: Force upon each [m2], shape (N, 3).
        pace: Step of time, mixing, and steps downhill in a row, shape (3,); changes.

    Returns:
        (whether new lists are needed, sum of the squares of all forces [m4]).
    """
    center, velocity, _, _ = spheres
    half, mass, anchor, margin = near.half, near.mass, near.anchor, near.margin
    power = speed = strength = total = 0.0
    for i in range(len(half)):
        fx, fy, fz = force[i, 0], force[i, 1], force[i, 2]
        vx, vy, vz = velocity[i, 0], velocity[i, 1], velocity[i, 2]
        square = fx * fx + fy * fy + fz * fz
        power += fx * vx + fy * vy + fz * vz
        speed += mass[i] * (vx * vx + vy * vy + vz * vz)
        strength += square / mass[i]
        total += square
    mixing, kept = 0.0, 0.0
    if power >= 0.0:
        pace[2] += 1.0
        if pace[2] > PATIENCE:
            pace[0] = min(pace[0] * LONGER, STEP_MAX)
            pace[1] *= MIXING_FALL
        kept = 1.0 - pace[1]
        mixing = pace[1] * math.sqrt(speed / max(strength, 1e-300))
    else:
        pace[0], pace[1], pace[2] = pace[0] * SHORTER, MIXING, 0.0
    time = pace[0]
    outrun = False
    for i in range(len(half)):
        factor = (mixing + time) / mass[i]
        vx = kept * velocity[i, 0] + factor * force[i, 0]
        vy = kept * velocity[i, 1] + factor * force[i, 1]
        vz = kept * velocity[i, 2] + factor * force[i, 2]
        limit = STRIDE * half[i] / time
        square = vx * vx + vy * vy + vz * vz
        if square > limit * limit:
            shorten = limit / math.sqrt(square)
            vx, vy, vz = vx * shorten, vy * shorten, vz * shorten
        velocity[i, 0], velocity[i, 1], velocity[i, 2] = vx, vy, vz
        center[i, 0] += time * vx
        center[i, 1] += time * vy
        center[i, 2] += time * vz
        dx, dy, dz = center[i, 0] - anchor[i, 0], center[i, 1] - anchor[i, 1], center[i, 2] - anchor[i, 2]
        outrun |= dx * dx + dy * dy + dz * dz > margin[i] * margin[i]
    return outrun, total


@loop
def quench(
    spheres: Soft,
    walls: WallTable,
    grown: float,
    pace: NDArray[np.float64],
    steps: int,
    calm: float,
    free: float,
) -> tuple[int, float, float, float]:
    """Let soft spheres move until they are at rest.

    Args:
        spheres: The spheres; their arrays change.
        walls: The walls.
        grown: Common factor of all radii.
        pace: See ``flow``; changes.
        steps: Steps at most.
        calm: Residual at which they are at rest.
        free: Largest overlap of spheres that press nothing, as a fraction of the smaller radius.

    Returns:
        (steps done; residual: the root mean square force upon a sphere over that at a contact, 0 where
        nothing is pressed; pressure: see ``Strain``, over the number of spheres; largest overlap).
    """
    count = len(spheres.radius)
    force = np.empty((count, 3))
    residual, strain, outrun = 0.0, Strain(0, 0.0, 0.0, 0.0), True
    near = sorted_by_cell(spheres, grown, walls)
    for number in range(steps):
        if outrun and number > 0:
            near = sorted_by_cell(spheres, grown, walls)
        strain = push(spheres.center, near, walls.features, force)
        if strain.worst <= free:
            return number + 1, 0.0, 0.0, 0.0
        outrun, total = flow(spheres, near, force, pace)
        residual = math.sqrt(total / count * strain.contacts / strain.squares)
        if residual <= calm:
            return number + 1, residual, strain.pressure / count, strain.worst
    return steps, residual, strain.pressure / count, strain.worst
