"""Local order: which spheres sit in a crystal, by the bonds of Steinhardt's order parameters."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from packgen.arrays import Float64Array, Int32Array, Int64Array, add_at, tallied
from packgen.bed import Bed, has_clumps
from packgen.check import near_pairs, wall_clearance
from packgen.measure.core import Core
from packgen.measure.particles import as_particles
from packgen.part import Part

NEIGHBOUR_GAP = (
    0.6  # of the smaller radius: 1.3 diameters between equal spheres, half way to fcc's second shell
)
ALIKE_MIN = 0.7  # product of two spheres' normalised order above which their surroundings are alike
BONDS_MIN = 7  # bonds of a sphere in a crystal
PAIRS_AT_ONCE = 400_000
LEGENDRE_6 = Polynomial([-5.0, 0.0, 105.0, 0.0, -315.0, 0.0, 231.0]) / 16.0
WALL_REACH = 2.0  # radii: spheres with centres so near to a wall are in its layer


@dataclass(frozen=True, slots=True)
class LocalOrder:
    """Shares of a bed's spheres that sit in a crystal, and how well the spheres' neighbours are ordered.

    Attributes:
        crystal: Share of all spheres.
        crystal_wall: Share of the spheres within two radii of a wall; None where there are none.
        crystal_core: Share of the spheres of the core; None without a core.
        bonds: Number of spheres with 0, 1, 2, ... bonds to spheres in surroundings like their own.
    """

    crystal: float
    crystal_wall: float | None
    crystal_core: float | None
    bonds: tuple[int, ...]


def local_order(bed: Bed, core: Core | None, clearance: Float64Array | None = None) -> LocalOrder:
    """Return how much of a bed is crystal: of the whole, along the walls, and in its core.

    Clumps count by their centres of mass, and the radii of the spheres of their volumes.

    Args:
        bed: The bed.
        core: The core, such as `packgen.measure.core_of` gives.
        clearance: Distance of each centre from the nearest wall [m], exact up to `WALL_REACH` radii, where it
            is known; shape (N,).

    Returns:
        The shares; all zero for a bed without spheres.
    """
    counter = OrderCounter(core)
    counter.add(Part.whole(as_particles(bed)), None if has_clumps(bed) else clearance)
    return counter.result()


class OrderCounter:
    """Counts the crystals of a bed in parts, as of the bed in one.

    Args:
        core: The core of the bed.

    Attributes:
        REACH: How far around a part spheres count, in largest radii: the neighbours of its neighbours.
    """

    REACH = 2.0 * (2.0 + NEIGHBOUR_GAP)

    def __init__(self, core: Core | None) -> None:
        self._core = core
        self._bonds = np.zeros(0, dtype=np.int64)
        self._of_all, self._of_wall, self._of_core = np.zeros((3, 2), dtype=np.int64)

    def add(self, part: Part, clearance: Float64Array | None = None) -> None:
        """Count the crystals of a part; clearance as `local_order` has it, of its own spheres, (own,)."""
        own = slice(part.own)
        bonds = crystal_bonds(part.bed)[own]
        position, reach = part.bed.position[own], part.bed.radius[own] * WALL_REACH
        if clearance is None:
            clearance = wall_clearance(part.bed.container, position, reach)
        crystal = bonds >= BONDS_MIN
        self._bonds = tallied(self._bonds, bonds)
        self._of_all += _among(crystal, np.ones(part.own, dtype=bool))
        self._of_wall += _among(crystal, clearance < reach)
        if self._core is not None:
            self._of_core += _among(crystal, self._core.contains(position))

    def result(self) -> LocalOrder:
        """Return what was counted of all parts."""
        return LocalOrder(
            crystal=_share(self._of_all) or 0.0,
            crystal_wall=_share(self._of_wall),
            crystal_core=_share(self._of_core),
            bonds=tuple(self._bonds.tolist()),
        )


def crystal_bonds(bed: Bed) -> Int32Array:
    """Return how many neighbours of each sphere have surroundings like its own.

    Each sphere has the vector q6m of Steinhardt, Nelson and Ronchetti (Phys. Rev. B 28, 1983, 784), the sum
    of the spherical harmonics of degree 6 over the directions to its neighbours. Neighbours are alike where
    the product of their normalised vectors exceeds `ALIKE_MIN`; a sphere with `BONDS_MIN` such bonds is in a
    crystal (ten Wolde, Ruiz-Montero and Frenkel, J. Chem. Phys. 104, 1996, 9932). The bounds are those in use
    for hard spheres. Every sphere of fcc, hcp or bcc has all its bonds; in random packings most have fewer
    than four.

    Args:
        bed: The bed; neighbours are those with gaps up to `NEIGHBOUR_GAP` of the smaller radius.

    Returns:
        Number of bonds of each sphere, shape (N,), int32.
    """
    first, second = _neighbours(bed)
    order = np.zeros((bed.count, 13), dtype=np.float32)
    for piece in _pieces(len(first)):
        apart = bed.position[second[piece]] - bed.position[first[piece]]
        for axis, period in enumerate(bed.container.period):
            if period is not None:
                apart[:, axis] -= period * np.round(apart[:, axis] / period)
        length = np.linalg.norm(apart, axis=1)
        apart /= np.where(length > 0.0, length, 1.0)[:, None]  # spheres in one place have no direction
        parts = _harmonics(apart)  # even degree: the same from both ends
        for end in (first[piece], second[piece]):
            for column, part in enumerate(parts):
                add_at(order[:, column], end, part)
    order /= np.maximum(np.sqrt(np.einsum("ij,ij->i", order, order)), 1e-30)[:, None]
    bonds = np.zeros(bed.count, dtype=np.int32)
    for piece in _pieces(len(first)):
        ends = first[piece], second[piece]
        alike = np.einsum("ij,ij->i", order[ends[0]], order[ends[1]]) > ALIKE_MIN
        for end in ends:
            add_at(bonds, end[alike])
    return bonds


def _neighbours(bed: Bed) -> tuple[Int32Array, Int32Array]:
    """Return the pairs of neighbours, (P,) each."""
    found = [
        (pairs.first.astype(np.int32), pairs.second.astype(np.int32))
        for pairs in near_pairs(
            bed.position, bed.radius, gap_fraction=NEIGHBOUR_GAP, period=bed.container.period
        )
    ]
    none = np.zeros(0, dtype=np.int32)
    return np.concatenate([none, *(pairs[0] for pairs in found)]), np.concatenate(
        [none, *(pairs[1] for pairs in found)]
    )


def _pieces(count: int) -> list[slice]:
    """Return slices of a list of pairs that fit in a cache or two."""
    return [slice(start, start + PAIRS_AT_ONCE) for start in range(0, count, PAIRS_AT_ONCE)]


def _harmonics(direction: Float64Array) -> list[Float64Array]:
    """Return the 13 real spherical harmonics of degree 6 of unit vectors (P, 3), up to a common factor.

    Products of two vectors of them are those of the complex ones. Of order m they are the real and the
    imaginary part of ``(x + i y)^m`` times the m-th derivative of Legendre's P6 and
    ``sqrt((6 - m)! / (6 + m)!)`` (Abramowitz and Stegun, 8.6.6).
    """
    x, y, z = direction.T
    around, power = x + 1j * y, np.ones(len(z), dtype=np.complex128)
    parts = []
    for m in range(7):
        scale = math.sqrt((2.0 if m else 1.0) * math.factorial(6 - m) / math.factorial(6 + m))
        along = scale * LEGENDRE_6.deriv(m)(z)
        parts.append(along * power.real)
        if m:
            parts.append(along * power.imag)
        power *= around
    return parts


def _among(chosen: NDArray[np.bool_], among: NDArray[np.bool_]) -> Int64Array:
    """Return how many spheres are chosen among some, and how many these are, shape (2,)."""
    return np.array([np.count_nonzero(chosen & among), np.count_nonzero(among)])


def _share(counts: Int64Array) -> float | None:
    """Return the share of the first number in the second; None where that is 0."""
    chosen, count = counts.tolist()
    return float(chosen) / count if count else None
