"""Spheres and bridges as closed surfaces of triangles, whose corners lie on the true surface.

A sphere is an icosphere, subdivided until no facet is deeper under the sphere than the chord error; one that
is cut flat is the convex hull of an icosphere's corners that are left, and of the rims of its flats. Facets
lie inside the true body, so that gaps between bodies are never smaller than those of the bodies.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np

from exporters.resolved.treatment import Bridges, Cuts
from packgen.arrays import Float64Array, Int64Array

SUBDIVISIONS_MAX = 7
FINER_MAX = 2  # subdivisions more than an uncut sphere has
SIDES_MIN = 12
RIM_POINTS_MIN = 12
CLEAR_OF_RIM = 0.35  # edges of the icosphere that its corners keep away from a rim
ON_PLANE = 1.0e-9
PARALLEL = 1.0e-9  # square of the sine of an angle between planes that meet nowhere
SPHERES_PER_CHUNK = 256


@cache
def icosphere(subdivisions: int) -> tuple[Float64Array, Int64Array]:
    """Return corners, shape (V, 3), and triangles, shape (F, 3), of an icosphere of radius 1."""
    import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=1.0)
    corner = np.asarray(mesh.vertices, np.float64)
    return corner / np.linalg.norm(corner, axis=1)[:, None], np.asarray(mesh.faces, np.int64)


@cache
def chord_error(subdivisions: int) -> float:
    """Return how deep the facets of an icosphere lie under the sphere, as a fraction of its radius."""
    corner, faces = icosphere(subdivisions)
    return float((1.0 - _plane_distance(corner[faces])).max())


def subdivisions_for(error: float) -> int:
    """Return how often an icosphere has to be subdivided for a chord error, a fraction of the radius."""
    return next((n for n in range(SUBDIVISIONS_MAX) if chord_error(n) <= error), SUBDIVISIONS_MAX)


def facets_of(error: float) -> int:
    """Return the number of facets of an uncut sphere."""
    return int(20 * 4 ** subdivisions_for(error))


def _plane_distance(triangles: Float64Array) -> Float64Array:
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)
    return np.asarray((normal * triangles[:, 0]).sum(axis=1) / length)


def sphere_triangles(
    position: Float64Array, radius: Float64Array, owner: Int64Array, cuts: Cuts, error: float
) -> Iterator[Float64Array]:
    """Yield the triangles of spheres, shapes (F, 3, 3), some spheres at a time.

    Args:
        position: Centres [m], shape (M, 3).
        radius: Radii [m], shape (M,).
        owner: Index in the bed of each sphere, by which ``cuts`` know it, shape (M,).
        cuts: Planes that cut spheres; owners rise.
        error: Chord error, as a fraction of a radius.
    """
    corner, faces = icosphere(subdivisions_for(error))
    unit = corner[faces]
    first, behind = (np.searchsorted(cuts.owner, owner, side=side) for side in ("left", "right"))
    whole = np.flatnonzero(first == behind)
    for start in range(0, len(whole), SPHERES_PER_CHUNK):
        part = whole[start : start + SPHERES_PER_CHUNK]
        yield (unit * radius[part, None, None, None] + position[part, None, None]).reshape(-1, 3, 3)
    for index in np.flatnonzero(first < behind).tolist():
        own = slice(first[index], behind[index])
        plane = cuts.distance[own] / radius[index]
        yield cut_sphere(cuts.normal[own], plane, error) * radius[index] + position[index]


def cut_sphere(normal: Float64Array, plane: Float64Array, error: float) -> Float64Array:
    """Return the triangles of the unit sphere cut by planes, shape (F, 3, 3), counter-clockwise from outside.

    Args:
        normal: Unit normals of the planes, shape (K, 3).
        plane: Their distances from the centre, between 0 and 1, shape (K,).
        error: Chord error.
    """
    least = subdivisions_for(error)
    for subdivisions in range(least, least + FINER_MAX + 1):
        triangles = _hull(_cut_points(normal, plane, subdivisions))
        distance = _plane_distance(triangles)
        on_flat = np.any(np.all(triangles @ normal.T > plane - ON_PLANE, axis=1), axis=1)
        if (1.0 - distance[~on_flat]).max(initial=0.0) <= error:
            break
    return triangles


def _cut_points(normal: Float64Array, plane: Float64Array, subdivisions: int) -> Float64Array:
    corner, faces = icosphere(subdivisions)
    edge = float(np.linalg.norm(corner[faces[:, 1]] - corner[faces[:, 0]], axis=1).mean())
    angle = np.arccos(plane)
    clear = np.cos(np.minimum(angle + CLEAR_OF_RIM * edge, math.pi))
    points = [corner[(corner @ normal.T <= clear).all(axis=1)]]
    for this in range(len(plane)):
        count = max(RIM_POINTS_MIN, math.ceil(2.0 * math.pi * math.sin(angle[this]) / edge))
        rim = plane[this] * normal[this] + math.sin(angle[this]) * _circle(normal[this], count)
        others = np.arange(len(plane)) != this
        points.append(rim[(rim @ normal[others].T <= plane[others] + ON_PLANE).all(axis=1)])
    return np.concatenate([*points, _corners(normal, plane)])


def _corners(normal: Float64Array, plane: Float64Array) -> Float64Array:
    """Return where rims of flats cross, and where three flats meet inside of the sphere, shape (C, 3)."""
    found: list[Any] = [np.empty((0, 3))]
    for pair in combinations(range(len(plane)), 2):
        across = np.cross(normal[pair[0]], normal[pair[1]])
        square = float(across @ across)
        if square > PARALLEL:
            foot = np.cross(plane[pair[0]] * normal[pair[1]] - plane[pair[1]] * normal[pair[0]], across)
            foot /= square
            rest = (1.0 - foot @ foot) / square
            found += [(foot + side * np.sqrt(rest) * across)[None] for side in (-1.0, 1.0) if rest > 0.0]
    for three in map(list, combinations(range(len(plane)), 3)):
        if abs(float(np.linalg.det(normal[three]))) > PARALLEL:
            place = np.linalg.solve(normal[three], plane[three])
            found += [place[None]] if place @ place < 1.0 else []
    points: Float64Array = np.concatenate(found)
    return points[(points @ normal.T <= plane + ON_PLANE).all(axis=1)]


def _circle(axis: Float64Array, count: int) -> Float64Array:
    """Return points on the unit circle around an axis, shape (count, 3), counter-clockwise."""
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    turn = 2.0 * math.pi * np.arange(count)[:, None] / count
    return np.asarray(np.cos(turn) * first + np.sin(turn) * np.cross(axis, first))


def _hull(points: Float64Array) -> Float64Array:
    from scipy.spatial import ConvexHull

    hull = ConvexHull(points, qhull_options="Qt")
    triangles = points[hull.simplices]
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    turned = (normal * hull.equations[:, :3]).sum(axis=1) < 0.0
    triangles[turned] = triangles[turned][:, ::-1]
    return np.asarray(triangles)


def bridge_triangles(base: Float64Array, bridges: Bridges, error: float) -> Iterator[Float64Array]:
    """Yield the triangles of bridges, closed at their ends.

    Args:
        base: Centre of the sphere that each one begins at [m], shape (B, 3).
        bridges: The bridges.
        error: Chord error, as a fraction of a bridge's radius.
    """
    sides = max(SIDES_MIN, math.ceil(math.pi / math.acos(1.0 - min(error, 0.5))))
    for index in range(len(bridges.owner)):
        axis = bridges.direction[index]
        ring = bridges.radius[index] * _circle(axis, sides)
        low_middle = base[index] + bridges.start[index] * axis
        high_middle = base[index] + bridges.stop[index] * axis
        low, high = low_middle + ring, high_middle + ring
        low_next, high_next = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
        middle = np.broadcast_to(low_middle, low.shape), np.broadcast_to(high_middle, high.shape)
        yield np.concatenate(
            [
                np.stack([low, low_next, high_next], axis=1),
                np.stack([low, high_next, high], axis=1),
                np.stack([middle[0], low_next, low], axis=1),
                np.stack([middle[1], high, high_next], axis=1),
            ]
        )


def enclosed_volume(triangles: Float64Array) -> float:
    """Return the volume that closed surfaces enclose [m3]: signed tetrahedra from their own middle."""
    if not len(triangles):
        return 0.0
    a, b, c = np.moveaxis(triangles - triangles.reshape(-1, 3).mean(axis=0), 1, 0)
    return float((np.cross(a, b) * c).sum() / 6.0)
