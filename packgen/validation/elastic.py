"""How far a bed sinks because its contacts are elastic: no packing can avoid that, however good it is.

A bed that stands on its floor is shortened by its own weight, by (stress / E)^(2/3). At E = 1e8 Pa a bed of
tens of metres sinks by percents. A solver's contacts at the end of the run tell how much: a contact of two
spheres overlaps by delta and spans the height L |n_z| with the distance L of the centres; where it is the
only path to the floor it takes delta |n_z| of that height. At each height, over the contacts that cross it,
the strain is

    strain = sum(delta |n_z|) / sum(L |n_z|) = mean of delta / L over the contacts that cross the height,

and its integral from the floor is how far what lies there has gone down. A contact of these solvers is an
overlap of the positions that they report, so that the contacts are found from the positions: for every solver
the same way. A column of spheres, where the sum of the overlaps is the answer, is met exactly.
"""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.bed import Bed
from packgen.check import near_pairs, wall_clearance

TINY = 1.0e-6  # radii; vertical step that tells a wall's normal


def up_direction(bed: Bed) -> Float64Array:
    """Return the unit vector from what the bed lies on, z for a weightless bed, shape (3,)."""
    return -bed.down


def elastic_sinking(bed: Bed, position: Float64Array, index: Int64Array) -> Float64Array:
    """Return how far each sphere has gone down because the contacts below it are compressed.

    Args:
        bed: The bed that the spheres are of.
        position: Where some of its spheres are now, not wrapped around [m], shape (M, 3).
        index: Which spheres these are, shape (M,).

    Returns:
        Sinking [m], shape (M,); 0 of a bed that floats free of any contact.
    """
    up = up_direction(bed)
    height, radius = position @ up, bed.radius[index]
    body_index = None if bed.body_index is None else bed.body_index[index]
    low, high, strain = _contacts(bed, position, radius, up, body_index)
    if len(low) == 0:
        return np.zeros(len(index))
    # The strain changes where a contact begins or ends, and is constant between.
    ends = np.concatenate((low, high))
    order = np.argsort(ends, kind="stable")
    crossing = np.cumsum(np.repeat([1, -1], len(low))[order])[:-1]
    summed = np.cumsum(np.concatenate((strain, -strain))[order])[:-1]
    mean = np.divide(summed, crossing, out=np.zeros(len(summed)), where=crossing > 0)
    sunk = np.concatenate(([0.0], np.cumsum(mean * np.diff(ends[order]))))
    return np.interp(height, ends[order], sunk)


def _contacts(
    bed: Bed, position: Float64Array, radius: Float64Array, up: Float64Array, body_index: Int32Array | None
) -> tuple[Float64Array, Float64Array, Float64Array]:
    """Return lower and upper end of the height [m] that each contact spans, and its delta / L; each (C,)."""
    height = position @ up
    length = bed.container.bounds[1] - bed.container.bounds[0]
    wraps = np.array(bed.container.periodic)
    lows, highs, strains = [], [], []
    for pairs in near_pairs(position, radius, period=bed.container.period, body_index=body_index):
        distance = radius[pairs.first] + radius[pairs.second] + pairs.gap
        apart = position[pairs.second] - position[pairs.first]
        apart[:, wraps] -= length[wraps] * np.round(apart[:, wraps] / length[wraps])
        lower = np.minimum(height[pairs.first], height[pairs.second])
        lows.append(lower)
        highs.append(lower + np.abs(apart @ up))
        strains.append(np.maximum(-pairs.gap, 0.0) / distance)
    if not all(wraps):
        clearance = wall_clearance(bed.container, position, radius)
        touching = np.flatnonzero((clearance > 0) & (clearance < radius))
        # The clearance grows along the wall's normal: its slope along the vertical is the normal's part.
        step = TINY * radius[touching]
        raised = position[touching] + step[:, None] * up
        rise = wall_clearance(bed.container, raised, radius[touching]) - clearance[touching]
        below = height[touching] - clearance[touching] * np.clip(rise / step, -1, 1)
        lows.append(np.minimum(below, height[touching]))
        highs.append(np.maximum(below, height[touching]))
        strains.append(radius[touching] / clearance[touching] - 1)
    if not lows:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    return np.concatenate(lows), np.concatenate(highs), np.concatenate(strains)
