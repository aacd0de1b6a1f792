"""The loops of `packgen.programmes.forces`: over the contacts, in the order given, so that sums are the same.

Lengths are in a sphere's radii where torques are concerned: a torque is divided by its sphere's radius, and
a sphere's moment of inertia is 0.4 of its mass then.
"""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.compiled import inlined, inner_loop, loop

SPIN = 2.5  # m r^2 / I of a sphere
PASSES = 50  # steps from one look at what is left to the next
POWER_STEPS = 30
MARGIN = 1.05  # on the largest curvature, which power steps find from below


@inlined
def cross(a: Float64Array, b0: float, b1: float, b2: float) -> tuple[float, float, float]:
    """Return the product of two vectors."""
    return a[1] * b2 - a[2] * b1, a[2] * b0 - a[0] * b2, a[0] * b1 - a[1] * b0


@inner_loop
def _scatter(
    first: Int64Array,
    second: Int64Array,
    normal: Float64Array,
    force: Float64Array,
    left: Float64Array,
    torque: Float64Array,
) -> None:
    """Add the contacts' forces and torques to their spheres'."""
    for contact in range(len(first)):
        one, other = first[contact], second[contact]
        f0, f1, f2 = force[contact, 0], force[contact, 1], force[contact, 2]
        t0, t1, t2 = cross(normal[contact], f0, f1, f2)
        left[one, 0] -= f0
        left[one, 1] -= f1
        left[one, 2] -= f2
        torque[one, 0] -= t0
        torque[one, 1] -= t1
        torque[one, 2] -= t2
        if other >= 0:
            # The opposite force at the opposite arm: the torque, a radius apart, has the same sign.
            left[other, 0] += f0
            left[other, 1] += f1
            left[other, 2] += f2
            torque[other, 0] -= t0
            torque[other, 1] -= t1
            torque[other, 2] -= t2


@inner_loop
def _slope(
    one: int,
    other: int,
    n: Float64Array,
    left: Float64Array,
    torque: Float64Array,
    lightness: Float64Array,
) -> tuple[float, float, float]:
    """Return how what is left grows with a contact's force: the relative acceleration of its two sides."""
    a, spin = lightness[one], SPIN * lightness[one]
    g0, g1, g2 = -a * left[one, 0], -a * left[one, 1], -a * left[one, 2]
    s0, s1, s2 = spin * torque[one, 0], spin * torque[one, 1], spin * torque[one, 2]
    if other >= 0:
        a, spin = lightness[other], SPIN * lightness[other]
        g0 += a * left[other, 0]
        g1 += a * left[other, 1]
        g2 += a * left[other, 2]
        s0 += spin * torque[other, 0]
        s1 += spin * torque[other, 1]
        s2 += spin * torque[other, 2]
    c0, c1, c2 = cross(n, s0, s1, s2)
    return g0 + c0, g1 + c1, g2 + c2


@inner_loop
def _into_cone(n: Float64Array, mu: float, f0: float, f1: float, f2: float) -> tuple[float, float, float]:
    """Return the point of a friction cone that is nearest to a force."""
    along = f0 * n[0] + f1 * n[1] + f2 * n[2]
    t0, t1, t2 = f0 - along * n[0], f1 - along * n[1], f2 - along * n[2]
    across = np.sqrt(t0 * t0 + t1 * t1 + t2 * t2)
    # Pulls come first: without friction a pull along the normal lies on the bounds of both cones.
    if mu * across <= -along:
        return 0.0, 0.0, 0.0
    if across <= mu * along:
        return f0, f1, f2
    height = (along + mu * across) / (1.0 + mu * mu)
    share = mu * height / across if across > 0.0 else 0.0
    return height * n[0] + share * t0, height * n[1] + share * t1, height * n[2] + share * t2


@loop
def what_is_left(
    first: Int64Array, second: Int64Array, normal: Float64Array, weight: Float64Array, force: Float64Array
) -> tuple[Float64Array, Float64Array]:
    """Return the unbalanced forces of spheres, and their torques divided by the radii, both (N, 3)."""
    left = weight.copy()
    torque = np.zeros_like(weight)
    _scatter(first, second, normal, force, left, torque)
    return left, torque


