"""The shapes that bound spheres, their boxes, and which points a surface winds round."""

from __future__ import annotations

from packgen.geometry.parts import Motion, Rotation, Translation, Vibration, WallPart
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
    "Ball", "Box", "Cone", "Container", "Mesh", "Motion", "Polyhedron", "Rotation", "Shape", "Slice",
    "Surface", "Translation", "Vibration", "WallPart", "floor_direction",
]  # fmt: skip
