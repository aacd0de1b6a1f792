"""The last digits: contacts made exact by Newton's method, and the forces that balance at them.

Where contacts are just as many as it takes to hold the spheres, their places and the common factor of the
radii are the one solution of all contacts' equations, and the forces, but for a common factor, follow from
the same matrix. Where all of them press, weak duality has it that no small move lets the radii grow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.sparse import coo_array, csc_array

from packgen.arrange.jammed.meetings import Meetings
from packgen.arrays import Float64Array, Int64Array
from packgen.programmes.steps import Pins

ROUNDS = 8
ACCURACY = 1.0e-14
"""Largest error of a contact, in mean radii, at which no better one is sought."""

STRIDE = 0.1
"""Longest way of a sphere in mean radii: farther away, other contacts would come in."""


@dataclass(frozen=True, eq=False, slots=True)
class Exact:
    """Spheres whose contacts are exact.

    Attributes:
        center: Centres [m], shape (N, 3).
        factor: Common factor of the radii.
        pair_force: Force at each pair, shape (P,); one unit for all.
        wall_force: Force at each wall, shape (W,).
    """

    center: Float64Array
    factor: float
    pair_force: Float64Array
    wall_force: Float64Array


def exact_contacts(
    contacts: Meetings, center: Float64Array, factor: float, pins: Pins, backbone: Int64Array
) -> Exact | None:
    """Return the spheres near by whose contacts are exact; None: there are none, or several.

    Args:
        contacts: Pairs and walls that touch, all of spheres of the backbone.
        center: Centres nearly so [m], shape (N, 3).
        factor: Common factor of the radii, nearly so.
        pins: What must not move, of spheres of the backbone.
        backbone: The spheres that are held, shape (n,).
    """
    unknown = 3 * len(backbone) + 1
    touching = len(contacts.first) + len(contacts.sphere)
    if touching + len(pins.sphere) != unknown:
        return None
    from scipy.sparse.linalg import splu

    place = np.full(len(center), -1)
    place[backbone] = np.arange(len(backbone))
    unit = float(contacts.radius.mean())
    center = center.copy()
    for _ in range(ROUNDS):
        matrix, error = _equations(contacts, center, factor, pins, place)
        try:
            solver: Any = splu(matrix)  # its stubs know no transposed one
        except RuntimeError:  # singular: some spheres are held more than once, others not at all
            return None
        if np.abs(error).max() <= ACCURACY * unit:
            break
        change = solver.solve(error)
        if not np.abs(change[:-1]).max() <= STRIDE * unit:
            return None
        center[backbone] += change[:-1].reshape(-1, 3)
        factor += float(change[-1])
    growth = np.zeros(unknown)
    growth[-1] = -1.0
    force = solver.solve(growth, trans="T")[:touching]
    return Exact(center, factor, *np.split(force, [len(contacts.first)]))


def _equations(
    contacts: Meetings, center: Float64Array, factor: float, pins: Pins, place: Int64Array
) -> tuple[csc_array, Float64Array]:
    """Return the change of each gap with all that can change, and by how much each is too narrow [m]."""
    separation = contacts.separations(center)
    length = np.sqrt((separation * separation).sum(axis=1))
    distance, away = contacts.distances(center)
    normal = separation / length[:, None]
    pairs, walls, still = len(length), len(distance), len(pins.sphere)
    number, axes, last = np.arange(pairs + walls + still), np.arange(3), 3 * int(place.max() + 1)
    row = np.concatenate([np.repeat(number[:pairs], 3), np.repeat(number, 3), number[: pairs + walls]])
    spheres = place[np.concatenate([contacts.second, contacts.first, contacts.sphere, pins.sphere])]
    column = np.concatenate([(3 * spheres[:, None] + axes).ravel(), np.full(pairs + walls, last)])
    radii = np.concatenate([contacts.apart, contacts.kept])
    value = np.concatenate([-normal.ravel(), normal.ravel(), away.ravel(), pins.direction.ravel(), -radii])
    shape = (len(number), last + 1)
    error = np.concatenate([factor * radii - np.concatenate([length, distance]), np.zeros(still)])
    return csc_array(coo_array((value, (row, column)), shape)), error
