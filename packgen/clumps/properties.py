"""Volume, centre and inertia: of a closed mesh by its tetrahedra, of a union of spheres by its surface."""

from __future__ import annotations

from functools import cache

import numpy as np

from packgen.arrays import Float64Array
from packgen.bodies.mass import MassProperties
from packgen.clumps.union_kernels import union_integrals

NODES = 32
"""Nodes of Gauss's rule between two cuts of a sphere: unions of a hundred spheres are exact to about 1e-8."""


def mesh_properties(corners: Float64Array) -> MassProperties:
    """Return the properties of what a closed surface bounds.

    Args:
        corners: Triangles, counter-clockwise from outside [m], shape (F, 3, 3), float64.
    """
    origin = corners.reshape(-1, 3).mean(axis=0)
    near = corners - origin
    six = np.einsum("fi,fi->f", near[:, 0], np.cross(near[:, 1], near[:, 2]))
    volume = float(six.sum() / 6.0)
    total = near.sum(axis=1)
    first = six @ total / 24.0
    # Of a tetrahedron with a corner at the origin: det / 120 * (sum of a aT + s sT), s the corners' sum.
    second = np.einsum("f,fki,fkj->ij", six, near, near) + np.einsum("f,fi,fj->ij", six, total, total)
    return _of_moments(volume, first, second / 120.0).moved(origin)


def union_properties(spheres: Float64Array) -> MassProperties:
    """Return the properties of a union of spheres, each place counted once.

    Args:
        spheres: Centres and radii [m], shape (N, 4), float64.
    """
    return _of_terms(*_integrals(spheres))


def union_area(spheres: Float64Array) -> float:
    """Return the area of the surface of a union of spheres (N, 4) [m2]."""
    return float(_integrals(spheres)[0][0])


def sum_of_spheres(spheres: Float64Array) -> float:
    """Return the volume of spheres (N, 4) one by one, overlaps counted several times [m3]."""
    return float(4.0 / 3.0 * np.pi * (spheres[:, 3] ** 3).sum())


def without_contained(spheres: Float64Array) -> Float64Array:
    """Return the spheres (N, 4) that are in no other one; of equal ones the first."""
    away = np.linalg.norm(spheres[:, None, :3] - spheres[None, :, :3], axis=2)
    deeper = spheres[None, :, 3] - spheres[:, None, 3] - away
    rank = np.arange(len(spheres))
    inside = (deeper > 0.0) | ((deeper == 0.0) & ((away > 0.0) | (rank[None, :] < rank[:, None])))
    np.fill_diagonal(inside, val=False)
    kept: Float64Array = spheres[~inside.any(axis=1)]
    return kept


def _integrals(spheres: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return the integrals of a union about an origin within it, and the origin [m]."""
    kept = without_contained(np.asarray(spheres, np.float64))
    origin = kept[:, :3].mean(axis=0)
    near = np.ascontiguousarray(kept - np.append(origin, 0.0))
    return union_integrals(near, *_rule()), origin


@cache
def _rule() -> tuple[Float64Array, Float64Array]:
    node, weight = np.polynomial.legendre.leggauss(NODES)
    return node, weight


def _of_terms(terms: Float64Array, origin: Float64Array) -> MassProperties:
    xx, yy, zz, xy, xz, yz = terms[5:]
    second = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return _of_moments(float(terms[1]), terms[2:5], second).moved(origin)


def _of_moments(volume: float, first: Float64Array, second: Float64Array) -> MassProperties:
    """Return the properties that a volume and its first and second moments about the origin amount to."""
    centre = first / volume if volume else np.zeros(3)
    about = second - volume * np.outer(centre, centre)
    return MassProperties(volume, centre, np.trace(about) * np.eye(3) - about)
