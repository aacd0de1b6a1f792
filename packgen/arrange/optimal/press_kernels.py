"""Soft spheres pressed together by FIRE (Bitzek and others, Phys. Rev. Lett. 97 (2006) 170201), all pairs.

A linear programme for a few spheres costs as much as thousands of these steps. They tell which arrangements
are worth one: of two pressed to the same radii, the one with less energy has room for the larger ones.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.compiled import loop

STEP_FIRST, STEP_MAX = 0.1, 0.25
"""First and longest step of time, in those of the smallest contact."""

MIXING, MIXING_FALL, LONGER, SHORTER, PATIENCE = 0.1, 0.99, 1.1, 0.5, 5


@loop
def push(
    center: NDArray[np.float64],
    half: NDArray[np.float64],
    normal: NDArray[np.float64],
    offset: NDArray[np.float64],
    middle: NDArray[np.float64],
    ball: float,
    force: NDArray[np.float64],
) -> float:
    """Return the energy of overlaps, the sum of squares of relative ones, and its forces.

    Args:
        center: Centres, shape (N, 3).
        half: Radii, shape (N,).
        normal: Outward normals of planes, shape (P, 3).
        offset: Their offsets, shape (P,).
        middle: Centre of a ball, shape (3,).
        ball: Its radius; 0: there is none.
        force: Filled, shape (N, 3).
    """
    force[:] = 0.0
    energy = 0.0
    for i in range(len(half)):
        x, y, z, own = center[i, 0], center[i, 1], center[i, 2], half[i]
        for j in range(i):
            dx, dy, dz = x - center[j, 0], y - center[j, 1], z - center[j, 2]
            apart, square = own + half[j], dx * dx + dy * dy + dz * dz
            if square >= apart * apart or square == 0.0:
                continue
            distance = math.sqrt(square)
            depth = 1.0 - distance / apart
            energy += depth * depth
            pull = 2.0 * depth / (apart * distance)
            force[i, 0] += pull * dx
            force[i, 1] += pull * dy
            force[i, 2] += pull * dz
            force[j, 0] -= pull * dx
            force[j, 1] -= pull * dy
            force[j, 2] -= pull * dz
        for k in range(len(offset)):
            gap = offset[k] - normal[k, 0] * x - normal[k, 1] * y - normal[k, 2] * z
            if gap < own:
                depth = 1.0 - gap / own
                energy += depth * depth
                for axis in range(3):
                    force[i, axis] -= 2.0 * depth / own * normal[k, axis]
        if ball > 0.0:
            dx, dy, dz = x - middle[0], y - middle[1], z - middle[2]
            distance = math.sqrt(dx * dx + dy * dy + dz * dz)
            depth = 1.0 - (ball - distance) / own
            if depth > 0.0 and distance > 0.0:
                energy += depth * depth
                pull = 2.0 * depth / (own * distance)
                force[i, 0] -= pull * dx
                force[i, 1] -= pull * dy
                force[i, 2] -= pull * dz
    return energy


@loop
def press(
    center: NDArray[np.float64],
    half: NDArray[np.float64],
    normal: NDArray[np.float64],
    offset: NDArray[np.float64],
    middle: NDArray[np.float64],
    ball: float,
    steps: int,
    calm: float,
) -> float:
    """Let soft spheres come to rest; return the energy that is left.

    Args:
        center: Centres, shape (N, 3); change.
        half: Radii, shape (N,).
        normal: Outward normals of planes, shape (P, 3).
        offset: Their offsets, shape (P,).
        middle: Centre of a ball, shape (3,).
        ball: Its radius; 0: there is none.
        steps: Steps at most.
        calm: Sum of the squares of the forces, over the energy, at which they are at rest.
    """
    count, smallest = len(half), half.min()
    force, velocity = np.zeros((count, 3)), np.zeros((count, 3))
    time, mixing, downhill = STEP_FIRST * smallest, MIXING, 0
    energy = push(center, half, normal, offset, middle, ball, force)
    for _ in range(steps):
        power = speed = strength = 0.0
        for i in range(count):
            for axis in range(3):
                power += force[i, axis] * velocity[i, axis]
                speed += velocity[i, axis] * velocity[i, axis]
                strength += force[i, axis] * force[i, axis]
        if energy < 1e-20 or strength * smallest * smallest <= calm * energy:
            break
        if power >= 0.0:
            downhill += 1
            if downhill > PATIENCE:
                time = min(time * LONGER, STEP_MAX * smallest)
                mixing *= MIXING_FALL
            share = mixing * math.sqrt(speed / max(strength, 1e-300))
            for i in range(count):
                for axis in range(3):
                    velocity[i, axis] = (1.0 - mixing) * velocity[i, axis] + share * force[i, axis]
        else:
            velocity[:] = 0.0
            time, mixing, downhill = time * SHORTER, MIXING, 0
        for i in range(count):
            for axis in range(3):
                velocity[i, axis] += time * force[i, axis]
                center[i, axis] += time * velocity[i, axis]
        energy = push(center, half, normal, offset, middle, ball, force)
    return energy
