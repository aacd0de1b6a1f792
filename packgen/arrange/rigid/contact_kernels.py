"""How two bodies, or a body and a wall, part where their spheres overlap: impulses at points of contact.

Position-based dynamics of rigid bodies (Mueller et al., Detailed rigid body simulation with extended position
based dynamics, Comput. Graph. Forum 39 (2020) 101): an impulse p at a point with the arm a from the centre of
mass moves a body by p / m and turns it by I^-1 (a x p). Contacts come one after the other, and each sees what
the ones before have done: many spheres of two bodies may touch at once, and no push counts twice.

Vectors are tuples of three numbers, which the compiler keeps in registers. Body -1 is a
wall or a fixed sphere.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.projection.push_kernels import parting
from packgen.arrange.rigid.state import RigidState
from packgen.compiled import inlined

Vector = tuple[float, float, float]

STILL: Vector = (0.0, 0.0, 0.0)


class Work(NamedTuple):
    """Work space of a sweep over B bodies.

    Attributes:
        slack: Inverse tensors of inertia in the bed's axes, xx yy zz xy xz yz, shape (B, 6), float64.
        shift: How far pushes have moved each body in this sweep [m], shape (B, 3), float64.
        swing: How far they have turned it [rad], shape (B, 3), float64.
    """

    slack: NDArray[np.float64]
    shift: NDArray[np.float64]
    swing: NDArray[np.float64]


@inlined
def new_work(count: int) -> Work:
    """Return work space for so many bodies."""
    return Work(np.zeros((count, 6)), np.zeros((count, 3)), np.zeros((count, 3)))


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
def times(tensor: NDArray[np.float64], b: int, v: Vector) -> Vector:
    """Return the product of a symmetric tensor, row b of xx yy zz xy xz yz, and a vector."""
    return (
        tensor[b, 0] * v[0] + tensor[b, 3] * v[1] + tensor[b, 4] * v[2],
        tensor[b, 3] * v[0] + tensor[b, 1] * v[1] + tensor[b, 5] * v[2],
        tensor[b, 4] * v[0] + tensor[b, 5] * v[1] + tensor[b, 2] * v[2],
    )


@inlined
def give(b: int, arm: Vector, n: Vector, state: RigidState, work: Work) -> float:
    """Return how far a body's point at an arm gives way along n to a unit impulse there; of body -1 0."""
    way = 0.0
    if b >= 0:
        lever = cross(arm, n)
        way = state.lightness[b] + dot(lever, times(work.slack, b, lever))
    return way


@inlined
def push_body(b: int, arm: Vector, impulse: Vector, state: RigidState, work: Work) -> None:
    """Move and turn a body by an impulse at an arm; body -1 stays."""
    if b >= 0:
        turn = times(work.slack, b, cross(arm, impulse))
        for axis in range(3):
            work.shift[b, axis] += state.lightness[b] * impulse[axis]
            work.swing[b, axis] += turn[axis]


@inlined
def drift(b: int, arm: Vector, shift: NDArray[np.float64], swing: NDArray[np.float64]) -> Vector:
    """Return how far a body's point at an arm has come by a shift and a small turn; of body -1 0."""
    way = STILL
    if b >= 0:
        turn = cross((swing[b, 0], swing[b, 1], swing[b, 2]), arm)
        way = (shift[b, 0] + turn[0], shift[b, 1] + turn[1], shift[b, 2] + turn[2])
    return way


@inlined
def normal_of(i: int, j: int, d: Vector, reach: float) -> tuple[Vector, float]:
    """Return the unit vector along d, and its length; of coincident centres one by the spheres' numbers."""
    distance = math.sqrt(dot(d, d))
    length = distance
    if distance < 1e-9 * reach:
        d = parting(i, j)
        length = math.sqrt(dot(d, d))
    return (d[0] / length, d[1] / length, d[2] / length), distance


@inlined
def way_of(b: int, arm: Vector, state: RigidState, work: Work) -> Vector:
    """Return how far a body's point at an arm has come in this sweep."""
    before = drift(b, arm, state.moved, state.turned)
    return along(before, 1.0, drift(b, arm, work.shift, work.swing))


@inlined
def rub(
    bodies: tuple[int, int],
    arms: tuple[Vector, Vector],
    n: Vector,
    most: float,
    state: RigidState,
    work: Work,
) -> None:
    """Take from the sliding of a contact what its friction holds.

    Args:
        bodies: The two bodies.
        arms: From the centre of each to the contact [m].
        n: Unit normal.
        most: Largest impulse, by Coulomb's law.
        state: The layer.
        work: The sweep's; ``shift`` and ``swing`` change.
    """
    (a, b), (arm, other) = bodies, arms
    sliding = along(way_of(a, arm, state, work), -1.0, way_of(b, other, state, work))
    sliding = along(sliding, -dot(sliding, n), n)
    length = math.sqrt(dot(sliding, sliding))
    if length > 1e-14 * state.reference:
        t = (sliding[0] / length, sliding[1] / length, sliding[2] / length)
        held = min(length / (give(a, arm, t, state, work) + give(b, other, t, state, work)), most)
        push_body(a, arm, along(STILL, -held, t), state, work)
        push_body(b, other, along(STILL, held, t), state, work)


@inlined
def part(i: int, j: int, offset: Vector, friction: float, state: RigidState, work: Work) -> float:
    """Part two spheres of two bodies where they overlap.

    Args:
        i: One sphere, whose body moves.
        j: The other one.
        offset: What takes the other one to its image near the first [m].
        friction: Coefficient of friction.
        state: The layer.
        work: The sweep's; ``shift`` and ``swing`` change.

    Returns:
        The overlap that was found, over the smaller radius; 0: they are apart.
    """
    ball, a, b = state.ball, state.owner[i], state.owner[j]
    arm, other = (state.arm[i, 0], state.arm[i, 1], state.arm[i, 2]), STILL
    if b >= 0:
        other = (state.arm[j, 0], state.arm[j, 1], state.arm[j, 2])
    here = along(drift(a, arm, work.shift, work.swing), 1.0, (ball[i, 0], ball[i, 1], ball[i, 2]))
    there = along(drift(b, other, work.shift, work.swing), 1.0, (ball[j, 0], ball[j, 1], ball[j, 2]))
    d = along(along(here, -1.0, there), -1.0, offset)
    reach, found = ball[i, 3] + ball[j, 3], 0.0
    if dot(d, d) < reach * reach:
        n, distance = normal_of(i, j, d, reach)
        push = (reach - distance) / (give(a, arm, n, state, work) + give(b, other, n, state, work))
        push_body(a, arm, along(STILL, push, n), state, work)
        push_body(b, other, along(STILL, -push, n), state, work)
        if friction > 0.0:
            arms = (along(arm, -ball[i, 3], n), along(other, ball[j, 3], n))
            rub((a, b), arms, n, friction * push, state, work)
        found = (reach - distance) / min(ball[i, 3], ball[j, 3])
    return found
