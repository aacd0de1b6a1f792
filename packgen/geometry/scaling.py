"""Shapes made larger or smaller as a whole, about a point that stays where it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from packgen.arrays import Float64Array
from packgen.geometry.parts import Rotation, WallPart
from packgen.geometry.shapes import Ball, Box, Cone, Container, Mesh, Polyhedron, Shape, Surface
from packgen.portable import components


def fixed_point(container: Container) -> Float64Array:
    """Return the point about which a container is scaled [m], shape (3,).

    The lower corner of a box or of a mesh's bounds, the centre of the base of a cone, the centre of a ball.
    """
    shape = container.shape
    if isinstance(shape, Cone):
        return shape.base
    return shape.center if isinstance(shape, Ball) else np.asarray(container.bounds[0])


def scaled_container(container: Container, factor: float) -> Container:
    """Return a container with all its lengths times a factor; see ``fixed_point``."""
    if factor == 1.0:
        return container
    still = fixed_point(container)
    return replace(
        container,
        shape=_scaled(container.shape, still, factor),
        surface=_scaled_surface(container.surface, still, factor),
        bounds=still + (container.bounds - still) * factor,
        volume=container.volume * factor * factor * factor,
        parts=tuple(_moved(each, still, factor) for each in container.parts),
    )


def _moved(part: WallPart, still: Float64Array, factor: float) -> WallPart:
    """Return a part that turns about an axis moved with it; how fast and how far parts move stays."""
    turn = part.motion
    if not isinstance(turn, Rotation):
        return part
    return replace(part, motion=replace(turn, origin=still + (turn.origin - still) * factor))


def _scaled(shape: Shape, still: Float64Array, factor: float) -> Shape:
    if isinstance(shape, Box):
        return Box(still + (shape.min - still) * factor, still + (shape.max - still) * factor)
    if isinstance(shape, Cone):
        lengths = (shape.height, shape.radius_bottom, shape.radius_top)
        return Cone(shape.base, shape.axis, *(each * factor for each in lengths))
    if isinstance(shape, Ball):
        return Ball(shape.center, shape.radius * factor)
    surface = _scaled_surface(shape.surface, still, factor)
    if isinstance(shape, Mesh):
        return Mesh(surface)
    at = components(still[None], shape.normal)[0]
    return Polyhedron(shape.normal, at + (shape.offset - at) * factor, surface)


def _scaled_surface(surface: Surface, still: Float64Array, factor: float) -> Surface:
    return Surface(still + (surface.vertices - still) * factor, surface.faces)
