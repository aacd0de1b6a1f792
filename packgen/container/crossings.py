"""Shells within shells, surfaces that cross, and volumes by points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from packgen.arrays import Float64Array
from packgen.geometry import Surface

SAMPLES = 128
"""Points of a body that are tested to tell whether it lies within another."""


STRICTLY = 0.9
"""Winding number beyond which such a point is within: on the other's surface it is less."""


ANGLES = 10_000_000


POINTS = (64, 2048)
"""Solid angles, and least and most points, of the test whether a surface crosses itself."""


VOLUME_POINTS = 20_000


@dataclass(frozen=True, eq=False, slots=True)
class _Shell:
    walls: Surface
    closed: Surface
    volume: float
    lidded: bool
    turned: int


def _depths(shells: list[_Shell]) -> tuple[list[int], list[int]]:
    """Return the nesting depth of each shell, and the shells that cross a larger one."""
    from packgen.geometry.winding import winding_numbers

    depth, crossing = [0] * len(shells), []
    for index, shell in enumerate(shells):
        points = spread_points(shell.walls)
        for larger in shells[:index]:
            low, high = larger.closed.vertices.min(axis=0), larger.closed.vertices.max(axis=0)
            near = ((points > low) & (points < high)).all(axis=1)
            if near.any():
                corner = larger.closed.vertices[larger.closed.faces].reshape(-1, 9)
                winding = np.abs(winding_numbers(corner, points[near]))
                if (winding > STRICTLY).any():
                    depth[index] += 1
                    beyond = ((points < low) | (points > high)).any(axis=1)
                    if beyond.any() or (winding < 1.0 - STRICTLY).any():
                        crossing.append(index)
    return depth, crossing


def spread_points(surface: Surface) -> Float64Array:
    """Return `SAMPLES` points of a surface [m], (N, 3), spread evenly by area."""
    corners = surface.vertices[surface.faces]
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    rng = np.random.default_rng(0)
    a, b, c = np.moveaxis(corners[rng.choice(len(corners), SAMPLES, p=area / area.sum())], 1, 0)
    first, second = rng.random((2, SAMPLES, 1))
    folded = first + second > 1.0
    first, second = np.where(folded, 1.0 - first, first), np.where(folded, 1.0 - second, second)
    points: Float64Array = a + first * (b - a) + second * (c - a)
    return points


def _notes(shells: list[_Shell], depth: list[int], crossing: list[int]) -> list[str]:
    """Return a sentence for each shell that may not be what was meant."""
    separate = depth.count(0)
    notes = []
    if separate > 1:
        notes.append(
            f"{separate} separate shells: each of them will be filled; remove from the file what is no vessel"
        )
    for index in crossing:
        x, y, z = shells[index].walls.vertices.mean(axis=0)
        notes.append(
            f"the shell around x={x:.4g} y={y:.4g} z={z:.4g} m crosses a larger one and counts as a solid "
            "body (a lance, a tube); if both are one vessel, unite them"
        )
    return notes


def _self_crossings(closed: Surface) -> list[str]:
    """Return a sentence where a surface winds round points twice or backwards: it crosses itself."""
    from packgen.geometry.winding import winding_numbers

    low, high = closed.vertices.min(axis=0), closed.vertices.max(axis=0)
    count = int(np.clip(ANGLES // len(closed.faces), *POINTS))
    points = low + np.random.default_rng(0).random((count, 3)) * (high - low)
    winding = winding_numbers(closed.vertices[closed.faces].reshape(-1, 9), points)
    wrong = (winding < -0.75) | (winding > 1.75)
    if not wrong.any():
        return []
    x, y, z = points[wrong].mean(axis=0)
    return [
        f"the surface crosses itself, such as around x={x:.4g} y={y:.4g} z={z:.4g} m: {wrong.mean():.1%} of "
        "its bounding box is inside twice, or inside out and taken as outside; repair it"
    ]


def _volume_by_points(closed: Surface) -> float:
    """Return the volume [m3] of the points that a surface winds round, to about 1 %."""
    from packgen.check.inside import inside

    low, high = closed.vertices.min(axis=0), closed.vertices.max(axis=0)
    points = low + np.random.default_rng(0).random((VOLUME_POINTS, 3)) * (high - low)
    return float(inside(closed.vertices[closed.faces], points).mean() * np.prod(high - low))
