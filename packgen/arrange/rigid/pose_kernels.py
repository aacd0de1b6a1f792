"""Where the spheres of bodies are, by the bodies' places and quaternions; how bodies turn."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.rigid.state import RigidState
from packgen.compiled import inlined, inner_loop, loop


@inlined
def turned_vector(turn: NDArray[np.float64], b: int, u: tuple[float, float, float]):  # type: ignore[no-untyped-def]
    """Return a vector turned by a unit quaternion, row b of w v: u + 2 w (v x u) + 2 v x (v x u)."""
    w, x, y, z = turn[b, 0], turn[b, 1], turn[b, 2], turn[b, 3]
    cx, cy, cz = y * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - y * u[0]
    return (
        u[0] + 2.0 * (w * cx + (y * cz - z * cy)),
        u[1] + 2.0 * (w * cy + (z * cx - x * cz)),
        u[2] + 2.0 * (w * cz + (x * cy - y * cx)),
    )


@loop
def place_members(state: RigidState) -> None:
    """Write the centres of the spheres that move, and their arms, by the places of their bodies."""
    first, local, ball, arm = state.first, state.local, state.ball, state.arm
    centre, turn = state.centre, state.turn
    for b in range(len(first) - 1):
        for i in range(first[b], first[b + 1]):
            ax, ay, az = turned_vector(turn, b, (local[i, 0], local[i, 1], local[i, 2]))
            arm[i, 0], arm[i, 1], arm[i, 2] = ax, ay, az
            ball[i, 0], ball[i, 1], ball[i, 2] = centre[b, 0] + ax, centre[b, 1] + ay, centre[b, 2] + az


@inlined
def turn_by(turn: NDArray[np.float64], b: int, by: tuple[float, float, float]) -> None:
    """Turn a body by a small vector [rad].

    The quaternion 1 + t / 2, normalised, turns by 2 atan(|t| / 2): for small steps the angle itself, without
    sines that libraries round differently.
    """
    w, x, y, z = turn[b, 0], turn[b, 1], turn[b, 2], turn[b, 3]
    hx, hy, hz = 0.5 * by[0], 0.5 * by[1], 0.5 * by[2]
    nw = w - (hx * x + hy * y + hz * z)
    nx = x + hx * w + (hy * z - hz * y)
    ny = y + hy * w + (hz * x - hx * z)
    nz = z + hz * w + (hx * y - hy * x)
    inverse = 1.0 / math.sqrt(nw * nw + nx * nx + ny * ny + nz * nz)
    turn[b, 0], turn[b, 1], turn[b, 2], turn[b, 3] = nw * inverse, nx * inverse, ny * inverse, nz * inverse


@inner_loop
def turned_tensors(turn: NDArray[np.float64], tensor: NDArray[np.float64], out: NDArray[np.float64]) -> None:
    """Write symmetric tensors of bodies' frames, turned with the bodies: R T R^T.

    Args:
        turn: Unit quaternions w, x, y, z, shape (B, 4).
        tensor: xx yy zz xy xz yz in the bodies' frames, shape (B, 6).
        out: Out: the same in the bed's axes, shape (B, 6).
    """
    r, half = np.empty((3, 3)), np.empty((3, 3))
    for b in range(len(turn)):
        for axis in range(3):
            unit = (1.0 * (axis == 0), 1.0 * (axis == 1), 1.0 * (axis == 2))
            r[0, axis], r[1, axis], r[2, axis] = turned_vector(turn, b, unit)
        xx, yy, zz = tensor[b, 0], tensor[b, 1], tensor[b, 2]
        xy, xz, yz = tensor[b, 3], tensor[b, 4], tensor[b, 5]
        for i in range(3):
            half[i, 0] = r[i, 0] * xx + r[i, 1] * xy + r[i, 2] * xz
            half[i, 1] = r[i, 0] * xy + r[i, 1] * yy + r[i, 2] * yz
            half[i, 2] = r[i, 0] * xz + r[i, 1] * yz + r[i, 2] * zz
        for place, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
            out[b, place] = half[i, 0] * r[j, 0] + half[i, 1] * r[j, 1] + half[i, 2] * r[j, 2]
