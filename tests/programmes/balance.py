"""What share of their weights spheres' contacts carry, by linear programming: exact, for a few spheres.

The round friction cones of `packgen.programmes.forces` are replaced by pyramids inside them, so that what
stands here stands there. What is lost is told by whole weights here, so that it is more than there. HiGHS
takes ten seconds for 500 spheres, the other programme a tenth of one. Where a bed is far from standing HiGHS
may give up on the large forces of wedged spheres.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy import sparse

from packgen.arrays import Float64Array
from packgen.errors import PackgenError
from packgen.programmes.forces import Structure

SIDES = 16
"""Sides of a pyramid. Its edges lie on the cone; between them it has cos(pi / 16), 0.981, of the friction."""


FORCE_MAX = 10.0  # on an edge of a pyramid, in sums of all weights


def weight_shares_carried(structure: Structure, friction: float | None = None) -> Float64Array:
    """Return the shares of the spheres' weights that contacts carry, such that they carry the most in sum.

    Forces and torques of each sphere are balanced exactly; of its weight only the share counts.

    Args:
        structure: Spheres and contacts.
        friction: Coefficient of friction of all contacts; None: each contact's own.

    Returns:
        Shares from 0 to 1, shape (N,); all 1 where everything stands.

    Raises:
        PackgenError: HiGHS found no optimum, which happens far from standing.
    """
    from scipy.optimize import linprog

    count = structure.count
    total = structure.weight_sum
    if total == 0.0:
        return np.ones(count)
    matrix = _edge_matrix(structure, friction)
    weight = structure.weight / (total / count)
    spheres = np.arange(count)
    pulls = sparse.coo_matrix(
        (weight.ravel(), (np.arange(3 * count), np.repeat(spheres, 3))), shape=(6 * count, count)
    )
    # Unknown are the shares that are lost: HiGHS fails at sides of equations that are all zero.
    cost = np.concatenate([np.zeros(matrix.shape[1]), np.linalg.norm(weight, axis=1)])
    # Wedged spheres may press on each other by any force; such forces are no solver's.
    bounds = np.column_stack([np.zeros(len(cost)), np.full(len(cost), FORCE_MAX * count)])
    bounds[matrix.shape[1] :, 1] = 1.0
    found: Any = linprog(  # type: ignore[call-overload]
        cost,
        A_eq=sparse.csc_matrix(sparse.hstack([matrix, -pulls])),
        b_eq=-np.concatenate([weight.ravel(), np.zeros(3 * count)]),
        bounds=bounds,
        method="highs-ds",
    )
    if found.x is None:
        raise PackgenError(f"programme of contact forces: HiGHS found no optimum, {found.message}")
    return np.asarray(1.0 - found.x[matrix.shape[1] :])


def _edge_matrix(structure: Structure, friction: float | None) -> sparse.csc_matrix:
    """Return forces and torques (6 N rows) on the spheres by a unit force along each edge of each pyramid."""
    normal = structure.normal
    contacts = len(normal)
    own = structure.friction if friction is None else np.full(contacts, friction)
    one, other = _tangents(structure)
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    across = np.cos(angle)[:, None] * one[:, None] + np.sin(angle)[:, None] * other[:, None]
    edge = normal[:, None] + own[:, None, None] * across
    torque = -np.cross(normal[:, None], edge)
    edge, torque = edge.reshape(-1, 3), torque.reshape(-1, 3)
    column = np.arange(contacts * SIDES)
    first, second = np.repeat(structure.first, SIDES), np.repeat(structure.second, SIDES)
    held = second >= 0
    rows, columns, values = [], [], []
    for sphere, pick, force in ((first, column, -edge), (second[held], column[held], edge[held])):
        for axis in range(3):
            rows += [6 * sphere + axis, 6 * sphere + 3 + axis]
            columns += [pick, pick]
            values += [force[:, axis], torque[pick, axis]]
    shape = (6 * structure.count, contacts * SIDES)
    # Pulls stand in rows 3 a sphere: forces first, all torques after them.
    row = np.concatenate(rows) if rows else np.zeros(0, np.int64)
    sphere, part = np.divmod(row, 6)
    row = np.where(part < 3, 3 * sphere + part, 3 * structure.count + 3 * sphere + part - 3)
    return sparse.csc_matrix((np.concatenate(values), (row, np.concatenate(columns))), shape=shape)


def _tangents(structure: Structure) -> tuple[Float64Array, Float64Array]:
    """Return two unit vectors across each normal; the first lies in the plane of normal and weight."""
    normal = structure.normal
    pull = structure.weight[structure.first]
    size = np.linalg.norm(pull, axis=1)
    pull = np.where(size[:, None] > 0.0, pull / np.where(size, size, 1.0)[:, None], [0.0, 0.0, -1.0])
    one = pull - np.einsum("ij,ij->i", pull, normal)[:, None] * normal
    steep = np.linalg.norm(one, axis=1) < 1e-6
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    one[steep] = (axis - np.einsum("ij,ij->i", axis, normal)[:, None] * normal)[steep]
    one /= np.linalg.norm(one, axis=1)[:, None]
    return one, np.cross(normal, one)
