"""Where a sphere touches three surfaces at once: Newton's method on their gaps, to rounding."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.space.feature_kernels import CONE, TRIANGLE, Features, out_of_reach, wall_gap
from packgen.arrange.space.map_kernels import FeatureMap, candidate, cell_of, count_boundless
from packgen.compiled import inlined, inner_loop

SPHERE, FLAT, HOLLOW, FEATURE = 0, 1, 2, 3
"""Kinds of surfaces: a sphere; a plane; a sphere around; and any feature of a wall, by its number."""

STEPS_MAX = 25

SUBSTITUTIONS_MAX = 6
"""Times that another facet takes the place of the one that was touched: fine walls have many."""

SINGULAR = 1.0e-9
"""Determinant of three unit vectors below which they count as lying in a plane."""


@inlined
def surface_gap(  # type: ignore[no-untyped-def]
    kind: int,
    surface: NDArray[np.float64],
    x: NDArray[np.float64],
    base: NDArray[np.float64],
    radius: float,
    features: Features,
):
    """Return the gap of a sphere to a surface [m] and the direction in which it grows, a unit vector.

    Args:
        kind: SPHERE (centre, least distance), FLAT (outward normal, offset), HOLLOW (centre, largest
            distance) or FEATURE (its number); lengths [m], from ``base``.
        surface: The surface, shape (4,).
        x: The sphere's centre from ``base`` [m], shape (3,).
        base: Where coordinates begin [m], shape (3,) or longer.
        radius: The sphere's radius [m].
        features: The features of the walls.
    """
    if kind == FEATURE:
        f = int(surface[0])
        return wall_gap(
            features.kind[f], features.row[f], base[0] + x[0], base[1] + x[1], base[2] + x[2], radius
        )
    if kind == FLAT:
        gap = surface[3] - (surface[0] * x[0] + surface[1] * x[1] + surface[2] * x[2])
        return gap, -surface[0], -surface[1], -surface[2]
    dx, dy, dz = x[0] - surface[0], x[1] - surface[1], x[2] - surface[2]
    off = math.sqrt(dx * dx + dy * dy + dz * dz)
    inverse = 1.0 / max(off, 1e-300)
    if kind == SPHERE:
        return off - surface[3], dx * inverse, dy * inverse, dz * inverse
    return surface[3] - off, -dx * inverse, -dy * inverse, -dz * inverse


@inner_loop
def polished(
    x: NDArray[np.float64],
    kind: NDArray[np.int64],
    surface: NDArray[np.float64],
    push: NDArray[np.float64],
    base: NDArray[np.float64],
    radius: float,
    features: Features,
    slack: float,
) -> bool:
    """Move a sphere until it touches three surfaces; tell whether it does.

    Args:
        x: Its centre from ``base`` [m], shape (3,); changes.
        kind: Kinds of the surfaces, shape (3,); see ``surface_gap``.
        surface: The surfaces, shape (3, 4).
        push: Out: unit vectors from the surfaces to the sphere, shape (3, 3).
        base: Where coordinates begin [m], shape (3,) or longer.
        radius: Its radius [m].
        features: The features of the walls.
        slack: Largest gap that counts as none [m].
    """
    gap = np.empty(3)
    last = np.inf
    for _ in range(STEPS_MAX):
        worst = 0.0
        for k in range(3):
            gap[k], push[k, 0], push[k, 1], push[k, 2] = surface_gap(
                kind[k], surface[k], x, base, radius, features
            )
            worst = max(worst, abs(gap[k]))
        if worst <= slack and worst >= 0.5 * last:
            return True
        if not (worst < 1e3 * radius):
            return False
        last = worst
        ax = push[1, 1] * push[2, 2] - push[1, 2] * push[2, 1]
        ay = push[1, 2] * push[2, 0] - push[1, 0] * push[2, 2]
        az = push[1, 0] * push[2, 1] - push[1, 1] * push[2, 0]
        bx = push[2, 1] * push[0, 2] - push[2, 2] * push[0, 1]
        by = push[2, 2] * push[0, 0] - push[2, 0] * push[0, 2]
        bz = push[2, 0] * push[0, 1] - push[2, 1] * push[0, 0]
        cx = push[0, 1] * push[1, 2] - push[0, 2] * push[1, 1]
        cy = push[0, 2] * push[1, 0] - push[0, 0] * push[1, 2]
        cz = push[0, 0] * push[1, 1] - push[0, 1] * push[1, 0]
        det = push[0, 0] * ax + push[0, 1] * ay + push[0, 2] * az
        if abs(det) < SINGULAR:
            return False
        inverse = -1.0 / det
        # A step no longer than the sphere: curved surfaces are not led astray.
        sx = (gap[0] * ax + gap[1] * bx + gap[2] * cx) * inverse
        sy = (gap[0] * ay + gap[1] * by + gap[2] * cy) * inverse
        sz = (gap[0] * az + gap[1] * bz + gap[2] * cz) * inverse
        length = math.sqrt(sx * sx + sy * sy + sz * sz)
        shorter = min(1.0, 0.5 * radius / max(length, 1e-300))
        x[0] += shorter * sx
        x[1] += shorter * sy
        x[2] += shorter * sz
    return False


@inner_loop
def is_borne(push: NDArray[np.float64], up: NDArray[np.float64]) -> bool:
    """Tell whether three contacts can bear a sphere's weight without friction.

    Args:
        push: Unit vectors from the surfaces to the sphere, shape (3, 3).
        up: Unit vector against gravity, shape (3,).
    """
    det, least, most = 0.0, np.inf, -np.inf
    for k in range(3):
        a, b = push[(k + 1) % 3], push[(k + 2) % 3]
        nx, ny, nz = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
        if k == 0:
            det = push[0, 0] * nx + push[0, 1] * ny + push[0, 2] * nz
        share = up[0] * nx + up[1] * ny + up[2] * nz
        least, most = min(least, share), max(most, share)
    if det > 0.0:
        return bool(least >= -1e-9 * det)
    return bool(most <= -1e-9 * det)


@inner_loop
def wall_room(  # type: ignore[no-untyped-def]
    x: float, y: float, z: float, radius: float, features: Features, near: FeatureMap
):
    """Return a sphere's least gap to the walls [m], and the feature that has it; -1: none is near."""
    kind, row = features
    cell = cell_of(x, y, z, near.grid)
    low, boundless = near.start[cell], count_boundless(x, y, z, near)
    least, which = np.inf, -1
    for k in range(low - boundless, near.start[cell + 1]):
        f = candidate(k, low, boundless, kind, near)
        if f < 0 or out_of_reach(kind[f], row[f], x, y, z, radius + least):
            continue
        gap = wall_gap(kind[f], row[f], x, y, z, radius)[0]
        if gap < least:
            least, which = gap, f
    return least, which


