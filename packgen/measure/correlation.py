"""The pair correlation function g(r) of the core of a bed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array
from packgen.bed import Bed
from packgen.measure.core import Core
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
    from scipy.spatial import cKDTree

    if core is None:
        return None
    inside = core.contains(bed.position)
    count = int(np.count_nonzero(inside))
    if count < SPHERES_MIN:
        return None
    diameter = mean_diameter(bed.radius[inside])
    reach = min(reach, float(core.half.min()) / diameter - 0.5 * step)
    if reach < 1.5:
        return None
    middle = step * np.arange(1, int(reach / step + 1e-9) + 1)
    edge = np.concatenate([[0.5 * step], middle + 0.5 * step]) * diameter
    local = (bed.position[inside] - core.center) @ core.axes.T
    chosen = np.arange(0, count, count // REFERENCES_MAX + 1)
    found = cKDTree(local[chosen]).sparse_distance_matrix(cKDTree(local), edge[-1], output_type="ndarray")
    first, second = chosen[found["i"]], found["j"]
    other = first != second
    apart = np.abs(local[first[other]] - local[second[other]])
    share = np.prod(1.0 - apart / (2.0 * core.half), axis=1)
    weighed, _ = np.histogram(found["v"][other], bins=edge, weights=1.0 / share)
    shell = 4.0 / 3.0 * np.pi * np.diff(edge**3)
    g: Float64Array = weighed / (shell * len(chosen) * (count - 1) / core.volume)
    return PairCorrelation(diameter, tuple(middle.tolist()), tuple(g.tolist()), len(chosen))