@loop
def curvature(
    first: Int64Array, second: Int64Array, normal: Float64Array, ease: Float64Array, lightness: Float64Array
) -> float:
    """Return the largest curvature of what is left over the contacts' forces, by power steps.

    Args:
        first: One sphere of each contact, shape (C,).
        second: The other one, negative for a fixed one, shape (C,).
        normal: Unit vectors from the first to the second, shape (C, 3).
        ease: What each contact's slope is multiplied by, shape (C,).
        lightness: Inverse masses, shape (N,).
    """
    contacts, spheres = len(first), len(lightness)
    force = np.empty((contacts, 3))
    for contact in range(contacts):
        for axis in range(3):
            # Any vector that is not across the sought one does; this one has no pattern.
            force[contact, axis] = ((contact * 3 + axis) * 0.6180339887498949) % 1.0 - 0.5
    size = 1.0
    for _ in range(POWER_STEPS):
        left = np.zeros((spheres, 3))
        torque = np.zeros((spheres, 3))
        _scatter(first, second, normal, force, left, torque)
        total = 0.0
        for contact in range(contacts):
            g0, g1, g2 = _slope(first[contact], second[contact], normal[contact], left, torque, lightness)
            g0, g1, g2 = ease[contact] * g0, ease[contact] * g1, ease[contact] * g2
            force[contact, 0], force[contact, 1], force[contact, 2] = g0, g1, g2
            total += g0 * g0 + g1 * g1 + g2 * g2
        size = np.sqrt(total)
        force /= size
    return MARGIN * size


@loop
def descend(
    first: Int64Array,
    second: Int64Array,
    normal: Float64Array,
    friction: Float64Array,
    lightness: Float64Array,
    weight: Float64Array,
    step: Float64Array,
    force: Float64Array,
    ahead: Float64Array,
    pace: float,
) -> float:
    """Take some accelerated steps, each projected into the cones; changes ``force`` and ``ahead``.

    Args:
        first: One sphere of each contact, shape (C,).
        second: The other one, negative for a fixed one, shape (C,).
        normal: Unit vectors from the first to the second, shape (C, 3).
        friction: Coefficients, shape (C,).
        lightness: Inverse masses, shape (N,).
        weight: Weights, shape (N, 3).
        step: What each contact's slope is multiplied by, shape (C,).
        force: Forces on the second spheres, shape (C, 3).
        ahead: Where the next slope is taken, shape (C, 3).
        pace: Nesterov's number; 1 at the start.

    Returns:
        The pace to go on with.
    """
    left = np.empty_like(weight)
    torque = np.empty_like(weight)
    last = np.empty_like(force)
    for _ in range(PASSES):
        left[:] = weight
        torque[:] = 0.0
        _scatter(first, second, normal, ahead, left, torque)
        uphill = 0.0
        for c in range(len(first)):
            g0, g1, g2 = _slope(first[c], second[c], normal[c], left, torque, lightness)
            p0, p1, p2 = ahead[c, 0], ahead[c, 1], ahead[c, 2]
            q0, q1, q2 = _into_cone(
                normal[c], friction[c], p0 - step[c] * g0, p1 - step[c] * g1, p2 - step[c] * g2
            )
            l0, l1, l2 = force[c, 0], force[c, 1], force[c, 2]
            last[c, 0], last[c, 1], last[c, 2] = l0, l1, l2
            force[c, 0], force[c, 1], force[c, 2] = q0, q1, q2
            rise = (p0 - q0) * (q0 - l0) + (p1 - q1) * (q1 - l1) + (p2 - q2) * (q2 - l2)
            uphill += rise / step[c]
        if uphill > 0.0:
            pace = 1.0
            ahead[:] = force
        else:
            following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * pace * pace))
            ahead[:] = force + (pace - 1.0) / following * (force - last)
            pace = following
    return pace
