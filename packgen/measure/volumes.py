"""Volumes of spheres and containers on one side of a plane, in closed form."""

from __future__ import annotations

import numpy as np

from packgen.arrays import Float64Array
from packgen.check.mesh import MeshWalls
from packgen.geometry import Ball, Cone, Container, Mesh, Surface

POINTS = 20_000  # random points in a mesh whose shells cross


def sphere_volume(radius: Float64Array) -> Float64Array:
    """Return the volumes [m3] of spheres of the given radii [m], same shape."""
    volume: Float64Array = (4.0 / 3.0) * np.pi * radius**3
    return volume


def mean_diameter(radius: Float64Array) -> float:
    """Return the mean diameter of spheres by volume [m], 2 sum r^4 / sum r^3 (De Brouckere's mean)."""
    return 2.0 * float((radius**4).sum() / (radius**3).sum())


def volume_below(height: Float64Array, radius: Float64Array, level: float | Float64Array) -> Float64Array:
    """Return the part of each sphere's volume below a level, or below one of its own.

    Args:
        height: Heights of the centres [m], shape (N,), float64.
        radius: Sphere radii [m], shape (N,), float64.
        level: Height of the cutting plane [m], one or (N,).

    Returns:
        Volume below the plane [m3], shape (N,), float64: a spherical cap of depth t has pi t^2 (3 r - t) / 3.
    """
    depth = np.clip(level - (height - radius), 0.0, 2.0 * radius)
    volume: Float64Array = np.pi / 3.0 * depth**2 * (3.0 * radius - depth)
    return volume


def container_volume_below(container: Container, up: Float64Array, level: Float64Array) -> Float64Array:
    """Return the container's volume below each of some levels.

    Exact for a ball, for a cone or cylinder that stands along ``up``, and for everything bounded by planes; a
    cone that lies askew is measured by its triangles, scaled to its exact volume, a mesh whose shells cross
    by points.

    Args:
        container: The vessel.
        up: Unit vector against gravity, shape (3,), float64.
        level: Heights ``up @ x`` of the cutting planes [m], shape (L,), float64.

    Returns:
        Volumes [m3], shape (L,), float64.
    """
    shape = container.shape
    if isinstance(shape, Ball):
        return volume_below(np.full(len(level), shape.center @ up), np.full(len(level), shape.radius), level)
    if isinstance(shape, Cone) and abs(abs(float(shape.axis @ up)) - 1.0) < 1e-12:
        return _cone_volume_below(shape, up, level)
    # The surface of a mesh has either side of its sheets, which cancel, and lids.
    surface = shape.surface if isinstance(shape, Mesh) else container.surface
    volume = surface_volume_below(surface, up, np.append(level, np.inf))
    part, whole = volume[:-1], float(volume[-1])
    if isinstance(shape, Cone):
        return np.asarray(part * (container.volume / whole))
    if isinstance(shape, Mesh) and abs(whole - container.volume) > 1e-6 * container.volume:
        return _crossing_volume_below(container, shape, up, level)
    return part


def _crossing_volume_below(
    container: Container, mesh: Mesh, up: Float64Array, level: Float64Array
) -> Float64Array:
    """Volumes of a mesh whose shells cross, to about 1 %: by points, for triangles count space twice."""
    low, high = container.bounds
    points = low + np.random.default_rng(0).random((POINTS, 3)) * (high - low)
    within = points[MeshWalls(mesh.surface).contains(points)] @ up
    share = np.searchsorted(np.sort(within), level) / max(len(within), 1)
    return np.asarray(container.volume * share)


def _cone_volume_below(cone: Cone, up: Float64Array, level: Float64Array) -> Float64Array:
    """Volume of an upright frustum below levels: pi h (a^2 + a b + b^2) / 3 with the end radii a and b."""
    upward = float(cone.axis @ up) > 0.0
    low = cone.radius_bottom if upward else cone.radius_top
    high = cone.radius_top if upward else cone.radius_bottom
    bottom = float(cone.base @ up) - (0.0 if upward else cone.height)
    depth = np.clip(level - bottom, 0.0, cone.height)
    cut = low + (high - low) * depth / cone.height
    volume: Float64Array = np.pi * depth * (low**2 + low * cut + cut**2) / 3.0
    return volume


