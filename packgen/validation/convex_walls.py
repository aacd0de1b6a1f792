"""The forces of a convex container's walls by Hertz' law, for solvers that tell only the sum.

LAMMPS' regions push a sphere along the normal of each wall that it reaches, where the foot of its centre on
the wall is inside all the other walls, and take the curvature of the wall in: the effective radius is
1 / (1/r - k) with k = 1/R of a ball and 1/(2 R) of a cylinder or cone of radius R at the foot (LAMMPS source,
``fix wall/gran/region`` and ``region``; measured).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array, Int64Array
from packgen.bed import Bed
from packgen.errors import SolverError
from packgen.geometry import Ball, Box, Cone, Polyhedron
from packgen.measure import hertz as law
from packgen.validation.contacts import Contacts, law_error

SAME_PLANE = 1.0e-4  # radians, and a tenth of it of the container's size: one wall, but for rounding
BLOCK_SIZE = 1_000_000  # sphere-plane distances held at a time


@dataclass(frozen=True, eq=False, slots=True)
class WallContacts:
    """Where spheres overlap walls.

    Attributes:
        sphere: Index of the sphere, ascending, shape (C,), int64.
        normal: Unit vector into the container, shape (C, 3), float64.
        overlap: Overlap [m], shape (C,), float64.
        curvature: k [1/m], 0 of a flat wall, shape (C,), float64.
    """

    sphere: Int64Array
    normal: Float64Array
    overlap: Float64Array
    curvature: Float64Array


def convex_contacts(bed: Bed, wall_force: Float64Array) -> tuple[Contacts, float]:
    """Return the contacts with walls that a solver's forces tell of, and how far they are off the law.

    Args:
        bed: The bed.
        wall_force: What the walls do to each sphere by the solver [N], shape (N, 3).

    Raises:
        SolverError: The container is not convex.
    """
    weight = law.mean_weight(bed)
    expected = wall_contacts(bed)
    modulus = law.wall_modulus(bed, bed.type_index)[expected.sphere]
    radius = 1 / (1 / bed.radius[expected.sphere] - expected.curvature)
    force = law.hertz_force(modulus, radius, expected.overlap)
    total = np.zeros((bed.count, 3))
    np.add.at(total, expected.sphere, force[:, None] * expected.normal)
    error = law_error(np.linalg.norm(wall_force - total, axis=1), np.linalg.norm(total, axis=1), weight)
    found = _along_normals(expected, wall_force)
    known = Contacts(expected.sphere, None, found, law.hertz_overlap(modulus, radius, found))
    return _with_unexpected(bed, known, wall_force, weight), error


def _along_normals(expected: WallContacts, wall_force: Float64Array) -> Float64Array:
    """Return the size (C,) of each wall's push: the force of a sphere's walls, split along their normals."""
    found = np.zeros(len(expected.sphere))
    spheres, starts = np.unique(expected.sphere, return_index=True)
    ends = np.searchsorted(expected.sphere, spheres, side="right")
    for sphere, start, end in zip(spheres, starts, ends, strict=True):
        part = slice(start, end)
        found[part] = np.linalg.lstsq(expected.normal[part].T, wall_force[sphere], rcond=None)[0]
    return np.abs(found)


def _with_unexpected(bed: Bed, known: Contacts, wall_force: Float64Array, weight: float) -> Contacts:
    """Add spheres that the law knows no wall for, and that the solver pushes all the same."""
    size = np.linalg.norm(wall_force, axis=1)
    size[known.first] = 0
    # A remainder of rounding is no contact.
    extra = np.flatnonzero(~(size <= 1e-9 * weight))
    overlap = law.hertz_overlap(law.wall_modulus(bed, bed.type_index)[extra], bed.radius[extra], size[extra])
    return Contacts(
        np.concatenate((known.first, extra)),
        None,
        np.concatenate((known.force, size[extra])),
        np.concatenate((known.overlap, overlap)),
    )


def wall_contacts(bed: Bed) -> WallContacts:
    """Return where the spheres of a bed whose centres are inside overlap the walls, by geometry.

    Raises:
        SolverError: The container is not convex.
    """
    shape, position = bed.container.shape, bed.position
    if all(bed.container.periodic):
        return _chosen(bed, [])
    if isinstance(shape, Box):
        walled = np.flatnonzero(~np.array(bed.container.periodic))
        normal = np.concatenate((-np.eye(3)[walled], np.eye(3)[walled]))
        return _plane_contacts(bed, normal, np.concatenate((-shape.min[walled], shape.max[walled])))
    if isinstance(shape, Polyhedron):
        return _plane_contacts(bed, *_planes(bed, shape))
    if isinstance(shape, Ball):
        apart = position - shape.center
        distance = np.linalg.norm(apart, axis=1)
        inwards = -apart / np.maximum(distance, np.finfo(float).tiny)[:, None]
        curvature = np.full(bed.count, 1 / shape.radius)
        return _chosen(bed, [(inwards, shape.radius - distance, curvature)])
    if isinstance(shape, Cone):
        return _chosen(bed, _cone_walls(shape, position))
    raise SolverError(
        "the walls are not convex, and their forces cannot be told from the sum; judge by liggghts or yade"
    )


Wall = tuple[Float64Array, Float64Array, Float64Array]
"""Each sphere's direction into the container (N, 3), clearance of its centre [m] (N,), curvature (N,)."""


