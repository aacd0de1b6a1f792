"""The spheres placed so far: those near the surface at hand, the buried ones put away."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.spheres import Spheres, joined, no_spheres
from packgen.bodies import whole_bodies


class Pile:
    """All spheres placed so far.

    Args:
        earlier: Spheres that are there before; a zone may lie anywhere among them, all are at hand.

    Attributes:
        front: The ones that a new layer can touch.
    """

    def __init__(self, earlier: Spheres | None = None) -> None:
        self.front = no_spheres() if earlier is None else earlier
        self._buried: list[Spheres] = []
        self._buried_count = 0

    def __len__(self) -> int:
        return self._buried_count + len(self.front)

    def bury(self, deep: NDArray[np.bool_]) -> None:
        """Put away the front spheres that nothing will touch any more, in whole bodies."""
        deep = whole_bodies(deep, self.front.body_index)
        if deep.any():
            buried = self.front[deep]
            self._buried.append(buried)
            self._buried_count += len(buried)
            self.front = self.front[~deep]

    def all(self) -> Spheres:
        """Return all spheres, in the order in which they came to rest."""
        return joined([*self._buried, self.front])
