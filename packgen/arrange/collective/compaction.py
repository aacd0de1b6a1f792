"""How dense a bed is made where its scene says so: from friction that holds spheres up to slow sinking."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from packgen.arrange.collective.plan import LayerPlan
    from packgen.arrange.projection.recipe import Recipe


@dataclass(frozen=True, slots=True)
class Compaction:
    """What makes a bed loose or dense.

    Attributes:
        friction: Coefficient of friction between spheres while they are arranged.
        grip: Largest share of a contact's sliding that friction takes in a sweep.
        slower: Sweeps of a layer, in usual ones.
        reopened: Depth below the surface to which spheres move again with the next layer, in diameters.
    """

    friction: float
    grip: float
    slower: float
    reopened: float

    def recipe(self, tolerance: float | None, tube_width: float | None) -> Recipe:
        """Return the recipe of such a bed; see ``Recipe.slowed``."""
        from packgen.arrange.projection.recipe import Recipe

        recipe = Recipe.slowed(self.slower, tolerance, tube_width)
        return replace(recipe, friction=self.friction, grip=self.grip)

    def plan(self, plan: LayerPlan) -> LayerPlan:
        """Return a plan of layers for such a bed."""
        return replace(plan, reopened=self.reopened)


STATIONS = (
    (0.547, Compaction(0.5, 0.6, 0.6, 1.0)),
    (0.554, Compaction(0.5, 0.55, 0.6, 1.0)),
    (0.568, Compaction(0.5, 0.5, 0.7, 1.0)),
    (0.579, Compaction(0.5, 0.45, 0.8, 1.0)),
    (0.586, Compaction(0.5, 0.4, 0.9, 1.0)),
    (0.5935, Compaction(0.5, 0.3, 0.8, 1.0)),
    (0.5975, Compaction(0.5, 0.3, 1.0, 1.0)),
    (0.606, Compaction(0.2, 0.3, 1.0, 1.0)),
    (0.6095, Compaction(0.1, 0.3, 1.0, 1.0)),
    (0.615, Compaction(0.0, 0.3, 1.0, 1.0)),
    (0.621, Compaction(0.0, 0.3, 1.0, 2.0)),
    (0.626, Compaction(0.0, 0.3, 2.0, 2.0)),
    (0.630, Compaction(0.0, 0.3, 4.0, 2.0)),
    (0.633, Compaction(0.0, 0.3, 10.0, 2.0)),
)
"""Core fractions of equal spheres, rising, and what makes them: columns 20 diameters wide, of 20,000 and the
densest two of 12,000. tests/benchmarks/densities.py holds beds against them."""

LOOSEST, DENSEST = STATIONS[0][0], STATIONS[-1][0]


def compaction_of(fraction: float) -> Compaction:
    """Return what gives the core of a bed of equal spheres a solid fraction, or the nearest one."""
    known = [each for each, _ in STATIONS]
    rows = np.array([(it.friction, it.grip, it.slower, it.reopened) for _, it in STATIONS])
    return Compaction(*(float(np.interp(fraction, known, column)) for column in rows.T))
