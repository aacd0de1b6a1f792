"""Contacts that a solver lists, and how far their forces are off Hertz' law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.errors import SolverError
from packgen.measure import hertz as law
from packgen.measure.forces import pair_forces, primitive_wall_forces

FORCE_FLOOR = 1.0e-3  # mean sphere weights: smaller forces are compared with the law absolutely


@dataclass(frozen=True, eq=False, slots=True)
class Contacts:
    """Contacts that a solver found.

    Attributes:
        first: Index of the sphere, shape (C,), int64.
        second: Index of the other sphere, shape (C,), int64; None: contacts with walls.
        force: Size of the force [N], shape (C,), float64.
        overlap: Overlap [m], shape (C,), float64.
        part: The named part of the walls, -1 for those without a name, shape (C,), int64; None: walls have no
            parts.
    """

    first: Int64Array
    second: Int64Array | None
    force: Float64Array
    overlap: Float64Array
    part: Int64Array | None = None


def law_error(difference: Float64Array, expected: Float64Array, weight: float) -> float:
    """Return the largest difference [N], relative to the force expected or to `FORCE_FLOOR` mean weights."""
    scale = np.maximum(np.abs(expected), FORCE_FLOOR * weight)
    return float((np.abs(difference) / scale).max(initial=0.0))


def pair_error(bed: Bed, pairs: Contacts) -> float:
    """Return how far the forces between spheres are off Hertz' law at the overlaps that the bed itself has.

    The overlaps are those of the positions and radii, not the solver's: solvers that agree with the law agree
    with each other. A pair that overlaps and that the solver does not list counts as one without a force.
    """
    assert pairs.second is not None
    expected = list(pair_forces(bed))
    keys = [_key(bed, first, second) for first, second, _ in expected]
    forces = np.concatenate([*(force for _, _, force in expected), pairs.force])
    keys.append(_key(bed, pairs.first, pairs.second))
    _, place = np.unique(np.concatenate(keys), return_inverse=True)
    by_law = np.arange(len(forces)) < len(forces) - len(pairs.force)
    wanted, found = np.zeros(len(forces)), np.zeros(len(forces))
    np.add.at(wanted, place[by_law], forces[by_law])
    np.add.at(found, place[~by_law], forces[~by_law])
    return law_error(found - wanted, wanted, law.mean_weight(bed))


def _key(bed: Bed, first: Int64Array, second: Int64Array) -> Int64Array:
    """Return one number for each pair (P,), whatever the order of the two."""
    key: Int64Array = np.minimum(first, second) * bed.count + np.maximum(first, second)
    return key


def listed_error(bed: Bed, walls: Contacts, *, radius_factor: float | Float64Array = 1.0) -> float:
    """Return how far listed contacts with walls are off Hertz' law.

    Args:
        bed: The bed.
        walls: The contacts.
        radius_factor: The solver's effective radius of a sphere at a wall, as a fraction of its radius; a
            number, or one a contact (C,).
    """
    moduli = law.wall_modulus(bed, bed.type_index[walls.first], walls.part)
    expected = law.hertz_force(moduli, radius_factor * bed.radius[walls.first], walls.overlap)
    return law_error(walls.force - expected, expected, law.mean_weight(bed))


def primitive_contacts(bed: Bed, wall_force: Float64Array) -> tuple[Contacts, float]:
    """Return contacts with LIGGGHTS' primitive walls, told from the force that they leave on each sphere.

    Args:
        bed: The bed.
        wall_force: What the walls do to each sphere [N], shape (N, 3).

    Returns:
        The contacts, each direction once, and how far they are off Hertz' law.

    Raises:
        SolverError: The container has no primitive walls.
    """
    both = primitive_wall_forces(bed, wall_force)
    if both is None:
        raise SolverError(
            "the deck has no mesh walls, and the container is none that has primitive walls: their forces"
            " cannot be checked"
        )
    found, expected = both
    weight = law.mean_weight(bed)
    # A remainder of rounding is no contact.
    sphere, column = np.nonzero(np.abs(found) > 1e-9 * weight)
    force = np.abs(found[sphere, column])
    overlap = law.hertz_overlap(law.wall_modulus(bed, bed.type_index)[sphere], bed.radius[sphere], force)
    error = law_error(found - expected, expected, weight)
    return Contacts(sphere.astype(np.int64), None, force, overlap), error
