"""The state of a layer of bodies: from bodies and fixed spheres to what the compiled loops take, and back."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packgen.arrange.rigid.pose_kernels import place_members
from packgen.arrange.rigid.state import RigidState
from packgen.arrays import Float64Array, Int64Array
from packgen.bodies import Bodies
from packgen.distributions import UNIT_VOLUME
from packgen.portable import cube, whole_power

PARTS = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
"""Entries of a symmetric tensor in the order in which the loops have them."""


def members_in_rows(bodies: Bodies) -> tuple[Int64Array, Float64Array, Float64Array]:
    """Return the spheres of bodies in the bodies' own frames.

    Returns:
        First sphere of each body and the end of all, shape (B + 1,); centres from the centre of mass [m],
        shape (N, 3); radii [m], shape (N,).
    """
    count = bodies.sphere_count
    first = np.concatenate([[0], np.cumsum(count)])
    owner = np.repeat(np.arange(len(bodies)), count)
    table = np.concatenate([*(each.spheres for each in bodies.templates), [[0.0, 0.0, 0.0, 1.0]]])
    begin = np.cumsum([0, *(each.count for each in bodies.templates)])[bodies.template_index]
    unit = table[begin[owner] + np.arange(len(owner)) - first[owner]]
    scaled = unit * bodies.scale[owner][:, None]
    return first, np.ascontiguousarray(scaled[:, :3]), scaled[:, 3].copy()


def members_at(bodies: Bodies) -> Float64Array:
    """Return centres and radii of the spheres of bodies [m], shape (N, 4), to the last bit as packed."""
    return state_of(bodies, np.empty((0, 4)), 1.0).ball


def state_of(bodies: Bodies, fixed: Float64Array, enlarged: float) -> RigidState:
    """Return the state of a layer at rest.

    Args:
        bodies: The bodies that move, at least one.
        fixed: Centres and radii of the spheres that stay [m], shape (F, 4).
        enlarged: Arranged radius over the true one.
    """
    first, local, radius = members_in_rows(bodies)
    moving, count = len(radius), len(bodies)
    size = bodies.size
    reference = float(np.sum(size)) / max(count, 1)
    ball = np.empty((moving + len(fixed), 4))
    ball[moving:] = fixed
    ball[:moving, 3] = radius
    ball[:, 3] *= enlarged
    owner = np.full(len(ball), count, np.int64)
    owner[:moving] = np.repeat(np.arange(count), np.diff(first))
    slack = np.zeros((count + 1, 7))
    slack[:count, 6] = cube(reference / size)
    state = RigidState(
        bodies.position.copy(), bodies.orientation.copy(), np.zeros((count + 1, 6)),
        _slackness(bodies, reference), slack, size, bodies.reach, first, local, owner, ball,
        np.zeros((len(ball), 3)), reference,
    )  # fmt: skip
    place_members(state)
    return state


def moved_bodies(bodies: Bodies, state: RigidState) -> Bodies:
    """Return bodies where a layer has taken them."""
    return replace(bodies, position=state.centre.copy(), orientation=state.turn.copy())


def _slackness(bodies: Bodies, reference: float) -> Float64Array:
    """Return the inverse tensors of inertia, shape (B, 6); see ``RigidState``."""
    ball = 0.4 * UNIT_VOLUME * np.eye(3)
    units = np.array([_inverse(each) for each in [*(each.inertia for each in bodies.templates), ball]])
    mass = UNIT_VOLUME * reference * reference * reference
    inverse = units[bodies.template_index] * (mass / whole_power(bodies.scale, 5))[:, None, None]
    return np.stack([inverse[:, i, j] for i, j in PARTS], axis=1)


def _inverse(tensor: Float64Array) -> Float64Array:
    """Return the inverse of a symmetric tensor (3, 3), by its cofactors: alike on all machines."""
    a, b, c, d, e, f = (float(tensor[i, j]) for i, j in PARTS)
    xx, yy, zz = b * c - f * f, a * c - e * e, a * b - d * d
    xy, xz, yz = e * f - d * c, d * f - e * b, d * e - a * f
    det = a * xx + d * xy + e * xz
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / det
