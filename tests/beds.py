"""Beds made by hand, whose properties are known in closed form."""

from __future__ import annotations

from typing import Any

import numpy as np

from packgen.bed import Bed, Material, ParticleSet
from packgen.geometry import Box, Container, Shape, Surface

BOX_FACES = np.array(
    [
        [0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4],
        [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7],
    ]
)  # fmt: skip


def box_surface(low: Any, high: Any) -> Surface:
    """The twelve triangles of an axis-parallel box."""
    unit = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]])
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return Surface(low + unit * (high - low), BOX_FACES)


def revolved_surface(profile: list[tuple[float, float]], facets: int) -> Surface:
    """A closed surface of revolution about z from a profile of (height, radius)."""
    angle = 2.0 * np.pi * np.arange(facets) / facets
    rings = [np.stack([r * np.cos(angle), r * np.sin(angle), np.full(facets, z)], axis=1) for z, r in profile]
    vertices = np.concatenate([*rings, [[0, 0, profile[0][0]], [0, 0, profile[-1][0]]]])
    this, after = np.arange(facets), (np.arange(facets) + 1) % facets
    faces = []
    for ring in range(len(profile) - 1):
        a, b = ring * facets, (ring + 1) * facets
        faces += [np.stack([a + this, a + after, b + after], 1), np.stack([a + this, b + after, b + this], 1)]
    bottom, top, last = len(vertices) - 2, len(vertices) - 1, (len(profile) - 1) * facets
    faces.append(np.stack([np.full(facets, bottom), after, this], 1))
    faces.append(np.stack([np.full(facets, top), last + this, last + after], 1))
    return Surface(vertices, np.concatenate(faces))


def make_container(
    shape: Shape, surface: Surface, volume: float, periodic: tuple[bool, bool, bool] = (False, False, False)
) -> Container:
    bounds = np.stack([surface.vertices.min(axis=0), surface.vertices.max(axis=0)])
    return Container("vessel", shape, surface, bounds, volume, periodic)


def box_container(
    low: Any, high: Any, periodic: tuple[bool, bool, bool] = (False, False, False)
) -> Container:
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    return make_container(Box(low, high), box_surface(low, high), float(np.prod(high - low)), periodic)


def make_bed(position: Any, radius: Any, container: Container, **changes: Any) -> Bed:
    """A bed of one set of steel spheres, all of zone and batch 0, gravity along -z."""
    position = np.asarray(position, dtype=np.float64).reshape(-1, 3)
    count = len(position)
    fields: dict[str, Any] = {
        "position": position,
        "radius": np.broadcast_to(np.asarray(radius, dtype=np.float64), count).copy(),
        "set_index": np.zeros(count, dtype=np.int32),
        "zone_index": np.zeros(count, dtype=np.int32),
        "batch_index": np.zeros(count, dtype=np.int32),
        "particle_sets": (ParticleSet("pellets", 2500.0, "ore"),),
        "materials": (Material("ore"),),
        "wall_material": "ore",
        "container": container,
        "gravity": np.array([0.0, 0.0, -9.81]),
    }
    return Bed(**(fields | changes))


def cubic_lattice(count: int, radius: float) -> np.ndarray:
    """Centres of ``count`` cubed spheres that touch, a simple cubic lattice in a box from the origin."""
    steps = radius * (2.0 * np.arange(count) + 1.0)
    return np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)


def fcc_lattice(count: int, radius: float) -> np.ndarray:
    """Centres of 4 ``count``^3 touching spheres, face-centred cubic, off the faces of their cubic cell."""
    edge = 2.0 * np.sqrt(2.0) * radius
    corner = np.stack(np.meshgrid(*[np.arange(count)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    basis = np.array([[0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5]]) + 0.25
    return ((corner + basis) * edge).reshape(-1, 3)
