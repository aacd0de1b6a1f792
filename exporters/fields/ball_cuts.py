"""Volume of a ball beyond one, two or three planes at right angles to each other, in closed form.

By Gauss' theorem the volume of a piece of the unit ball is a third of its area on the sphere less, for each
plane, the plane's coordinate times the area of its face. The area on the sphere follows from the theorem of
Gauss and Bonnet: 2 pi less the exterior angles and the geodesic curvatures along its edges, circles all. On
the plane x = a an edge turns by a times the angle that it spans; the circles on x = a and y = b meet at the
exterior angle atan2(h, -a b), where h is the height sqrt(1 - a^2 - b^2) at which they meet.

All is of the unit ball around the origin. Coordinates of planes are -1 to 1; arrays are float64 of one shape.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float64Array = NDArray[np.float64]

BALL = 4 / 3 * np.pi


def cap(a: Float64Array) -> Float64Array:
    """Return the volume where x > a."""
    volume: Float64Array = np.pi / 3 * (1 - a) ** 2 * (2 + a)
    return volume


def wedge(a: Float64Array, b: Float64Array) -> Float64Array:
    """Return the volume where x > a and y > b."""
    # Planes that meet outside the ball cut off caps.
    beyond_a, beyond_b = cap(a), cap(b)
    volume = np.select(
        [(a >= 0) & (b >= 0), a >= 0, b >= 0],
        [np.zeros_like(a), beyond_a, beyond_b],
        beyond_a + beyond_b - BALL,
    )
    meet = np.flatnonzero(a * a + b * b < 1)
    a, b = a.flat[meet], b.flat[meet]
    h = np.sqrt(1 - a * a - b * b)
    half_a, half_b = np.arctan2(h, b), np.arctan2(h, a)  # of the angles that the edges span
    on_sphere = 2 * (np.pi - np.arctan2(h, -a * b) - a * half_a - b * half_b)
    face_a = (1 - a * a) * half_a - b * h
    face_b = (1 - b * b) * half_b - a * h
    volume.flat[meet] = (on_sphere - a * face_a - b * face_b) / 3
    return volume


def corner(a: Float64Array, b: Float64Array, c: Float64Array) -> Float64Array:
    """Return the volume where x > a, y > b and z > c."""
    # A corner outside the ball leaves nothing where all three are positive; a negative one is the complement.
    volume = np.where(a < 0, wedge(np.abs(b), np.abs(c)), 0.0)
    volume = np.where(b < 0, wedge(a, np.abs(c)) - volume, volume)
    volume = np.where(c < 0, wedge(a, b) - volume, volume)
    inside = np.flatnonzero(a * a + b * b + c * c < 1)
    volume.flat[inside] = _corner_inside(a.flat[inside], b.flat[inside], c.flat[inside])
    return volume


def _corner_inside(a: Float64Array, b: Float64Array, c: Float64Array) -> Float64Array:
    on_sphere, faces = np.full_like(a, 2 * np.pi), np.zeros_like(a)
    for this, second, third in ((a, b, c), (b, c, a), (c, a, b)):
        # The edge on this plane goes from the plane of the third to that of the second coordinate.
        h_second = np.sqrt(1 - this * this - second * second)
        h_third = np.sqrt(1 - this * this - third * third)
        span = np.arctan2(h_second, second) - np.arctan2(third, h_third)
        on_sphere -= np.arctan2(h_second, -this * second) + this * span
        face = (1 - this * this) * span - second * (h_second - third) - third * (h_third - second)
        faces += this * face / 2
    volume: Float64Array = (on_sphere - faces) / 3
    return volume


def below(u: Float64Array, v: Float64Array, w: Float64Array) -> Float64Array:
    """Return the volumes of balls below each crossing of planes x = u, y = v, z = w.

    Args:
        u: Planes across x that cut each ball, ascending, shape (M, I).
        v: Planes across y, shape (M, J).
        w: Planes across z, shape (M, K).

    Returns:
        Volumes, shape (M, I + 2, J + 2, K + 2): the first entry along an axis is of a plane below the ball,
        the last one of a plane above it. Differences along the axes are the volumes between the planes.
    """
    count = len(u)
    # The volume below planes is that above their mirror images.
    x, y, z = -u[:, :, None, None], -v[:, None, :, None], -w[:, None, None, :]
    volume = np.zeros((count, u.shape[1] + 2, v.shape[1] + 2, w.shape[1] + 2))
    volume[:, -1, -1, -1] = BALL
    inner = slice(1, -1)
    volume[:, inner, -1, -1] = cap(-u)
    volume[:, -1, inner, -1] = cap(-v)
    volume[:, -1, -1, inner] = cap(-w)
    volume[:, inner, inner, -1] = wedge(*np.broadcast_arrays(x, y))[..., 0]
    volume[:, inner, -1, inner] = wedge(*np.broadcast_arrays(x, z))[:, :, 0]
    volume[:, -1, inner, inner] = wedge(*np.broadcast_arrays(y, z))[:, 0]
    volume[:, inner, inner, inner] = corner(*np.broadcast_arrays(x, y, z))
    return volume