@inner_loop
def room_among(  # type: ignore[no-untyped-def]
    x: float, y: float, z: float, radius: float, features: Features, item: NDArray[np.int64]
):
    """Return a sphere's least gap to some features [m], and the one that has it; -1: there are none."""
    least, which = np.inf, -1
    for f in item:
        if out_of_reach(features.kind[f], features.row[f], x, y, z, radius + least):
            continue
        gap = wall_gap(features.kind[f], features.row[f], x, y, z, radius)[0]
        if gap < least:
            least, which = gap, f
    return least, which


@inner_loop
def polished_at_walls(
    x: NDArray[np.float64],
    kind: NDArray[np.int64],
    surface: NDArray[np.float64],
    push: NDArray[np.float64],
    base: NDArray[np.float64],
    radius: float,
    features: Features,
    item: NDArray[np.int64],
    slack: float,
) -> bool:
    """Do as ``polished`` does, and let facets that the sphere cuts take the place of those it touches.

    Args:
        x: See ``polished``, as are the others.
        kind: Kinds of the surfaces.
        surface: The surfaces; change.
        push: Out: unit vectors from them.
        base: Where coordinates begin.
        radius: Radius of the sphere.
        features: The features of the walls.
        item: Those that it can touch, any number.
        slack: Largest gap that counts as none.

    Returns:
        Whether the sphere touches all three and is inside every wall.
    """
    for _ in range(SUBSTITUTIONS_MAX):
        if not polished(x, kind, surface, push, base, radius, features, slack):
            return False
        px, py, pz = base[0] + x[0], base[1] + x[1], base[2] + x[2]
        gap, f = room_among(px, py, pz, radius, features, item)
        if gap >= -slack:
            return True
        _, nx, ny, nz = wall_gap(features.kind[f], features.row[f], px, py, pz, radius)
        best, which = -np.inf, -1
        for k in range(3):
            if kind[k] == FEATURE and int(surface[k, 0]) != f:
                alike = push[k, 0] * nx + push[k, 1] * ny + push[k, 2] * nz
                if alike > best:
                    best, which = alike, k
        if which < 0:
            return False
        surface[which, 0] = f
    return False


@inlined
def is_curved(kind: int) -> bool:
    """Tell whether a feature is neither a plane nor a sphere around."""
    return kind == TRIANGLE or kind == CONE
