"""Spheres as columns of equal length: what every algorithm returns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.bodies import joined_bodies


@dataclass(frozen=True, eq=False, slots=True)
class Spheres:
    """Columns of equal length: centres [m] (N, 3), radii [m] and where each sphere belongs, int32, (N,).

    Attributes:
        body_index: Body of each sphere; None: each sphere is a body.
    """

    position: Float64Array
    radius: Float64Array
    set_index: Int32Array
    zone_index: Int32Array
    batch_index: Int32Array
    body_index: Int32Array | None = None

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
        )


def no_spheres() -> Spheres:
    """Return an empty set of columns."""
    none = np.empty(0, np.int32)
    return Spheres(np.empty((0, 3)), np.empty(0), none, none, none)


def joined(parts: Sequence[Spheres]) -> Spheres:
    """Return several sets of columns as one; bodies of different parts stay different."""
    if not parts:
        return no_spheres()
    return Spheres(
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.radius for part in parts]),
        np.concatenate([part.set_index for part in parts]),
        np.concatenate([part.zone_index for part in parts]),
        np.concatenate([part.batch_index for part in parts]),
        joined_bodies([part.body_index for part in parts], [len(part) for part in parts]),
    )
