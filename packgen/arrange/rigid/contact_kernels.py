"""How two bodies, or a body and a wall, part where their spheres overlap: impulses at points of contact.

Position-based dynamics of rigid bodies (Mueller et al., Detailed rigid body simulation with extended position
based dynamics, Comput. Graph. Forum 39 (2020) 101): an impulse p at a point with the arm a from the centre of
mass moves a body by p / m and turns it by I^-1 (a x p). Contacts come one after the other, and each sees what
the ones before have done: many spheres of two bodies may touch at once, and no push counts twice.

Vectors are tuples of three numbers, which the compiler keeps in registers, and arrays come one by one: taken
out of a tuple for each pair they would have to be counted each time. What stays has a body of its own, the
last one, whose mass has no end.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.projection.push_kernels import parting
from packgen.compiled import inlined

Vector = tuple[float, float, float]

Row = int | np.uint64
"""Of a body or sphere; without a sign no code is needed for negative ones."""


@inlined
def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product of a and b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def dot(a: Vector, b: Vector) -> float:
    """Return the scalar product of a and b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def along(a: Vector, length: float, n: Vector) -> Vector:
    """Return a + length n."""
    return a[0] + length * n[0], a[1] + length * n[1], a[2] + length * n[2]


@inlined
def times(tensor: NDArray[np.float64], b: Row, v: Vector) -> Vector:
    """Return the product of a symmetric tensor, row b of xx yy zz xy xz yz, and a vector."""
    return (
        tensor[b, 0] * v[0] + tensor[b, 3] * v[1] + tensor[b, 4] * v[2],
        tensor[b, 3] * v[0] + tensor[b, 1] * v[1] + tensor[b, 5] * v[2],
        tensor[b, 4] * v[0] + tensor[b, 5] * v[1] + tensor[b, 2] * v[2],
    )


@inlined
def give(b: Row, arm: Vector, n: Vector, slack: NDArray[np.float64]) -> float:
    """Return how far a body's point at an arm gives way along n to a unit impulse there.

    Args:
        b: The body.
        arm: From its centre of mass [m].
        n: Unit vector.
        slack: Inverse tensors of inertia, xx yy zz xy xz yz, and one over the mass, shape (B + 1, 7).
    """
    lever = cross(arm, n)
    way: float = slack[b, 6] + dot(lever, times(slack, b, lever))
    return way


@inlined
def push_body(b: Row, arm: Vector, p: Vector, slack: NDArray[np.float64], push: NDArray[np.float64]) -> None:
    """Move and turn a body by an impulse p at an arm.

    Args:
        b: The body.
        arm: From its centre of mass [m].
        p: The impulse.
        slack: See ``give``.
        push: How far each body has been moved [m] and turned [rad] in this sweep, shape (B + 1, 6); changes.
    """
    turn = times(slack, b, cross(arm, p))
    push[b, 0] += slack[b, 6] * p[0]
    push[b, 1] += slack[b, 6] * p[1]
    push[b, 2] += slack[b, 6] * p[2]
    push[b, 3] += turn[0]
    push[b, 4] += turn[1]
    push[b, 5] += turn[2]


@inlined
def drift(b: Row, arm: Vector, motion: NDArray[np.float64]) -> Vector:
    """Return how far a body's point at an arm has come by a motion, a shift [m] and a small turn [rad]."""
    turn = cross((motion[b, 3], motion[b, 4], motion[b, 5]), arm)
    return motion[b, 0] + turn[0], motion[b, 1] + turn[1], motion[b, 2] + turn[2]


@inlined
def normal_of(i: Row, j: Row, d: Vector, reach: float) -> tuple[Vector, float]:
    """Return the unit vector along d, and its length; of coincident centres one by the spheres' numbers."""
    distance = math.sqrt(dot(d, d))
    length = distance
    if distance < 1e-9 * reach:
        d = parting(i, j)
        length = math.sqrt(dot(d, d))
    return (d[0] / length, d[1] / length, d[2] / length), distance


@inlined
def rub(
    bodies: tuple[Row, Row],
    arms: tuple[Vector, Vector],
    n: Vector,
    most: float,
    slack: NDArray[np.float64],
    motion: NDArray[np.float64],
    push: NDArray[np.float64],
) -> None:
    """Take from the sliding of a contact what its friction holds.

    Args:
        bodies: The two bodies.
        arms: From the centre of each to the contact [m].
        n: Unit normal.
        most: Largest impulse, by Coulomb's law.
        slack: See ``give``.
        motion: How far each body came in this sweep before it was pushed, shape (B + 1, 6).
        push: See ``push_body``; changes.
    """
    a, b = bodies
    arm, other = arms
    sliding = along(drift(a, arm, motion), 1.0, drift(a, arm, push))
    sliding = along(along(sliding, -1.0, drift(b, other, motion)), -1.0, drift(b, other, push))
    sliding = along(sliding, -dot(sliding, n), n)
    length = math.sqrt(dot(sliding, sliding))
    if length > 0.0:
        t = (sliding[0] / length, sliding[1] / length, sliding[2] / length)
        held = min(length / (give(a, arm, t, slack) + give(b, other, t, slack)), most)
        push_body(a, arm, (-held * t[0], -held * t[1], -held * t[2]), slack, push)
        push_body(b, other, (held * t[0], held * t[1], held * t[2]), slack, push)


@inlined
def part(
    i: Row,
    j: Row,
    offset: Vector,
    friction: float,
    ball: NDArray[np.float64],
    arms: NDArray[np.float64],
    owner: NDArray[np.int64],
    slack: NDArray[np.float64],
    motion: NDArray[np.float64],
    push: NDArray[np.float64],
) -> float:
    """Part two spheres of two bodies where they overlap.

    Args:
        i: One sphere.
        j: The other one.
        offset: What takes the other one to its image near the first [m].
        friction: Coefficient of friction.
        ball: Centres and radii before pushes [m], shape (N, 4).
        arms: From the centres of the bodies to the spheres [m], shape (N, 3).
        owner: Body of each sphere, shape (N,).
        slack: See ``give``.
        motion: See ``rub``.
        push: See ``push_body``; changes.

    Returns:
        The overlap that was found, over the smaller radius; 0: they are apart.
    """
    a, b = np.uint64(owner[i]), np.uint64(owner[j])
    arm, other = (arms[i, 0], arms[i, 1], arms[i, 2]), (arms[j, 0], arms[j, 1], arms[j, 2])
    here, there = drift(a, arm, push), drift(b, other, push)
    d = (
        ball[i, 0] + here[0] - (ball[j, 0] + there[0] + offset[0]),
        ball[i, 1] + here[1] - (ball[j, 1] + there[1] + offset[1]),
        ball[i, 2] + here[2] - (ball[j, 2] + there[2] + offset[2]),
    )
    one, two = ball[i, 3], ball[j, 3]
    reach, found = one + two, 0.0
    if dot(d, d) < reach * reach:
        n, distance = normal_of(i, j, d, reach)
        p = (reach - distance) / (give(a, arm, n, slack) + give(b, other, n, slack))
        push_body(a, arm, (p * n[0], p * n[1], p * n[2]), slack, push)
        push_body(b, other, (-p * n[0], -p * n[1], -p * n[2]), slack, push)
        if friction > 0.0:
            touch = (along(arm, -one, n), along(other, two, n))
            rub((a, b), touch, n, friction * p, slack, motion, push)
        found = (reach - distance) / min(one, two)
    return found
