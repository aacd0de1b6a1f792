"""The contact law that every solver's step-0 forces are held against: Hertz, without motion, in closed form.

LIGGGHTS manual, page "gran model hertz", and K. L. Johnson, Contact Mechanics (1985), chapter 4:
F = 4/3 Y sqrt(R) delta^1.5 with 1/Y = (1 - nu_i^2) / E_i + (1 - nu_j^2) / E_j, and the effective radius
R = r_i r_j / (r_i + r_j) of two spheres, or r of a sphere at a wall. At step 0 nothing moves, so that there
is neither damping nor friction.
"""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array, Int32Array, Int64Array
from packgen.bed import Bed, Material, has_clumps
from packgen.measure.particles import member_mass, particle_count, particle_radius

STANDARD_GRAVITY = 9.80665  # m/s2; for the weights in a bed without gravity


def effective_modulus(first: Material, second: Material) -> float:
    """Return Y [Pa] of a contact of two materials."""
    compliance = sum((1 - each.poissons_ratio**2) / each.youngs_modulus for each in (first, second))
    return 1 / compliance


def effective_radius(first: Float64Array, second: Float64Array) -> Float64Array:
    """Return r_i r_j / (r_i + r_j) [m] of pairs of radii (P,) [m], shape (P,)."""
    return first * second / (first + second)


def hertz_force(modulus: Float64Array, radius: Float64Array, overlap: Float64Array) -> Float64Array:
    """Return the elastic force [N] of contacts, 0 where they are apart.

    Args:
        modulus: Effective moduli [Pa], shape (P,).
        radius: Effective radii [m], shape (P,).
        overlap: Overlaps delta [m], negative where apart, shape (P,).
    """
    force: Float64Array = 4 / 3 * modulus * np.sqrt(radius) * np.maximum(overlap, 0.0) ** 1.5
    return force


def hertz_overlap(modulus: Float64Array, radius: Float64Array, force: Float64Array) -> Float64Array:
    """Return the overlap [m] that makes a force [N]: `hertz_force` solved for it."""
    overlap: Float64Array = (np.abs(force) / (4 / 3 * modulus * np.sqrt(radius))) ** (2 / 3)
    return overlap


def modulus_table(bed: Bed) -> Float64Array:
    """Return the effective modulus [Pa] of each pair of the bed's materials, shape (M, M)."""
    return np.array([[effective_modulus(a, b) for b in bed.materials] for a in bed.materials])


def wall_modulus(bed: Bed, type_index: Int32Array, part: Int64Array | None = None) -> Float64Array:
    """Return the effective modulus [Pa] of spheres at the wall, shape (N,).

    Args:
        bed: The bed.
        type_index: Index into the materials of each sphere, shape (N,), int32.
        part: The named part of the walls that each is at, -1 for those without a name, shape (N,), int64;
            None: no part has a material of its own.
    """
    modulus: Float64Array = modulus_table(bed)[type_index, wall_type(bed, len(type_index), part)]
    return modulus


def wall_type(bed: Bed, count: int, part: Int64Array | None = None) -> Int64Array:
    """Return the index into the bed's materials of the wall at each of ``count`` spheres, shape (N,)."""
    names = [each.name for each in bed.materials]
    wall = names.index(bed.wall_material)
    if part is None:
        return np.full(count, wall, np.int64)
    # Index -1, walls without a name, is the last one.
    types = np.array([*(names.index(each.material) for each in bed.container.parts), wall], np.int64)
    return np.asarray(types[part])


def gravity_strength(bed: Bed) -> float:
    """Return the strength of gravity [m/s2], of a weightless bed the Earth's."""
    return float(np.linalg.norm(bed.gravity)) or STANDARD_GRAVITY


def sphere_mass(bed: Bed) -> Float64Array:
    """Return the mass of each sphere [kg], shape (N,); of one of a clump, its share of the clump's mass."""
    if has_clumps(bed):
        return member_mass(bed)
    return 4 / 3 * np.pi * bed.density * bed.radius**3


def mean_weight(bed: Bed) -> float:
    """Return the mean weight of a particle [N], a sphere or a clump: the unit in which forces are judged."""
    return float(sphere_mass(bed).sum()) / particle_count(bed) * gravity_strength(bed)


def mean_radius(bed: Bed) -> float:
    """Return the mean radius of a particle [m], of a clump that of the sphere of its volume."""
    return float(particle_radius(bed).mean())


def rayleigh_time(bed: Bed) -> float:
    """Return the smallest Rayleigh time of all spheres [s].

    T = pi r sqrt(rho / G) / (0.1631 nu + 0.8766), G = E / (2 (1 + nu)); LIGGGHTS manual, page
    "fix check/timestep/gran".
    """
    poisson = np.array([each.poissons_ratio for each in bed.materials])
    shear = np.array([each.youngs_modulus for each in bed.materials]) / (2 * (1 + poisson))
    types = bed.type_index
    time = np.pi * bed.radius * np.sqrt(bed.density / shear[types]) / (0.1631 * poisson[types] + 0.8766)
    return float(time.min())
