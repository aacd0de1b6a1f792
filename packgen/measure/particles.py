"""The particles of a bed: spheres, and clumps of them; a clump counts, weighs and measures as one."""

from __future__ import annotations

import numpy as np

from packgen.arrays import BoolArray, Float64Array, Int64Array
from packgen.bed import Bed, has_clumps
from packgen.bodies import UnbalancedError, sphere_shares

__all__ = [
    "Particles",
    "alone",
    "member_mass",
    "member_share",
    "particle_count",
    "particle_radius",
    "particles_of",
]


def particle_count(bed: Bed) -> int:
    """Return the number of particles."""
    return len(bed.bodies) if has_clumps(bed) and bed.bodies is not None else bed.count


def particle_radius(bed: Bed) -> Float64Array:
    """Return the radius of each particle [m], of a clump that of the sphere of its volume, shape (M,)."""
    return bed.bodies.equivalent_radius if has_clumps(bed) and bed.bodies is not None else bed.radius


def alone(bed: Bed) -> BoolArray:
    """Return which spheres are particles of their own, shape (N,), bool."""
    if not has_clumps(bed) or bed.bodies is None:
        return np.ones(bed.count, bool)
    return np.asarray(bed.bodies.sphere_count[bed.body_index] == 1)


def member_share(bed: Bed) -> Float64Array:
    """Return the share of its particle's mass that each sphere stands for, shape (N,).

    Where no shares of a template's spheres have its centre of mass, those of the spheres' volumes.
    """
    share = np.ones(bed.count)
    if not has_clumps(bed) or bed.bodies is None or bed.body_index is None:
        return share
    order = np.argsort(bed.body_index, kind="stable")
    try:
        share[order] = sphere_shares(bed.bodies)
    except UnbalancedError:
        own = bed.radius**3
        share = own / np.bincount(bed.body_index, own)[bed.body_index]
    return share


def member_mass(bed: Bed) -> Float64Array:
    """Return the mass that each sphere of a bed with clumps stands for [kg], shape (N,)."""
    assert bed.bodies is not None
    return np.asarray(bed.density * member_share(bed) * bed.bodies.volume[bed.body_index])


class Particles:
    """What is known of spheres, told of the particles that they are of.

    Args:
        bed: The bed, which has clumps.

    Attributes:
        row: Row of each sphere's body, shape (N,), int64.
    """

    def __init__(self, bed: Bed) -> None:
        assert bed.body_index is not None
        self.row = bed.body_index.astype(np.int64)
        self._share = member_share(bed)

    def touched(self, sphere: Int64Array) -> Int64Array:
        """Return the rows of the bodies of some spheres, rising, each once."""
        return np.unique(self.row[sphere])

    def means(self, sphere: Int64Array, values: Float64Array) -> tuple[Int64Array, Float64Array]:
        """Return the rows of whole bodies, rising, and the means over the spheres of each.

        Args:
            sphere: All spheres of some bodies, shape (n,).
            values: A vector of each, shape (n, 3): of their places the mean is the centre of mass.

        Returns:
            Rows, shape (b,), and means by the spheres' shares of the mass, shape (b, 3).
        """
        rows, place = np.unique(self.row[sphere], return_inverse=True)
        part = self._share[sphere, None] * values
        sums = [np.bincount(place, part[:, axis], len(rows)) for axis in range(3)]
        return rows, np.stack(sums, axis=1)


def particles_of(bed: Bed) -> Particles | None:
    """Return the particles of a bed with clumps; None of one whose spheres are its particles."""
    return Particles(bed) if has_clumps(bed) else None
