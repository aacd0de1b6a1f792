"""The pair correlation function g(r) of the core of a bed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.measure.core import Core
from packgen.measure.particles import as_particles
from packgen.measure.volumes import mean_diameter

REACH = 4.0  # mean diameters
STEP = 0.05  # mean diameters
REFERENCES_MAX = 4000  # spheres; enough for a noise of a thousandth in each shell
SPHERES_MIN = 50  # below, g(r) is noise


@dataclass(frozen=True, slots=True)
class PairCorrelation:
    """The pair correlation function: number density at a distance from a sphere over the mean one.

    Attributes:
        diameter: Mean diameter of the spheres by volume [m], the unit of ``distance``.
        distance: Middles of the shells, in mean diameters, rising; a shell reaches from half way to the one
            before to half way to the one after.
        g: Pair correlation of each shell; 1 where there is no order.
        references: Number of spheres around which neighbours were counted.
    """

    diameter: float
    distance: tuple[float, ...]
    g: tuple[float, ...]
    references: int


def pair_correlation(
    bed: Bed, core: Core | None, reach: float = REACH, step: float = STEP
) -> PairCorrelation | None:
    """Return g(r) of the spheres with centres in the core of a bed, undisturbed by its faces.

    Of clumps it is that of their centres of mass.

    A sphere near a face of the core has neighbours outside, which do not count; a pair that is x apart is
    therefore weighed by the share of the core in which both of its spheres could be, the product of
    ``1 - |x_k| / L_k`` over the edges (the translation correction of Ohser and Stoyan: Illian et al.,
    Statistical Analysis and Modelling of Spatial Point Patterns, 2008, chapter 4). In a bed of random
    points the expectation of every shell is then exactly 1.

    Args:
        bed: The bed.
        core: A box that the bed fills, such as `packgen.measure.core_of` gives.
        reach: Largest distance, in mean diameters; no more than half the core's shortest edge is used.
        step: Thickness of the shells, in mean diameters.

    Returns:
        The function; None without a core, and in one with less than `SPHERES_MIN` spheres or less than one
        and a half diameters wide.
    """
    if core is None:
        return None
    bed = as_particles(bed)
    inside = core.contains(bed.position)
    count = int(np.count_nonzero(inside))
    if count < SPHERES_MIN:
        return None
    shells = correlation_shells(core, count, mean_diameter(bed.radius[inside]), reach, step)
    if shells is None:
        return None
    local = (bed.position[inside] - core.center) @ core.axes.T
    return shells.correlation(shells.weighed(local, np.arange(0, count, shells.every)))


@dataclass(frozen=True, eq=False, slots=True)
class CorrelationShells:
    """The shells in which neighbours of a core's spheres are counted.

    Attributes:
        core: The core.
        count: Number of spheres with centres in it.
        diameter: Their mean diameter by volume [m].
        middle: Middles of the shells, in mean diameters, rising.
        edge: Bounds of the shells [m], rising.
    """

    core: Core
    count: int
    diameter: float
    middle: Float64Array
    edge: Float64Array

    @property
    def every(self) -> int:
        """Around one sphere in how many neighbours are counted."""
        return self.count // REFERENCES_MAX + 1

    def weighed(self, local: Float64Array, chosen: Int64Array) -> Float64Array:
        """Return the neighbours of some spheres in each shell, each by its weight.

        Args:
            local: Centres in the core's frame [m], shape (N, 3); the chosen ones' neighbours are among them.
            chosen: Around which of them to count, shape (n,).
        """
        from scipy.spatial import cKDTree

        found = cKDTree(local[chosen]).sparse_distance_matrix(
            cKDTree(local), self.edge[-1], output_type="ndarray"
        )
        first, second = chosen[found["i"]], found["j"]
        other = first != second
        apart = np.abs(local[first[other]] - local[second[other]])
        share = np.prod(1.0 - apart / (2.0 * self.core.half), axis=1)
        return np.asarray(np.histogram(found["v"][other], bins=self.edge, weights=1.0 / share)[0])

    def correlation(self, weighed: Float64Array) -> PairCorrelation:
        """Return g(r) by the weighed neighbours of all spheres around which they were counted."""
        references = len(range(0, self.count, self.every))
        shell = 4.0 / 3.0 * np.pi * np.diff(self.edge**3)
        g: Float64Array = weighed / (shell * references * (self.count - 1) / self.core.volume)
        return PairCorrelation(self.diameter, tuple(self.middle.tolist()), tuple(g.tolist()), references)


def correlation_shells(
    core: Core, count: int, diameter: float, reach: float = REACH, step: float = STEP
) -> CorrelationShells | None:
    """Return the shells of a core that holds so many spheres; None where they are too few, or it too narrow.

    Args:
        core: The core.
        count: Number of spheres with centres in it.
        diameter: Their mean diameter by volume [m].
        reach: Largest distance, in mean diameters.
        step: Thickness of the shells, in mean diameters.
    """
    if count < SPHERES_MIN:
        return None
    reach = min(reach, float(core.half.min()) / diameter - 0.5 * step)
    if reach < 1.5:
        return None
    middle = step * np.arange(1, int(reach / step + 1e-9) + 1)
    edge = np.concatenate([[0.5 * step], middle + 0.5 * step]) * diameter
    return CorrelationShells(core, count, diameter, np.asarray(middle, np.float64), edge)
