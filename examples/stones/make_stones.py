"""Make the stones: ``python examples/stones/make_stones.py`` writes the STL files beside itself.

A crushed stone is the hull of random points, its edges worn. A pebble is an ellipsoid with bumps. A shard
is an L, bevelled. Binary STL holds single precision.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from scipy.spatial import ConvexHull

sys.path.append(str(Path(__file__).resolve().parents[1]))

import shells

SIZE = 0.02  # m, about the length of each stone


def sphere(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """Return directions (V, 3) and triangles (F, 3) of a sphere of latitudes and longitudes."""
    sectors = 2 * rings
    polar, azimuth = np.pi * np.arange(1, rings) / rings, 2.0 * np.pi * np.arange(sectors) / sectors
    flat = np.sin(polar)[:, None]
    ring = np.stack(
        [flat * np.cos(azimuth), flat * np.sin(azimuth), np.cos(polar)[:, None] + 0.0 * azimuth], axis=2
    )
    direction = np.concatenate([ring.reshape(-1, 3), [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    here, last = np.arange(sectors), (rings - 2) * sectors
    after = np.roll(here, -1)
    top, bottom = np.full(sectors, len(direction) - 2), np.full(sectors, len(direction) - 1)
    faces = [np.stack([top, here, after], axis=1), np.stack([bottom, last + after, last + here], axis=1)]
    for row in range(rings - 2):
        one, two = row * sectors, (row + 1) * sectors
        faces += [np.stack([one + here, two + here, two + after], axis=1)]
        faces += [np.stack([one + here, two + after, one + after], axis=1)]
    return direction, np.concatenate(faces)


def crushed(seed: int = 3) -> tuple[np.ndarray, np.ndarray]:
    """Return the hull of points on an ellipsoid, its corners and edges worn by a radius."""
    rng = np.random.default_rng(seed)
    point = rng.normal(size=(24, 3))
    point *= np.array([0.33, 0.26, 0.21]) / np.linalg.norm(point, axis=1, keepdims=True)
    direction, _ = sphere(10)
    # The hull of small spheres around the points.
    worn = (point[:, None] + 0.09 * direction).reshape(-1, 3)
    hull = ConvexHull(worn)
    corner = worn[hull.simplices]
    inner = (
        np.einsum(
            "fi,fi->f", np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), corner[:, 0]
        )
        < 0
    )
    faces = np.where(inner[:, None], hull.simplices[:, ::-1], hull.simplices)
    return worn, faces


def pebble(seed: int = 5) -> tuple[np.ndarray, np.ndarray]:
    """Return an ellipsoid with long waves."""
    rng = np.random.default_rng(seed)
    direction, faces = sphere(40)
    height = np.zeros(len(direction))
    for frequency, strength in ((1.5, 0.05), (2.5, 0.03), (4.0, 0.012)):
        for _ in range(4):
            wave = rng.normal(size=3)
            height += strength * np.sin(
                frequency * direction @ (wave / np.linalg.norm(wave)) * np.pi + rng.uniform(0, 6)
            )
    return direction * (1.0 + height)[:, None] * [0.5, 0.38, 0.28], faces


def shard() -> tuple[np.ndarray, np.ndarray]:
    """Return an L with round edges: all points around a bent line, the legs as bars of another thickness."""
    direction, faces = sphere(40)
    # Of a body that is seen as a whole from its middle a ray leaves it once.
    low, high = np.zeros(len(direction)), np.full(len(direction), 2.0)
    for _ in range(50):
        middle = 0.5 * (low + high)
        inside = _in_shard(middle[:, None] * direction)
        low, high = np.where(inside, middle, low), np.where(inside, high, middle)
    return direction * low[:, None], faces


def _in_shard(point: np.ndarray) -> np.ndarray:
    """Return whether points (N, 3) are in two bars that meet at the origin."""
    bars = (([0.22, 0.0, 0.0], [0.34, 0.12, 0.15]), ([0.0, 0.16, 0.0], [0.12, 0.28, 0.13]))
    inside = np.zeros(len(point), bool)
    for centre, half in bars:
        away = np.maximum(np.abs(point - centre) - np.array(half) + 0.1, 0.0)
        inside |= np.linalg.norm(away, axis=1) < 0.1
    return inside


def main() -> None:
    """Write all stones."""
    folder = Path(__file__).parent
    for name, make in (("crushed", crushed), ("pebble", pebble), ("shard", shard)):
        vertices, faces = make()
        shells.write_stl(folder / f"{name}.stl", SIZE * vertices[faces])


if __name__ == "__main__":
    main()
