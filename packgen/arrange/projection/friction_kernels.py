"""Friction between spheres in a sweep: contacts resist sliding, spheres that slide begin to roll.

Coulomb's law in position-based dynamics (Mueller et al., J. Vis. Commun. Image R. 18 (2007) 109; friction by
Macklin et al., ACM Trans. Graph. 33 (2014) 153): the push along the normal stands for the normal force, and
what is taken from the sliding of a contact is at most the friction times that push. Here a sphere turns, too:
a tangential impulse p on a sphere of mass m moves it by p / m, and its surface by 5/2 p / m more, since its
moment of inertia is 2/5 m r^2.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.seam_pairs import SeamPairs
from packgen.compiled import inlined, inner_loop

TURN = 2.5
"""Displacement of a sphere's surface by turning, over that of its centre, by one tangential impulse."""


class Rubbing(NamedTuple):
    """How spheres slide and turn in a sweep.

    Attributes:
        travel: How far each has come in this sweep before it is pushed [m], shape (N, 3); 0 of a fixed one.
        spin: How far each turned in the last sweep [rad], shape (N, 3); 0 of a fixed one.
        turned: Sum of the turns of each in this sweep [rad], shape (N, 3); grows.
        momentum: Share of the last turn by which each turns on.
        friction: Coefficient of friction.
        grip: Largest share of the sliding of a contact that is taken from it.
    """

    travel: NDArray[np.float64]
    spin: NDArray[np.float64]
    turned: NDArray[np.float64]
    momentum: float
    friction: float
    grip: float


@inlined
def rub(
    i: int | np.uint64,
    j: int | np.uint64,
    dx: float,
    dy: float,
    dz: float,
    ball: NDArray[np.float64],
    weight: NDArray[np.float64],
    rubbing: Rubbing,
    shift: NDArray[np.float64],
) -> None:
    """Take from the sliding of one overlapping pair what its friction holds.

    Args:
        i: One sphere.
        j: The other one.
        dx: From the other one, or its image, to the one [m].
        dy: The same.
        dz: The same.
        ball: Centres and radii [m], shape (N, 4).
        weight: Weight of each sphere in a push; see ``push_weights``; shape (N,).
        rubbing: How they slide and turn; ``turned`` grows.
        shift: Sum of the pushes on each sphere [m], shape (N, 3); grows.
    """
    travel, spin, turned, momentum, friction, grip = rubbing
    one, other = ball[i, 3], ball[j, 3]
    distance = math.sqrt(dx * dx + dy * dy + dz * dz)
    if distance < 1e-9 * (one + other):
        return
    nx, ny, nz = dx / distance, dy / distance, dz / distance
    # How the surfaces turn past each other: (r_i spin_i + r_j spin_j) x normal, to be taken off.
    sx = momentum * (one * spin[i, 0] + other * spin[j, 0])
    sy = momentum * (one * spin[i, 1] + other * spin[j, 1])
    sz = momentum * (one * spin[i, 2] + other * spin[j, 2])
    vx = travel[i, 0] - travel[j, 0] - (sy * nz - sz * ny)
    vy = travel[i, 1] - travel[j, 1] - (sz * nx - sx * nz)
    vz = travel[i, 2] - travel[j, 2] - (sx * ny - sy * nx)
    along = vx * nx + vy * ny + vz * nz
    vx -= along * nx
    vy -= along * ny
    vz -= along * nz
    sliding = math.sqrt(vx * vx + vy * vy + vz * vz)
    if sliding < 1e-14 * (one + other):
        return
    held = min(grip, friction * (one + other - distance) / sliding) / (weight[i] + weight[j])
    tx, ty, tz = held * vx, held * vy, held * vz
    shift[i, 0] -= weight[i] * tx
    shift[i, 1] -= weight[i] * ty
    shift[i, 2] -= weight[i] * tz
    shift[j, 0] += weight[j] * tx
    shift[j, 1] += weight[j] * ty
    shift[j, 2] += weight[j] * tz
    cx, cy, cz = ny * tz - nz * ty, nz * tx - nx * tz, nx * ty - ny * tx
    own, back = TURN * weight[i] / one, TURN * weight[j] / other
    turned[i, 0] += own * cx
    turned[i, 1] += own * cy
    turned[i, 2] += own * cz
    turned[j, 0] += back * cx
    turned[j, 1] += back * cy
    turned[j, 2] += back * cz


@inner_loop
def rub_pairs(
    ball: NDArray[np.float64],
    weight: NDArray[np.float64],
    rubbing: Rubbing,
    one: NDArray[np.int32],
    other: NDArray[np.int32],
    seam: SeamPairs,
    shift: NDArray[np.float64],
) -> None:
    """Add the friction of overlapping pairs, seams included, to their pushes; see ``rub``.

    Args:
        ball: Centres and radii [m], shape (N, 4).
        weight: Weight of each sphere in a push, shape (N,).
        rubbing: How they slide and turn; ``turned`` grows.
        one: One sphere of each pair that overlaps, shape (T,).
        other: The other one, shape (T,).
        seam: The pairs that are close across a seam.
        shift: Sum of the pushes on each sphere [m], shape (N, 3); grows.
    """
    for k in range(len(one)):
        i, j = np.uint64(one[k]), np.uint64(other[k])
        dx = ball[i, 0] - ball[j, 0]
        dy = ball[i, 1] - ball[j, 1]
        dz = ball[i, 2] - ball[j, 2]
        rub(i, j, dx, dy, dz, ball, weight, rubbing, shift)
    first, second, offset = seam
    for k in range(len(first)):
        i, j = np.uint64(first[k]), np.uint64(second[k])
        dx = ball[i, 0] - (ball[j, 0] + offset[k, 0])
        dy = ball[i, 1] - (ball[j, 1] + offset[k, 1])
        dz = ball[i, 2] - (ball[j, 2] + offset[k, 2])
        reach = ball[i, 3] + ball[j, 3]
        if dx * dx + dy * dy + dz * dz < reach * reach:  # also skips removed spheres (NaN)
            rub(i, j, dx, dy, dz, ball, weight, rubbing, shift)
