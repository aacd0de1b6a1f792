"""Materials as a solver wants them: numbered types, coefficients of each pair of types, and the time step.

Restitution, sliding and rolling friction of a pair follow `packgen.bed.pair_coefficient`. Young's modulus and
Poisson's ratio need no rule: the Hertz law takes those of both sides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from packgen.bed import AnyBed, Material, pair_coefficient
from packgen.errors import ExportError

STANDARD_GRAVITY = 9.80665  # m/s2; for the rolling stiffness of a weightless bed


@dataclass(frozen=True, slots=True)
class Types:
    """The atom types of a deck, numbered from 1.

    Attributes:
        materials: The material of each type, in the order of the bed; those that nothing uses are left out,
            since LIGGGHTS refuses a deck in which type 1 is not used.
        by_set: Type of each particle set, shape (S,); 0 for a set without spheres whose material is not used.
        wall: Type of the walls; that of the first spheres where the bed has no wall.
        by_part: Type of each named part of the walls, shape (P,).
    """

    materials: tuple[Material, ...]
    by_set: tuple[int, ...]
    wall: int
    by_part: tuple[int, ...] = ()


def number_types(bed: AnyBed, *, has_wall: bool = True) -> Types:
    """Number the materials that the spheres and the walls of a bed use.

    Raises:
        ExportError: A material is used and not declared.
    """
    counts = bed.census.counts
    used = {each.material for each, count in zip(bed.particle_sets, counts, strict=True) if count}
    if has_wall:
        used.add(bed.wall_material)
        used |= {each.material for each in bed.container.parts}
    unknown = sorted(used - {each.name for each in bed.materials})
    if unknown:
        raise ExportError(f"materials: {', '.join(unknown)} used, but not declared")
    materials = tuple(each for each in bed.materials if each.name in used)
    number = {each.name: index for index, each in enumerate(materials, start=1)}
    by_set = tuple(number.get(each.material, 0) for each in bed.particle_sets)
    by_part = tuple(number[each.material] for each in bed.container.parts) if has_wall else ()
    return Types(materials, by_set, number.get(bed.wall_material, 1), by_part)


def pair_matrix(values: Sequence[float]) -> list[list[float]]:
    """Return the coefficient of each pair of ``values``, a symmetric (T, T) table; see `pair_coefficient`."""
    return [[pair_coefficient(first, second) for second in values] for first in values]


def rayleigh_time(radius: float, density: float, material: Material) -> float:
    """Return the time that a Rayleigh wave takes along half the circumference of a sphere [s].

    T = pi r sqrt(rho / G) / (0.1631 nu + 0.8766) with the shear modulus G = E / (2 (1 + nu)); LIGGGHTS
    manual, page "fix check/timestep/gran".
    """
    shear_modulus = material.youngs_modulus / (2 * (1 + material.poissons_ratio))
    speed_factor = 0.1631 * material.poissons_ratio + 0.8766
    return float(np.pi * radius * np.sqrt(density / shear_modulus) / speed_factor)


def smallest_rayleigh_time(bed: AnyBed) -> float:
    """Return the smallest Rayleigh time of all spheres [s]: that of the smallest sphere of one set."""
    material = {each.name: each for each in bed.materials}
    return min(
        rayleigh_time(radius, each.density, material[each.material])
        for each, radius in zip(bed.particle_sets, bed.census.radius_min, strict=True)
        if np.isfinite(radius)
    )


def effective_moduli(first: Material, second: Material) -> tuple[float, float]:
    """Return the effective Young's and shear modulus of a contact of two materials [Pa].

    1 / Y = sum (1 - nu^2) / E and 1 / G = sum 2 (2 - nu) (1 + nu) / E; LIGGGHTS manual, page "gran model
    hertz".
    """
    both = (first, second)
    young = 1 / sum((1 - each.poissons_ratio**2) / each.youngs_modulus for each in both)
    shear = 1 / sum(
        2 * (2 - each.poissons_ratio) * (1 + each.poissons_ratio) / each.youngs_modulus for each in both
    )
    return young, shear


def rolling_stiffness(bed: AnyBed, young: float, shear: float) -> float:
    """Return 8 G sqrt(R delta) [N/m] of two mean spheres pressed together by the weight of one.

    LIGGGHTS' rolling model epsd2 takes the tangential stiffness of each contact; other codes take one number.

    Args:
        bed: The bed.
        young: Effective Young's modulus of the contact [Pa].
        shear: Effective shear modulus of the contact [Pa].
    """
    radius = bed.census.radius_mean / 2
    strength = float(np.linalg.norm(bed.gravity)) or STANDARD_GRAVITY
    cubes = zip(bed.particle_sets, bed.census.cube_sum, strict=True)
    mean = sum(each.density * float(cube) for each, cube in cubes if cube) / bed.count
    weight = 4 / 3 * np.pi * mean * strength
    overlap = (weight / (4 / 3 * young * np.sqrt(radius))) ** (2 / 3)
    return float(8 * shear * np.sqrt(radius * overlap))
