"""The nearest of many balls of any sizes, more of them coming: a loose octree.

A ball lies in the cell that has its centre, of the level whose cells are as wide as the ball, or up to twice
that: it sticks out by half a cell at most.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from packgen.compiled import inner_loop, loop

LEVELS = 40
"""Levels of the tree: radii down to 1e-12 of the space."""

STACK = 8 * LEVELS

LAST = 7
"""The last octant."""


class BallTree(NamedTuple):
    """Balls in a loose octree.

    Attributes:
        ball: Centres and radii [m], shape (room, 4).
        following: Next ball of the same cell, -1: none, shape (room,).
        child: Children of each cell, 0: none, shape (cells, 8).
        first: First ball of each cell, -1: none, shape (cells,).
        cube: Middle and half width of the whole [m], shape (4,).
        size: Number of balls and of cells, shape (2,).
    """

    ball: NDArray[np.float64]
    following: NDArray[np.int64]
    child: NDArray[np.int64]
    first: NDArray[np.int64]
    cube: NDArray[np.float64]
    size: NDArray[np.int64]


@inner_loop
def add_ball(tree: BallTree, x: float, y: float, z: float, radius: float) -> None:
    """Add a ball; there must be room for it and for `LEVELS` cells more."""
    number = tree.size[0]
    tree.size[0] += 1
    tree.ball[number, 0], tree.ball[number, 1], tree.ball[number, 2] = x, y, z
    tree.ball[number, 3] = radius
    mx, my, mz, half = tree.cube[0], tree.cube[1], tree.cube[2], tree.cube[3]
    node = 0
    for _ in range(LEVELS - 1):
        if half < 2.0 * radius:
            break
        half *= 0.5
        octant = (1 if x >= mx else 0) + (2 if y >= my else 0) + (4 if z >= mz else 0)
        mx += half if x >= mx else -half
        my += half if y >= my else -half
        mz += half if z >= mz else -half
        if tree.child[node, octant] == 0:
            fresh = tree.size[1]
            tree.size[1] += 1
            tree.first[fresh] = -1
            tree.child[fresh, :] = 0
            tree.child[node, octant] = fresh
        node = tree.child[node, octant]
    tree.following[number] = tree.first[node]
    tree.first[node] = number


@loop
def add_balls(tree: BallTree, ball: NDArray[np.float64]) -> None:
    """Add balls (N, 4), as `add_ball` does."""
    for k in range(len(ball)):
        add_ball(tree, ball[k, 0], ball[k, 1], ball[k, 2], ball[k, 3])


@inner_loop
def octants_below(
    tree: BallTree,
    node: int,
    own: int,
    x: float,
    y: float,
    z: float,
    half: float,
    stack: NDArray[np.int64],
    middle: NDArray[np.float64],
    depth: int,
) -> int:
    """Put the cells below one on a stack, the octant ``own`` of its last, which is looked at first.

    Args:
        tree: The cells.
        node: The cell.
        own: The octant.
        x: Middle of the cell [m].
        y: Middle of the cell [m].
        z: Middle of the cell [m].
        half: Half its width [m].
        stack: Cells to be looked at, shape (STACK,); changes.
        middle: Their middles and half widths [m], shape (STACK, 4); changes.
        depth: How many there are.

    Returns:
        How many there are now.
    """
    half *= 0.5
    for k in range(7, -1, -1):
        octant = own ^ k
        below = tree.child[node, octant]
        if below != 0:
            stack[depth] = below
            middle[depth, 0] = x + (half if octant & 1 else -half)
            middle[depth, 1] = y + (half if octant & 2 else -half)
            middle[depth, 2] = z + (half if octant & 4 else -half)
            middle[depth, 3] = half
            depth += 1
    return depth


@inner_loop
def nearest_ball(  # type: ignore[no-untyped-def]
    tree: BallTree, x: float, y: float, z: float, within: float
):
    """Return (number of the ball whose surface is nearest to a point, how far [m], negative inside).

    Number -1: none is nearer than ``within``, which is returned then.
    """
    number, best = -1, within
    if tree.size[0] == 0:
        return number, best
    stack = np.empty(STACK, np.int64)
    middle = np.empty((STACK, 4))
    stack[0] = 0
    middle[0, 0], middle[0, 1], middle[0, 2], middle[0, 3] = (
        tree.cube[0], tree.cube[1], tree.cube[2], tree.cube[3],
    )  # fmt: skip
    depth = 1
    while depth > 0:
        depth -= 1
        node = stack[depth]
        mx, my, mz, half = middle[depth, 0], middle[depth, 1], middle[depth, 2], middle[depth, 3]
        # Balls stick out of their cell by half of its width, and what is in it may be anywhere.
        reach = best + 2.0 * half
        if abs(x - mx) >= reach or abs(y - my) >= reach or abs(z - mz) >= reach:
            continue
        at = tree.first[node]
        while at >= 0:
            dx, dy, dz = x - tree.ball[at, 0], y - tree.ball[at, 1], z - tree.ball[at, 2]
            limit = best + tree.ball[at, 3]
            square = dx * dx + dy * dy + dz * dz
            if limit > 0.0 and square < limit * limit:
                best = np.sqrt(square) - tree.ball[at, 3]
                number = at
            at = tree.following[at]
        own = (1 if x >= mx else 0) + (2 if y >= my else 0) + (4 if z >= mz else 0)
        depth = octants_below(tree, node, own, mx, my, mz, half, stack, middle, depth)
    return number, best
