"""Closed meshes of the solid shapes: rod, cylinder, ellipsoid, cube with rounded edges."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array, Int64Array, unique_rows
from packgen.geometry import Surface

LATITUDES, LONGITUDES = 48, 96
ROUND = 12  # cells along a rounded edge


def ellipsoid_surface(lengths: tuple[float, float, float]) -> Surface:
    """Return an ellipsoid with its full axes along x, y, z [m]; its volume is the exact one."""
    angle = np.linspace(0.0, np.pi, LATITUDES + 1)
    profile = np.column_stack([np.sin(angle), -np.cos(angle)])
    profile[[0, -1], 0] = 0.0
    ball = _revolved(profile)
    surface = Surface(ball.vertices * np.array(lengths) / 2.0, ball.faces)
    return _with_volume(surface, np.pi / 6.0 * float(np.prod(lengths)))


def rod_surface(radius: float, length: float) -> Surface:
    """Return a cylinder with round ends along x, its middle at the origin [m], with the exact volume."""
    angle = np.linspace(0.0, np.pi / 2.0, LATITUDES // 2 + 1)
    cap = radius * np.column_stack([np.sin(angle), np.cos(angle)])
    cap[0, 0] = 0.0
    cap[:, 1] += length / 2.0 - radius
    turned = _revolved(np.concatenate([cap * [1.0, -1.0], cap[::-1]]))
    middle = length - 2.0 * radius
    volume = np.pi * radius**2 * middle + 4.0 / 3.0 * np.pi * radius**3
    return _with_volume(Surface(np.roll(turned.vertices, 1, axis=1), turned.faces), volume)


def cylinder_surface(radius: float, height: float) -> Surface:
    """Return a cylinder about z, its middle at the origin [m], with the exact volume."""
    half = height / 2.0
    turned = _revolved(np.array([[0.0, -half], [radius, -half], [radius, half], [0.0, half]]))
    # A polygon of the circle's area.
    factor = np.sqrt(2.0 * np.pi / LONGITUDES / np.sin(2.0 * np.pi / LONGITUDES))
    return Surface(turned.vertices * np.array([factor, factor, 1.0]), turned.faces)


def rounded_cube_surface(side: float, edge: float) -> Surface:
    """Return a cube with edges rounded by a radius, its middle at the origin [m], with the exact volume."""
    inner = side / 2.0 - edge
    bow = edge * np.tan(np.linspace(0.0, np.pi / 4.0, ROUND // 2 + 1))
    line = np.concatenate([-inner - bow[::-1], [inner] if inner > 0.0 else [], inner + bow[1:]])
    u, v = np.meshgrid(line, line, indexing="ij")
    flat = np.stack([u.ravel(), v.ravel(), np.full(u.size, side / 2.0)], axis=1)
    count = len(line)
    first = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    quads = np.stack([first, first + count, first + count + 1, first + 1], axis=1)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    points: list[Float64Array] = []
    triangles: list[Int64Array] = []
    for axis in range(3):
        for sign in (1.0, -1.0):
            side_points = np.roll(flat, axis + 1, axis=1) * (1.0 if sign > 0.0 else -1.0)
            triangles.append((faces if sign > 0.0 else faces[:, ::-1]) + len(points) * len(flat))
            points.append(side_points)
    point = np.concatenate(points)
    core = np.clip(point, -inner, inner)
    away = point - core
    length = np.linalg.norm(away, axis=1, keepdims=True)
    rounded = core + edge * away / np.where(length > 0.0, length, 1.0)
    first_of, kind = unique_rows(np.round(rounded / side * 1e9))
    surface = Surface(rounded[first_of], kind[np.concatenate(triangles)])
    a, r = 2.0 * inner, edge
    volume = a**3 + 6.0 * a * a * r + 3.0 * np.pi * a * r * r + 4.0 / 3.0 * np.pi * r**3
    return _with_volume(surface, volume)


def _revolved(profile: Float64Array) -> Surface:
    """Return a closed surface about z; the profile (K, 2) has radius and height, 0 radius at both ends."""
    angle = 2.0 * np.pi * np.arange(LONGITUDES) / LONGITUDES
    rings = profile[1:-1]
    ring = np.stack(
        [
            rings[:, :1] * np.cos(angle),
            rings[:, :1] * np.sin(angle),
            np.broadcast_to(rings[:, 1:], (len(rings), LONGITUDES)),
        ],
        axis=2,
    )
    tips = np.array([[0.0, 0.0, profile[0, 1]], [0.0, 0.0, profile[-1, 1]]])
    vertices = np.concatenate([ring.reshape(-1, 3), tips])
    here = np.arange(LONGITUDES)
    after = np.roll(here, -1)
    bottom, top = len(vertices) - 2, len(vertices) - 1
    faces = [np.stack([np.full(LONGITUDES, bottom), after, here], axis=1)]
    for level in range(len(rings) - 1):
        low, high = level * LONGITUDES, (level + 1) * LONGITUDES
        faces.append(np.stack([low + here, low + after, high + after], axis=1))
        faces.append(np.stack([low + here, high + after, high + here], axis=1))
    last = (len(rings) - 1) * LONGITUDES
    faces.append(np.stack([np.full(LONGITUDES, top), last + here, last + after], axis=1))
    return Surface(vertices, np.concatenate(faces))


def _with_volume(surface: Surface, volume: float) -> Surface:
    """Return a surface about the origin, scaled to bound a volume [m3]: facets cut off what is curved."""
    corners = surface.vertices[surface.faces]
    found = float(np.einsum("fi,fi->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6.0
    return Surface(surface.vertices * np.cbrt(volume / found), surface.faces)
