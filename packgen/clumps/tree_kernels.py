"""The point of a triangulated surface closest to a point: a tree of boxes, walked nearest first."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.space.feature_kernels import closest_on_triangle
from packgen.compiled import inner_loop, loop

LEAF = 4
"""Triangles in a leaf of the tree."""

STACK = 64
"""Boxes that wait to be looked at: more than twice the depth of any tree that fits into memory."""


@inner_loop
def box_distance(box: NDArray[np.float64], node: int, x: float, y: float, z: float) -> float:
    """Return the squared distance of a point to a box of the tree [m2]; 0 inside."""
    dx = max(box[node, 0] - x, 0.0, x - box[node, 3])
    dy = max(box[node, 1] - y, 0.0, y - box[node, 4])
    dz = max(box[node, 2] - z, 0.0, z - box[node, 5])
    return float(dx * dx + dy * dy + dz * dz)


@inner_loop
def closest_point(
    box: NDArray[np.float64],
    corner: NDArray[np.float64],
    x: float,
    y: float,
    z: float,
    within: float,
    enough: float,
    found: NDArray[np.float64],
) -> float:
    """Find the point of the surface closest to a point, where it is near.

    Args:
        box: Boxes of a complete binary tree, low corner then high corner [m], shape (2 L - 1, 6).
        corner: Corners of the triangles, leaf by leaf [m], shape (L * LEAF, 9).
        x: Point [m].
        y: Point [m].
        z: Point [m].
        within: Only what is nearer than this counts [m].
        enough: Any point nearer than this will do [m]; 0: only the closest one does.
        found: Out: the point [m], shape (3,); as it was where there is none.

    Returns:
        Its distance [m]; ``within`` where there is none.
    """
    inner = (len(box) - 1) // 2
    stack = np.empty(STACK, np.int64)
    bound = np.empty(STACK, np.float64)
    best = within * within
    will_do = enough * enough
    depth = 1
    stack[0], bound[0] = 0, 0.0
    while depth > 0:
        depth -= 1
        node = stack[depth]
        if bound[depth] >= best:
            continue
        if node >= inner:
            first = (node - inner) * LEAF
            for triangle in range(first, first + LEAF):
                px, py, pz = closest_on_triangle(x, y, z, corner[triangle])
                square = (px - x) ** 2 + (py - y) ** 2 + (pz - z) ** 2
                if square < best:
                    best = square
                    found[0], found[1], found[2] = px, py, pz
                    if square < will_do:
                        return float(np.sqrt(square))
            continue
        left = 2 * node + 1
        to_left, to_right = box_distance(box, left, x, y, z), box_distance(box, left + 1, x, y, z)
        near, far = (left, left + 1) if to_left <= to_right else (left + 1, left)
        stack[depth], bound[depth] = far, max(to_left, to_right)
        stack[depth + 1], bound[depth + 1] = near, min(to_left, to_right)
        depth += 2
    return float(np.sqrt(best))


@loop
def distances(
    box: NDArray[np.float64], corner: NDArray[np.float64], point: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the distance of each point (N, 3) to the surface [m], shape (N,), float64."""
    found = np.empty(3)
    result = np.empty(len(point))
    for k in range(len(point)):
        result[k] = closest_point(box, corner, point[k, 0], point[k, 1], point[k, 2], np.inf, 0.0, found)
    return result


@loop
def shrink_balls(
    box: NDArray[np.float64],
    corner: NDArray[np.float64],
    start: NDArray[np.float64],
    inward: NDArray[np.float64],
    largest: float,
    slack: float,
    rounds: int,
) -> NDArray[np.float64]:
    """Return for each point of the surface the largest inscribed ball that touches it there.

    A large ball that touches the point shrinks, touching it still, until nothing of the surface is in it (Ma,
    Bae and Choi, Vis. Comput. 28 (2012) 7).

    Args:
        box: As in `closest_point`.
        corner: As in `closest_point`.
        start: Points of the surface [m], shape (N, 3).
        inward: Unit vectors across the surface there, into the body, shape (N, 3).
        largest: Radius to start with [m].
        slack: How deep the surface may reach into a ball that counts as free of it [m]. Its radius is then
            the distance of its centre.
        rounds: How often a ball shrinks at most.

    Returns:
        Centres and radii [m], shape (N, 4), float64; radius 0: there is no such ball.
    """
    ball = np.zeros((len(start), 4))
    found = np.empty(3)
    for k in range(len(start)):
        radius = largest
        for _ in range(rounds):
            x = start[k, 0] + radius * inward[k, 0]
            y = start[k, 1] + radius * inward[k, 1]
            z = start[k, 2] + radius * inward[k, 2]
            away = closest_point(box, corner, x, y, z, radius, radius - slack, found)
            if away >= radius - slack:
                ball[k, 0], ball[k, 1], ball[k, 2], ball[k, 3] = x, y, z, away
                break
            dx, dy, dz = found[0] - start[k, 0], found[1] - start[k, 1], found[2] - start[k, 2]
            along = dx * inward[k, 0] + dy * inward[k, 1] + dz * inward[k, 2]
            square = dx * dx + dy * dy + dz * dz
            if along <= 0.0 or square <= slack * slack:
                break
            radius = min(square / (2.0 * along), radius * (1.0 - 1e-9))
    return ball
