"""Spheres as columns of equal length: what every algorithm returns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.bodies import SINGLE, Bodies, joined_bodies, joined_rows


@dataclass(frozen=True, eq=False, slots=True)
class Spheres:
    """Columns of equal length: centres [m] (N, 3), radii [m] and where each sphere belongs, int32, (N,).

    Attributes:
        body_index: Body of each sphere; None: each sphere is a body.
        bodies: The rigid bodies that ``body_index`` numbers, maybe more than these spheres are of; None:
            nothing more is known of them.
    """

    position: Float64Array
    radius: Float64Array
    set_index: Int32Array
    zone_index: Int32Array
    batch_index: Int32Array
    body_index: Int32Array | None = None
    bodies: Bodies | None = None

    def __len__(self) -> int:
        return len(self.radius)

    def __getitem__(self, chosen: NDArray[np.bool_] | Int64Array | slice) -> Spheres:
        if isinstance(chosen, np.ndarray) and chosen.dtype == np.bool_ and chosen.all():
            return self
        return Spheres(
            self.position[chosen],
            self.radius[chosen],
            self.set_index[chosen],
            self.zone_index[chosen],
            self.batch_index[chosen],
            None if self.body_index is None else self.body_index[chosen],
            self.bodies,
        )


def no_spheres() -> Spheres:
    """Return an empty set of columns."""
    none = np.empty(0, np.int32)
    return Spheres(np.empty((0, 3)), np.empty(0), none, none, none)


def joined(parts: Sequence[Spheres]) -> Spheres:
    """Return several sets of columns as one; bodies of different parts stay different."""
    if not parts:
        return no_spheres()
    columns = [part.body_index for part in parts]
    body_index, bodies = joined_bodies(columns, [len(part) for part in parts]), None
    if any(part.bodies is not None for part in parts):
        body_index, bodies = _joined_rows(parts)
    return Spheres(
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.radius for part in parts]),
        np.concatenate([part.set_index for part in parts]),
        np.concatenate([part.zone_index for part in parts]),
        np.concatenate([part.batch_index for part in parts]),
        body_index,
        bodies,
    )


def in_rows(spheres: Spheres) -> Spheres:
    """Return spheres whose bodies are numbered in the order in which they come, and no others are known.

    A body that is one sphere is where the sphere is: spheres move without their bodies.
    """
    if spheres.bodies is None or spheres.body_index is None:
        return spheres
    chosen, first, number = np.unique(spheres.body_index, return_index=True, return_inverse=True)
    order = np.argsort(first, kind="stable")
    row = np.empty(len(order), np.int32)
    row[order] = np.arange(len(order), dtype=np.int32)
    bodies = spheres.bodies[chosen[order].astype(np.int64)]
    single = bodies.template_index == SINGLE
    place = np.where(single[:, None], spheres.position[first[order]], bodies.position)
    return replace(spheres, body_index=row[number], bodies=replace(bodies, position=place))


def rows_of_bodies(spheres: Spheres) -> Spheres:
    """Return one sphere a body, of its volume and at its centre of mass, in the order in which they come.

    Spheres without known bodies are returned as they are. ``body_index`` numbers the same bodies.
    """
    if spheres.bodies is None or spheres.body_index is None:
        return spheres
    _, first = np.unique(spheres.body_index, return_index=True)
    rows = spheres[np.sort(first).astype(np.int64)]
    assert rows.body_index is not None
    bodies = spheres.bodies[rows.body_index.astype(np.int64)]
    single = bodies.template_index == SINGLE
    place = np.where(single[:, None], rows.position, bodies.position)
    return replace(rows, position=place, radius=bodies.size)


def count_of_bodies(spheres: Spheres) -> int:
    """Return the number of particles: of bodies where they are known, else of spheres."""
    return len(rows_of_bodies(spheres))


def _joined_rows(parts: Sequence[Spheres]) -> tuple[Int32Array, Bodies]:
    """Return the bodies of several sets of columns in one list, and the row in it of each sphere's."""
    known = [in_rows(part) if part.bodies is not None else _single(part) for part in parts]
    rows, bodies, start = [], [], 0
    for part in known:
        assert part.body_index is not None
        assert part.bodies is not None
        rows.append(part.body_index + np.int32(start))
        bodies.append(part.bodies)
        start += len(part.bodies)
    return np.concatenate(rows), joined_rows(bodies)


def _single(part: Spheres) -> Spheres:
    """Return spheres each of which is a body."""
    count = len(part)
    index = np.full(count, SINGLE, np.int32)
    turn = np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))
    bodies = Bodies((), index, part.radius, part.position, turn)
    return replace(part, body_index=np.arange(count, dtype=np.int32), bodies=bodies)
