"""Bodies from where their spheres are now: as a solver that moves spheres of rigid bodies leaves them."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array, Int32Array
from packgen.bodies.placed import Bodies
from packgen.bodies.shares import sphere_shares

__all__ = ["body_centres", "in_one_piece", "moved_bodies", "quaternions"]


def in_one_piece(
    position: Float64Array, body_index: Int32Array, period: tuple[float | None, ...]
) -> Float64Array:
    """Return places of spheres such that those of a body are side by side, where the box wraps around.

    Args:
        position: Centres [m], shape (N, 3); those of a body within half a period of each other.
        body_index: Body of each sphere, shape (N,).
        period: Size of the box along each axis along which it wraps around [m]; None: it does not.
    """
    _, first, body = np.unique(body_index, return_index=True, return_inverse=True)
    near = position[first[body]]
    joined = position.copy()
    for axis, size in enumerate(period):
        if size is not None:
            joined[:, axis] -= size * np.rint((position[:, axis] - near[:, axis]) / size)
    return joined


def body_centres(bodies: Bodies, position: Float64Array, body_index: Int32Array) -> Float64Array:
    """Return the centre of mass of each body from the places of its spheres [m], shape (M, 3).

    Args:
        bodies: The bodies; where they stand does not count.
        position: Centres of the spheres, those of a body side by side [m], shape (N, 3).
        body_index: Row of each sphere's body, shape (N,).

    Raises:
        UnbalancedError: A template has no shares with its centre of mass.
    """
    share = np.empty(len(position))
    share[np.argsort(body_index, kind="stable")] = sphere_shares(bodies)
    # From a sphere of each body, so that one far from the origin keeps its digits.
    start = position[np.unique(body_index, return_index=True)[1]]
    apart = share[:, None] * (position - start[body_index])
    sums = [np.bincount(body_index, apart[:, axis], len(bodies)) for axis in range(3)]
    return np.asarray(start + np.stack(sums, axis=1))


def moved_bodies(bodies: Bodies, position: Float64Array, body_index: Int32Array) -> Bodies:
    """Return bodies where their spheres are now, moved and turned as rigid bodies that fit best.

    The turn is that of Kabsch, Acta Cryst. A 32 (1976) 922. About an axis on which all spheres of a body
    stand it is any.

    Args:
        bodies: The bodies; where they stand does not count.
        position: Centres of the spheres, those of a body side by side [m], shape (N, 3).
        body_index: Row of each sphere's body, shape (N,).

    Raises:
        UnbalancedError: A template has no shares with its centre of mass.
    """
    centre = body_centres(bodies, position, body_index)
    apart = (position - centre[body_index])[np.argsort(body_index, kind="stable")]
    start = np.cumsum(bodies.sphere_count) - bodies.sphere_count
    turn = np.array(bodies.orientation)
    for number, template in enumerate(bodies.templates):
        own = np.flatnonzero(bodies.template_index == number)
        if template.count == 1 or len(own) == 0:
            continue
        now = apart[start[own][:, None] + np.arange(template.count)]
        product = np.einsum("ki,mkj->mij", template.spheres[:, :3] / template.reach, now)
        left, _, right = np.linalg.svd(product)
        # Turns only, no reflections.
        left[:, :, 2] *= np.sign(np.linalg.det(left) * np.linalg.det(right))[:, None]
        turn[own] = quaternions(np.einsum("mji,mkj->mik", right, left))
    return Bodies(bodies.templates, bodies.template_index, bodies.scale, centre, turn)


def quaternions(turn: Float64Array) -> Float64Array:
    """Return the unit quaternions w, x, y, z, w not below 0, of rotation matrices, shape (M, 4), float64.

    The products of a quaternion's components are sums of entries of the matrix; the row of the largest one is
    the quaternion, times it. `rotations` goes the other way.

    Args:
        turn: Rotation matrices, shape (M, 3, 3).
    """
    trace = np.trace(turn, axis1=1, axis2=2)
    product = np.empty((len(turn), 4, 4))
    product[:, 0, 0] = 1.0 + trace
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        product[:, a + 1, a + 1] = 1.0 + 2.0 * turn[:, a, a] - trace
        product[:, 0, a + 1] = product[:, a + 1, 0] = turn[:, c, b] - turn[:, b, c]
        product[:, b + 1, c + 1] = product[:, c + 1, b + 1] = turn[:, c, b] + turn[:, b, c]
    largest = np.einsum("mii->mi", product).argmax(axis=1)
    found = product[np.arange(len(turn)), largest]
    found /= np.linalg.norm(found, axis=1, keepdims=True)
    return np.asarray(np.where(found[:, :1] < 0.0, -found, found))
