"""The shapes that bound spheres, their boxes, and which points a surface winds round."""

from __future__ import annotations

from packgen.geometry.shapes import (
    Ball,
    Box,
    Cone,
    Container,
    Mesh,
    Polyhedron,
    Shape,
    Slice,
    Surface,
    floor_direction,
)

__all__ = [
    "Ball", "Box", "Cone", "Container", "Mesh", "Polyhedron", "Shape", "Slice", "Surface", "floor_direction",
]  # fmt: skip