def surface_volume_below(surface: Surface, up: Float64Array, level: Float64Array) -> Float64Array:
    """Return the volume that a surface encloses below each of some levels.

    The surface is clipped by the plane; each remaining triangle spans a tetrahedron with a point of the
    plane, and their signed volumes add up to the enclosed one, since the cut itself spans none. So an open
    top needs no lid as long as its rim is level. Triangles that are below a level as a whole are summed once
    for all levels.

    Args:
        surface: Triangles seen from outside counter-clockwise.
        up: Unit vector against gravity, shape (3,), float64.
        level: Heights of the cutting planes [m], shape (L,), float64; above the surface's top: the whole
            volume up to the top.

    Returns:
        Volumes [m3], shape (L,), float64.
    """
    height = surface.vertices @ up
    top = float(height.max())
    highest = surface.vertices[int(height.argmax())]
    # As seen from the highest corner, so that a vessel far from the origin keeps its digits.
    corners = (surface.vertices - highest)[surface.faces]
    reach = (height - top)[surface.faces]
    low, high = reach.min(axis=1), reach.max(axis=1)
    order = np.argsort(high)
    area, spanned = (_running_sum(each) for each in _spanned(corners[order]))
    volume = np.empty(len(level))
    for place, depth in enumerate(np.minimum(level - top, 0.0)):
        whole = int(np.searchsorted(high[order], depth, side="right"))
        cut = (low < depth) & (high > depth)
        apex = depth * up
        parts = _clipped(corners[cut] - apex, reach[cut] - depth)
        volume[place] = spanned[whole] - area[whole] @ apex + _spanned(parts)[1].sum()
    return volume / 6.0


def wall_area_below(container: Container, up: Float64Array, level: float) -> float:
    """Return the area of a container's walls and floor below a level [m2]; periodic sides are no walls.

    Args:
        container: The vessel.
        up: Unit vector against gravity, shape (3,), float64.
        level: Height ``up @ x`` of the plane [m]; a lid at this height counts.
    """
    if container.cell is not None:
        return 0.0
    corners = container.surface.vertices[container.surface.faces]
    seam = np.zeros(len(corners), dtype=bool)
    for axis in np.flatnonzero(container.periodic):
        for side in container.bounds[:, axis]:
            seam |= (corners[:, :, axis] == side).all(axis=1)
    walls = corners[~seam]
    parts = _clipped(walls, walls @ up - level)
    return 0.5 * float(np.linalg.norm(_spanned(parts)[0], axis=1).sum())


def _running_sum(terms: Float64Array) -> Float64Array:
    """Return the sums of the first 0, 1, 2, ... terms, shape (F + 1, ...)."""
    return np.concatenate([np.zeros_like(terms[:1]), np.cumsum(terms, axis=0)])


def _spanned(corners: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return twice the area vector of triangles (F, 3, 3), and six times what they span with the origin."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    area = np.cross(b - a, c - a)
    return area, np.einsum("ij,ij->i", a, area)


def _clipped(corners: Float64Array, height: Float64Array) -> Float64Array:
    """Return the parts of triangles (F, 3, 3) whose corners' ``height`` (F, 3) is below 0, as triangles."""
    below = height <= 0.0
    count = below.sum(axis=1)
    pieces = [corners[count == 3]]
    for inside in (1, 2):
        chosen = count == inside
        part, level = corners[chosen], height[chosen]
        # Turn each triangle so that its odd corner out comes first.
        odd = below[chosen] if inside == 1 else ~below[chosen]
        turn = (odd.argmax(axis=1)[:, None] + np.arange(3)) % 3
        part = np.take_along_axis(part, turn[:, :, None], axis=1)
        level = np.take_along_axis(level, turn, axis=1)
        a, b, c = part[:, 0], part[:, 1], part[:, 2]
        on_ab = a + (level[:, 0] / (level[:, 0] - level[:, 1]))[:, None] * (b - a)
        on_ac = a + (level[:, 0] / (level[:, 0] - level[:, 2]))[:, None] * (c - a)
        if inside == 1:
            pieces.append(np.stack([a, on_ab, on_ac], axis=1))
        else:
            pieces.append(np.stack([on_ab, b, c], axis=1))
            pieces.append(np.stack([on_ab, c, on_ac], axis=1))
    return np.concatenate(pieces)
