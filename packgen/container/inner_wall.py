"""A container less the inside of a closed mesh: the mesh becomes an inner wall."""

from __future__ import annotations

import math

import numpy as np

from packgen.arrays import Float64Array
from packgen.container.primitives import cone_surface
from packgen.container.shells import flipped, stacked
from packgen.container.topology import Rim, boundary_edges, capped
from packgen.geometry import Ball, Cone, Container, Mesh, Surface

POINTS = 20_000  # that tell how much of a mesh is in the container
SEGMENTS = 720  # round a container that was exact: its corners lie 1e-5 of the radius outside the true wall


def with_inner_wall(container: Container, inner: Container) -> tuple[Container, str]:
    """Return a container whose spheres stay outside of a closed mesh.

    Args:
        container: The container, which does not wrap around.
        inner: The closed mesh; it may reach out of the container.

    Returns:
        (the container as a mesh that is not convex, or as it was where the mesh is beside it; a sentence that
        says what its walls are). Its volume is exact where the mesh is within, else good to about 1 % of the
        mesh's.
    """
    walls = (
        cone_surface(container.shape, SEGMENTS) if isinstance(container.shape, Cone) else container.surface
    )
    outer = container.shape.surface if isinstance(container.shape, Mesh) else _lidded(walls)
    body = inner.shape.surface if isinstance(inner.shape, Mesh) else inner.surface
    share = share_within(body, outer)
    if share == 0.0:
        return container, f"walls: {container.name}; {inner.name} is beside it"
    closed = stacked([outer, flipped(body)])
    # Solvers lose facets outside of their box: it has to hold what reaches out of the container.
    bounds = np.stack(
        [np.minimum(container.bounds[0], inner.bounds[0]), np.maximum(container.bounds[1], inner.bounds[1])]
    )
    carved = Container(
        f"{container.name} without {inner.name}", Mesh(closed), stacked([walls, flipped(inner.surface)]),
        bounds, container.volume - share * inner.volume, parts=container.parts,
    )  # fmt: skip
    told = f"walls: {container.name}, and {inner.name} as an inner wall"
    if share < 1.0:
        told += f", of whose volume {share:.3g} is inside"
    gap = _gap(container, walls)
    if gap > 0.0:
        told += f"; what is round is facets now, up to {gap:.2g} m outside the true wall"
    return carved, told


def _lidded(walls: Surface) -> Surface:
    edges = boundary_edges(walls)
    return capped(walls, Rim(edges, 0.0, level=True)) if len(edges) else walls


def share_within(body: Surface, outer: Surface) -> float:
    """Return how much of a body's volume is inside a closed surface: 0 and 1 where none and all of it is."""
    from packgen.check.inside import inside

    low, high = body.vertices.min(axis=0), body.vertices.max(axis=0)
    points = low + np.random.default_rng(0).random((POINTS, 3)) * (high - low)
    points = points[inside(body.vertices[body.faces], points)]
    held = inside(outer.vertices[outer.faces], points)
    corners = inside(outer.vertices[outer.faces], _drawn_in(body))
    if held.all() and corners.all():
        return 1.0
    if not held.any():
        return 0.0
    return float(held.mean())


def _drawn_in(body: Surface) -> Float64Array:
    """Return a body's corners, drawn a little towards its middle: one may lie on the other surface."""
    middle = 0.5 * (body.vertices.min(axis=0) + body.vertices.max(axis=0))
    drawn: Float64Array = middle + (body.vertices - middle) * (1.0 - 1.0e-9)
    return drawn


def _gap(container: Container, walls: Surface) -> float:
    """Return how far the facets of a round container lie outside its true wall at most [m]."""
    shape = container.shape
    if isinstance(shape, Cone):
        return max(shape.radius_bottom, shape.radius_top) * (1.0 / math.cos(math.pi / SEGMENTS) - 1.0)
    if isinstance(shape, Ball):
        return float(np.linalg.norm(walls.vertices - shape.center, axis=1).max() - shape.radius)
    return 0.0