def _cone_walls(cone: Cone, position: Float64Array) -> list[Wall]:
    relative = position - cone.base
    along = relative @ cone.axis
    across = relative - along[:, None] * cone.axis
    distance = np.linalg.norm(across, axis=1)
    outwards = across / np.maximum(distance, np.finfo(float).tiny)[:, None]
    slope = (cone.radius_top - cone.radius_bottom) / cone.height
    slant = np.hypot(1.0, slope)
    clearance = (cone.radius_bottom + slope * along - distance) / slant
    inwards = (slope * cone.axis - outwards) / slant
    foot_radius = distance + clearance / slant
    axis = np.broadcast_to(cone.axis, position.shape)
    flat = np.zeros(len(position))
    return [
        (inwards, clearance, 1 / (2 * foot_radius)),
        (axis, along, flat),
        (-axis, cone.height - along, flat),
    ]


def _chosen(bed: Bed, walls: list[Wall]) -> WallContacts:
    """Keep overlaps of spheres whose centre is inside every wall."""
    inside = np.ones(bed.count, dtype=bool)
    for _, clearance, _ in walls:
        inside &= clearance > 0
    spheres, normals, overlaps, curvatures = [], [], [], []
    for normal, clearance, curvature in walls:
        touching = np.flatnonzero(inside & (clearance < bed.radius))
        spheres.append(touching)
        normals.append(normal[touching])
        overlaps.append((bed.radius - clearance)[touching])
        curvatures.append(curvature[touching])
    return _sorted(spheres, normals, overlaps, curvatures)


def _plane_contacts(bed: Bed, normal: Float64Array, offset: Float64Array) -> WallContacts:
    """Return contacts with planes whose outward unit normals (P, 3) and offsets (P,) are given."""
    spheres, normals, overlaps, curvatures = [], [], [], []
    step = max(1, BLOCK_SIZE // len(offset))
    size = float(np.ptp(bed.container.bounds, axis=0).max())
    for start in range(0, bed.count, step):
        position, radius = bed.position[start : start + step], bed.radius[start : start + step]
        clearance = offset - position @ normal.T
        sphere, plane = np.nonzero((clearance < radius[:, None]) & (clearance > 0).all(axis=1, keepdims=True))
        foot = position[sphere] + clearance[sphere, plane][:, None] * normal[plane]
        held = np.flatnonzero((foot @ normal.T <= offset + 1e-12 * size).all(axis=1))
        sphere, plane = sphere[held], plane[held]
        spheres.append(sphere + start)
        normals.append(-normal[plane])
        overlaps.append(radius[sphere] - clearance[sphere, plane])
        curvatures.append(np.zeros(len(sphere)))
    return _sorted(spheres, normals, overlaps, curvatures)


def _planes(bed: Bed, shape: Polyhedron) -> tuple[Float64Array, Float64Array]:
    """Return the planes that are walls: those that are the same but for rounding once, no open top."""
    vertices, faces = bed.container.surface.vertices, bed.container.surface.faces
    size = float(np.ptp(vertices, axis=0).max())
    middle = vertices.mean(axis=0)
    distance = shape.offset - shape.normal @ middle
    kept: list[int] = []
    for index in np.argsort(distance, kind="stable").tolist():
        turned = np.linalg.norm(shape.normal[kept] - shape.normal[index], axis=1)
        apart = np.abs(distance[kept] - distance[index]) / size
        same = (turned < SAME_PLANE) & (apart < 0.1 * SAME_PLANE)
        height = vertices @ shape.normal[index] - shape.offset[index]
        on_plane = np.flatnonzero(np.abs(height) < SAME_PLANE * size)
        if not same.any() and np.isin(faces, on_plane).all(axis=1).any():
            kept.append(int(index))
    return shape.normal[kept], shape.offset[kept]


def _sorted(
    spheres: list[Int64Array],
    normals: list[Float64Array],
    overlaps: list[Float64Array],
    curvatures: list[Float64Array],
) -> WallContacts:
    if not spheres:
        return WallContacts(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros(0), np.zeros(0))
    sphere = np.concatenate(spheres)
    order = np.argsort(sphere, kind="stable")
    return WallContacts(
        sphere[order],
        np.concatenate(normals)[order],
        np.concatenate(overlaps)[order],
        np.concatenate(curvatures)[order],
    )
