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
    weight = law.mean_weight(bed)
    pair_force, worst_pair, pair_count = 0.0, None, 0
    for first, second, force in pair_forces(bed):
        pair_count += int(np.count_nonzero(force))
        worst = int(force.argmax())
        if force[worst] > pair_force:
            pair_force, worst_pair = float(force[worst]), (int(first[worst]), int(second[worst]))
    if clearance is None:
        clearance = wall_clearance(bed.container, bed.position, bed.radius)
    wall_force = np.zeros(bed.count)
    if not all(bed.container.periodic):
        depth = np.where(np.isfinite(clearance), bed.radius - clearance, 0.0)
        part = nearest_part(bed.container, bed.position, bed.radius) if bed.container.parts else None
        wall_force = law.hertz_force(law.wall_modulus(bed, bed.type_index, part), bed.radius, depth)
    worst_wall = int(wall_force.argmax())
    return PredictedForces(
        weight=weight,
        pair_force_max=pair_force / weight,
        worst_pair=worst_pair,
        pair_count=pair_count,
        wall_force_max=float(wall_force[worst_wall]) / weight,
        worst_wall_sphere=worst_wall if wall_force[worst_wall] > 0 else None,
        wall_count=int(np.count_nonzero(wall_force)),
        outside=int(np.count_nonzero(clearance < 0)),
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
