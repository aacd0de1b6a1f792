"""Step-0 contact forces from geometry alone: what a solver will find, without the solver.

Example::

    forces = predicted_forces(bed)
    forces.force_max  # in sphere weights; above 1 the bed is not at rest
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.check import near_pairs, wall_clearance
from packgen.check.parts import nearest_part
from packgen.geometry import Box, Cone
from packgen.measure import hertz as law
from packgen.part import Part


@dataclass(frozen=True, slots=True)
class PredictedForces:
    """The largest contact forces of a bed at rest, by Hertz' law and the deck's own materials.

    Attributes:
        weight: Mean weight of a sphere [N].
        pair_force_max: Largest force between two spheres, in mean sphere weights; 0 where none overlap.
        worst_pair: Indices of the two; None where none overlap.
        pair_count: Number of pairs that overlap.
        wall_force_max: Largest force of a wall, in mean sphere weights; 0 where no sphere is in a wall.
        worst_wall_sphere: Index of that sphere; None where none is.
        wall_count: Number of spheres that are in a wall; the nearest wall of each counts.
        outside: Number of spheres whose centre is outside the container.
    """

    weight: float
    pair_force_max: float
    worst_pair: tuple[int, int] | None
    pair_count: int
    wall_force_max: float
    worst_wall_sphere: int | None
    wall_count: int
    outside: int

    @property
    def force_max(self) -> float:
        """Largest force of all, in mean sphere weights."""
        return max(self.pair_force_max, self.wall_force_max)


def predicted_forces(bed: Bed, clearance: Float64Array | None = None) -> PredictedForces:
    """Return the largest step-0 forces of a bed; all zero for a bed without spheres.

    Args:
        bed: The bed.
        clearance: Distance of each centre from the nearest wall [m], exact up to a radius, where it is known;
            shape (N,).
    """
    if bed.count == 0:
        return PredictedForces(0.0, 0.0, None, 0, 0.0, None, 0, 0)
    counter = ForceCounter(law.mean_weight(bed))
    counter.add(Part.whole(bed), clearance)
    return counter.result()


class ForceCounter:
    """Finds the largest forces of a bed in parts, as of the bed in one.

    Args:
        weight: Mean weight of the bed's spheres [N].
    """

    def __init__(self, weight: float) -> None:
        self._weight = weight
        self._pair_force, self._pair = 0.0, (0, 0)
        self._wall_force, self._at_wall = 0.0, 0
        self._pairs = self._walls = self._outside = 0

    def add(self, part: Part, clearance: Float64Array | None = None) -> None:
        """Look at a part; clearance as `predicted_forces` has it, of its own spheres, (own,)."""
        bed, own = part.bed, slice(part.own)
        for first, second, force in pair_forces(bed):
            counted = np.flatnonzero(part.counted(first, second)) if not part.is_whole else slice(None)
            one, other, found = first[counted], second[counted], force[counted]
            self._pairs += int(np.count_nonzero(found))
            worst = int(found.argmax()) if len(found) else 0
            if len(found) and found[worst] > self._pair_force:
                self._pair_force = float(found[worst])
                self._pair = int(part.number[one[worst]]), int(part.number[other[worst]])
        radius = bed.radius[own]
        if clearance is None:
            clearance = wall_clearance(bed.container, bed.position[own], radius)
        self._outside += int(np.count_nonzero(clearance < 0))
        if all(bed.container.periodic) or part.own == 0:
            return
        depth = np.where(np.isfinite(clearance), radius - clearance, 0.0)
        wall = nearest_part(bed.container, bed.position[own], radius) if bed.container.parts else None
        wall_force = law.hertz_force(law.wall_modulus(bed, bed.type_index[own], wall), radius, depth)
        worst = int(wall_force.argmax())
        self._walls += int(np.count_nonzero(wall_force))
        if wall_force[worst] > self._wall_force:
            self._wall_force, self._at_wall = float(wall_force[worst]), int(part.number[worst])

    def result(self) -> PredictedForces:
        """Return the largest forces of all parts."""
        return PredictedForces(
            weight=self._weight,
            pair_force_max=self._pair_force / self._weight,
            worst_pair=self._pair if self._pair_force > 0.0 else None,
            pair_count=self._pairs,
            wall_force_max=self._wall_force / self._weight,
            worst_wall_sphere=self._at_wall if self._wall_force > 0.0 else None,
            wall_count=self._walls,
            outside=self._outside,
        )


def pair_forces(bed: Bed) -> Iterator[tuple[Int64Array, Int64Array, Float64Array]]:
    """Yield the spheres of pairs that touch or overlap, and their forces by Hertz' law [N]; each (P,).

    Spheres of one body do not press on each other.
    """
    types, moduli = bed.type_index, law.modulus_table(bed)
    period, bodies = bed.container.period, bed.body_index
    for pairs in near_pairs(bed.position, bed.radius, period=period, body_index=bodies):
        radius = law.effective_radius(bed.radius[pairs.first], bed.radius[pairs.second])
        modulus = moduli[types[pairs.first], types[pairs.second]]
        yield pairs.first, pairs.second, law.hertz_force(modulus, radius, -pairs.gap)


def primitive_wall_forces(bed: Bed, force: Float64Array) -> tuple[Float64Array, Float64Array] | None:
    """Return found and expected forces of primitive walls, a column for each direction that a wall pushes.

    Args:
        bed: The bed.
        force: What the walls do to each sphere by the solver [N], shape (N, 3).

    Returns:
        Found and expected components [N], both (N, 3) for a box (x, y, z) and (N, 2) for a cylinder (along
        its axis, inwards from its side); None for a container that has no primitive walls.
    """
    shape = bed.container.shape
    wall_modulus = law.wall_modulus(bed, bed.type_index)[:, None]
    radius = bed.radius[:, None]
    if isinstance(shape, Box):
        walled = ~np.array(bed.container.periodic)
        low = law.hertz_force(wall_modulus, radius, radius - (bed.position - shape.min))
        high = law.hertz_force(wall_modulus, radius, radius - (shape.max - bed.position))
        return force * walled, np.where(walled, low - high, 0.0)
    if isinstance(shape, Cone) and shape.radius_bottom == shape.radius_top:
        relative = bed.position - shape.base
        along = relative @ shape.axis
        across = relative - along[:, None] * shape.axis
        distance = np.linalg.norm(across, axis=1)
        inwards = -across / np.maximum(distance, np.finfo(float).tiny)[:, None]
        found = np.stack((force @ shape.axis, np.einsum("ij,ij->i", force, inwards)), axis=1)
        depth = np.stack((bed.radius - along, bed.radius - (shape.height - along)), axis=1)
        ends = law.hertz_force(wall_modulus, radius, depth)
        side = law.hertz_force(wall_modulus[:, 0], bed.radius, bed.radius - (shape.radius_top - distance))
        return found, np.stack((ends[:, 0] - ends[:, 1], side), axis=1)
    return None
