"""Beds with planted overlaps in containers of every kind, their contacts known."""

from __future__ import annotations

from typing import Any

import numpy as np

from packgen.bed import Bed, Material, ParticleSet
from packgen.geometry import Ball, Cone, Mesh, Polyhedron, Surface
from tests.beds import box_container, make_bed, make_container, revolved_surface

OVERLAP = 1e-3  # radii


def planes(surface: Surface) -> tuple[np.ndarray, np.ndarray]:
    """Outward normals and offsets of the facets of a closed surface."""
    corners = surface.vertices[surface.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return normal, np.einsum("ij,ij->i", normal, corners[:, 0])


def mixed(position: Any, radius: Any, container: Any, **changes: Any) -> Bed:
    """A bed of two unlike materials in turn, in a vessel of a third one."""
    count = len(position)
    fields = {
        "set_index": np.arange(count, dtype=np.int32) % 2,
        "particle_sets": (ParticleSet("a", 2500.0, "coke"), ParticleSet("b", 3500.0, "ore")),
        "materials": (
            Material("ore", 1e8, 0.25, 0.5, 0.4),
            Material("steel", 1e9, 0.3, 0.6, 0.2),
            Material("coke", 3e7, 0.2, 0.3, 0.6),
        ),
        "wall_material": "steel",
    }
    return make_bed(position, radius, container, **(fields | changes))


def drum_surface() -> Surface:
    return revolved_surface([(0, 4), (4, 4)], 64)


def hopper_surface() -> Surface:
    return revolved_surface([(0, 2), (6, 5)], 24)


def bed_in(kind: str) -> Bed:
    """Spheres of radius 1 and 0.8: a pair, one at the floor, one at the side, each ``OVERLAP`` radii deep."""
    depth = 1 - OVERLAP
    up = np.array([0.0, 0.0, 1.0])
    if kind == "box":
        container = box_container((0, 0, 0), (8, 8, 6))
        floor, side = np.array([4, 4, depth]), np.array([depth, 2, 3])
    elif kind == "ball":
        surface = revolved_surface([(-4, 0.1), (0, 5), (4, 0.1)], 24)  # for pictures only
        container = make_container(Ball(np.zeros(3), 4.0), surface, 1.0)
        floor, side = np.array([0, 0, depth - 4]), np.array([4 - depth, 0, 0])
    elif kind in ("cylinder", "drum", "mesh"):
        surface, angle = drum_surface(), np.pi / 64  # the middle of a facet
        normal, offset = planes(surface)
        shapes = {
            "cylinder": Cone(np.zeros(3), up, 4.0, 4.0, 4.0),
            "drum": Polyhedron(normal, offset, surface),
        }
        container = make_container(shapes.get(kind, Mesh(surface)), surface, 1.0)
        distance = 4 if kind == "cylinder" else 4 * np.cos(angle)
        floor = np.array([0, -1, depth])
        side = (distance - depth) * np.array([np.cos(angle), np.sin(angle), 0]) + 2 * up
    else:
        surface, slope = hopper_surface(), 0.5
        normal, offset = planes(surface)
        shape = (
            Cone(np.zeros(3), up, 6.0, 2.0, 5.0) if kind == "cone" else Polyhedron(normal, offset, surface)
        )
        container = make_container(shape, surface, 1.0)
        angle = np.pi / 24
        radius = 2.0 if kind == "cone" else 2.0 * np.cos(angle)
        slope = 0.5 * (1.0 if kind == "cone" else np.cos(angle))
        across = radius + slope * 3.5 - depth * np.hypot(1, slope)
        floor, side = np.array([0, 0, depth]), across * np.array([np.cos(angle), np.sin(angle), 0]) + 3.5 * up
    step = (1.8 - 0.8 * OVERLAP) * np.array([-0.6, 0.0, 0.8])
    return mixed([floor, side, floor + step], [1.0, 1.0, 0.8], container)
