"""The bodies of a layer, and the lists of what is near their spheres, as the compiled loops take them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.neighbors.list_kernels import Pairs
from packgen.arrange.neighbors.seam_pairs import SeamPairs
from packgen.arrange.space.map_kernels import WallList
from packgen.arrange.space.walls import no_walls


class RigidState(NamedTuple):
    """B bodies that move, their N spheres, and F fixed spheres.

    Attributes:
        centre: Centres of mass [m], shape (B, 3), float64.
        turn: Unit quaternions w, x, y, z, shape (B, 4), float64.
        motion: How far each came [m] and turned [rad] in the last sweep, shape (B + 1, 6), float64; 0 of the
            last row, which stands for all that stays.
        slackness: Inverse of the tensor of inertia in the template's frame, xx yy zz xy xz yz [1 / m2], a
            sphere of radius `reference` having mass 1, shape (B, 6), float64.
        slack: The same in the bed's axes, and one over the mass; 0 of what stays, shape (B + 1, 7), float64.
        size: Radius of the sphere of each body's volume [m], shape (B,), float64.
        extent: Radius of the sphere about the centre of mass that holds the body [m], shape (B,), float64.
        first: First sphere of each body, and the end of all, shape (B + 1,), int64.
        local: Centres of the spheres in the template's frame [m], shape (N, 3), float64.
        owner: Body of each sphere, shape (N + F,), int64; B of a fixed one.
        ball: Centres and arranged radii of all spheres, those that move first [m], shape (N + F, 4), float64.
        arm: From the centre of its body to each sphere [m], shape (N + F, 3), float64; 0 of a fixed one.
        reference: Mean radius of the spheres of the bodies' volumes [m].
    """

    centre: NDArray[np.float64]
    turn: NDArray[np.float64]
    motion: NDArray[np.float64]
    slackness: NDArray[np.float64]
    slack: NDArray[np.float64]
    size: NDArray[np.float64]
    extent: NDArray[np.float64]
    first: NDArray[np.int64]
    local: NDArray[np.float64]
    owner: NDArray[np.int64]
    ball: NDArray[np.float64]
    arm: NDArray[np.float64]
    reference: float

    @property
    def moving(self) -> int:
        """Number of spheres that move."""
        return len(self.local)


class RigidLists(NamedTuple):
    """What is near the spheres that move until one of them has moved too far.

    Attributes:
        pairs: Pairs of spheres of two bodies that are close.
        rows: Where the pairs of each owner begin; see ``rows_of``.
        seam: Pairs that are close across a seam.
        near: The walls that each sphere can reach.
        anchor: Centres and arranged radii of the spheres when the lists were made [m], shape (N, 4), float64.
        margin: The lists hold while no sphere has moved further than this [m], shape (N,), float64.
        room: Work space for the neighbour list, int32.
    """

    pairs: Pairs
    rows: NDArray[np.int32]
    seam: SeamPairs
    near: WallList
    anchor: NDArray[np.float64]
    margin: NDArray[np.float64]
    room: NDArray[np.int32]


class Pace(NamedTuple):
    """What a sweep takes; see ``projection.recipe.Schedule``.

    Attributes:
        fall: Step down [m].
        momentum: Share of the last motion that is added again.
        stride: Largest motion of a body's surface by pushes, in its size.
        friction: Coefficient of friction.
    """

    fall: float
    momentum: float
    stride: float
    friction: float


def no_lists() -> RigidLists:
    """Return empty lists."""
    none = np.empty(0, np.int32)
    return RigidLists(
        Pairs(none, none),
        none,
        SeamPairs(none, none, np.empty((0, 3))),
        no_walls(),
        np.empty((0, 4)),
        np.empty(0),
        none,
    )
