"""Points of triangles that are nearest to other points."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array, Int64Array

LINE = 1.0e-20  # square of the sine of an angle below which a triangle is a line
PAIRS_PER_CHUNK = 2_000_000


def nearest_on_triangle(point: Float64Array, corners: Float64Array) -> Float64Array:
    """Return the point of each triangle that is nearest to each point, shape (K, 3).

    The foot of the perpendicular where it is inside, else the nearest point of the three edges.

    Args:
        point: Points [m], shape (K, 3).
        corners: A triangle a point [m], shape (K, 3, 3).
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normal = np.cross(b - a, c - a)
    square = (normal**2).sum(axis=1)
    inside = square > LINE * ((b - a) ** 2).sum(axis=1) * ((c - a) ** 2).sum(axis=1)
    height = ((point - a) * normal).sum(axis=1) / np.where(inside, square, 1.0)
    foot = point - height[:, None] * normal
    best, least = np.array(foot), np.full(len(point), np.inf)
    for start, end in ((a, b), (b, c), (c, a)):
        edge = end - start
        inside &= (np.cross(edge, foot - start) * normal).sum(axis=1) >= 0.0
        length = np.maximum((edge**2).sum(axis=1), np.finfo(float).tiny)
        share = np.clip(((point - start) * edge).sum(axis=1) / length, 0.0, 1.0)
        place = start + share[:, None] * edge
        away = ((point - place) ** 2).sum(axis=1)
        nearer = away < least
        best[nearer], least[nearer] = place[nearer], away[nearer]
    best[inside] = foot[inside]
    return best


def triangles_within(
    point: Float64Array, reach: Float64Array, corners: Float64Array
) -> tuple[Int64Array, Float64Array]:
    """Return which points have a triangle within reach, and the triangle's nearest point; a row a pair.

    Args:
        point: Points [m], shape (N, 3).
        reach: How far each one reaches [m], shape (N,).
        corners: Triangles [m], shape (F, 3, 3).

    Returns:
        Index of the point, shape (K,), rising; nearest point of the triangle [m], shape (K, 3).
    """
    low, high = corners.min(axis=1), corners.max(axis=1)
    step = max(1, PAIRS_PER_CHUNK // max(1, len(corners)))
    owners, places = [np.empty(0, np.int64)], [np.empty((0, 3))]
    for start in range(0, len(point), step):
        here, far = point[start : start + step], reach[start : start + step]
        beside = np.ones((len(here), len(corners)), dtype=bool)
        for axis in range(3):
            beside &= here[:, axis, None] - far[:, None] <= high[None, :, axis]
            beside &= here[:, axis, None] + far[:, None] >= low[None, :, axis]
        row, triangle = np.nonzero(beside)
        place = nearest_on_triangle(here[row], corners[triangle])
        near = np.linalg.norm(place - here[row], axis=1) <= far[row]
        owners.append(row[near] + start)
        places.append(place[near])
    return np.concatenate(owners), np.concatenate(places)


def distance_to_triangles(point: Float64Array, corners: Float64Array) -> Float64Array:
    """Return the distance of each point (N, 3) from the nearest of triangles (F, 3, 3) [m], shape (N,)."""
    distance = np.empty(len(point))
    for index, here in enumerate(point):
        place = nearest_on_triangle(np.broadcast_to(here, (len(corners), 3)), corners)
        distance[index] = np.linalg.norm(place - here, axis=1).min()
    return distance
