"""The spheres placed so far: those near the surface at hand, the buried ones put away."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from packgen.arrays import Float64Array, Int32Array


@dataclass(frozen=True, eq=False, slots=True)
class Spheres:
    """Columns of equal length: centres [m] (N, 3), radii [m] and where each sphere belongs, int32, (N,)."""

    position: Float64Array
    radius: Float64Array
    set_index: Int32Array
    zone_index: Int32Array
    batch_index: Int32Array

    def __len__(self) -> int:
        return len(self.radius)

    def __getitem__(self, chosen: NDArray[np.bool_]) -> Spheres:
        return Spheres(
            self.position[chosen],
            self.radius[chosen],
            self.set_index[chosen],
            self.zone_index[chosen],
            self.batch_index[chosen],
        )


def no_spheres() -> Spheres:
    """Return an empty set of columns."""
    none = np.empty(0, np.int32)
    return Spheres(np.empty((0, 3)), np.empty(0), none, none, none)


def joined(parts: Sequence[Spheres]) -> Spheres:
    """Return several sets of columns as one."""
    if not parts:
        return no_spheres()
    return Spheres(
        np.concatenate([part.position for part in parts]),
        np.concatenate([part.radius for part in parts]),
        np.concatenate([part.set_index for part in parts]),
        np.concatenate([part.zone_index for part in parts]),
        np.concatenate([part.batch_index for part in parts]),
    )


class Pile:
    """All spheres placed so far.

    Attributes:
        front: The ones that a new layer can touch.
    """

    def __init__(self) -> None:
        self.front = no_spheres()
        self._buried: list[Spheres] = []
        self._buried_count = 0

    def __len__(self) -> int:
        return self._buried_count + len(self.front)

    def bury(self, deep: NDArray[np.bool_]) -> None:
        """Put front spheres away that nothing will touch any more."""
        if deep.any():
            buried = self.front[deep]
            self._buried.append(buried)
            self._buried_count += len(buried)
            self.front = self.front[~deep]

    def unearth(self) -> None:
        """Make every sphere part of the front again: the next zone may lie anywhere."""
        self.front = self.all()
        self._buried, self._buried_count = [], 0

    def all(self) -> Spheres:
        """Return all spheres, in the order in which they came to rest."""
        return joined([*self._buried, self.front])
