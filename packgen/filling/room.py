"""How much room a zone has within the container: what bounds it, whether both meet, and its volume."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from packgen.arrays import Float64Array
from packgen.check import wall_clearance
from packgen.check.inside import inside
from packgen.errors import GeometryError
from packgen.geometry import Ball, Box, Cone, Container, Mesh, Shape, Slice

Locations = tuple[Shape | Slice, ...]

POINTS = 8192
FEW = 64  # of them, that tell first
SIGMAS = 4.0

CELLS = 64
"""Cells along each side of a box, with a random point each, that measure a volume to 3e-4 of the box."""


def narrowest(bounds: Float64Array, periodic: tuple[bool, bool, bool]) -> tuple[float, str]:
    """Return the least extent between walls [m], infinite where there are none, and its axis.

    Args:
        bounds: Lower and upper corner [m], shape (2, 3).
        periodic: Axes along which there are no walls.
    """
    extent = np.where(periodic, np.inf, bounds[1] - bounds[0])
    axis = int(np.argmin(extent))
    return float(extent[axis]), "xyz"[axis]


def room_of(container: Container, own: Locations, radius_min: float, radius_max: float, place: str) -> float:
    """Return a volume [m3] that the part of a zone within the container does not exceed.

    Args:
        container: The container.
        own: What bounds the zone beside it; nothing: the whole container.
        radius_min: Smallest radius of the zone's spheres [m].
        radius_max: Largest radius [m]: spheres reach that far beyond a slice that bounds their centres.
        place: Where the scene names the location, for messages.

    Returns:
        The volume, exact between planes along the axes, else from above by points.

    Raises:
        GeometryError: There is no such part, or no sphere fits between its ends.
    """
    if not own:
        return container.volume
    bounds = _common_bounds(container, own)
    _check_meeting(bounds, container, own, place)
    whole = [each for each in own if not (isinstance(each, Slice) and each.centers_only)]
    width, axis = narrowest(_common_bounds(container, whole), container.periodic)
    if 2.0 * radius_min > width * (1.0 + 1e-9):
        raise GeometryError(
            f"{place}: found {width:.4g} m along {axis} within the container, but not one sphere of it fits "
            f"(smallest radius {radius_min:.4g} m); expected a wider zone or smaller spheres"
        )
    sliced = isinstance(container.shape, Mesh) and len(own) == 1 and isinstance(own[0], Slice)
    if not (volume_of(container, own) > 0.0 if sliced else _meet([container.shape, *own], bounds)):
        raise GeometryError(
            f"{place}: lies outside the container, although their bounding boxes meet: found no point within "
            "both; expected a zone inside it; move it"
        )
    reach = tuple(_widened(each, radius_max) for each in own)
    if sliced:
        return volume_of(container, reach)
    bounds = _common_bounds(container, reach)
    share = _share_within([container.shape, *reach], bounds)
    error = SIGMAS * np.sqrt(share * (1.0 - share) / POINTS) + (SIGMAS / POINTS if share < 1.0 else 0.0)
    return float(np.prod(bounds[1] - bounds[0]) * min(share + error, 1.0))


def width_of(container: Container, own: Locations = ()) -> float:
    """Return the least extent of the part of a zone within the container [m], walls or not."""
    low, high = _common_bounds(container, own)
    return float((high - low).min())


def volume_of(container: Container, own: Locations) -> float:
    """Return the volume of the part of a zone within the container [m3].

    Args:
        container: The container.
        own: What bounds the zone beside it; nothing: the whole container.

    Returns:
        The volume, exact of a whole container, of a slice of one, and between planes along the axes; else to
        about 3e-4 of its bounding box.
    """
    if not own:
        return container.volume
    if len(own) == 1 and isinstance(own[0], Slice):
        from packgen.measure.volumes import container_volume_below

        levels = np.array([own[0].low, own[0].high])
        return float(np.diff(container_volume_below(container, own[0].axis, levels))[0])
    bounds = _common_bounds(container, own)
    shapes = [container.shape, *own]
    if all(isinstance(each, Box | Slice) for each in shapes):
        return float(np.prod(bounds[1] - bounds[0]))
    points = even_points(bounds)
    return float(np.prod(bounds[1] - bounds[0])) * len(_points_within(shapes, points)) / len(points)


def volume_inside(container: Container, depth: float) -> float:
    """Return the volume of the points at least so deep within the walls of a container [m3]."""
    points = even_points(np.array(container.bounds))
    deep = wall_clearance(container, points, np.full(len(points), depth)) >= depth
    return float(np.prod(container.bounds[1] - container.bounds[0])) * float(deep.mean())


def even_points(bounds: Float64Array) -> Float64Array:
    """Return points of a box (2, 3) [m], one at random in each of its cells, shape (n, 3)."""
    cell = np.stack(np.meshgrid(*[np.arange(CELLS)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    shares = (cell + np.random.default_rng(0).random(cell.shape)) / CELLS
    return np.asarray(bounds[0] + shares * (bounds[1] - bounds[0]))


def _widened(shape: Shape | Slice, reach: float) -> Shape | Slice:
    if not (isinstance(shape, Slice) and shape.centers_only):
        return shape
    return Slice(shape.axis, shape.low - reach, shape.high + reach, centers_only=True)


def _common_bounds(container: Container, locations: Sequence[Shape | Slice]) -> Float64Array:
    """Return the corners of what the bounding boxes of container and locations share [m], shape (2, 3)."""
    from packgen.geometry.bounds import shape_bounds

    bounds = np.array(container.bounds)
    for each in locations:
        least, most = shape_bounds(each)
        bounds = np.stack([np.maximum(bounds[0], least), np.minimum(bounds[1], most)])
    return bounds


def _check_meeting(bounds: Float64Array, container: Container, own: Locations, place: str) -> None:
    from packgen.geometry.bounds import shape_bounds

    apart = np.flatnonzero(bounds[0] >= bounds[1])
    if len(apart) == 0:
        return
    axis = int(apart[0])
    least, most = (float(each[axis]) for each in shape_bounds(own[0]))
    low, high = container.bounds[:, axis]
    raise GeometryError(
        f"{place}: lies outside the container: found {least:.4g} to {most:.4g} m along {'xyz'[axis]}, the "
        f"container goes from {low:.4g} to {high:.4g} m; expected a zone inside it; move it"
    )


def _meet(shapes: Sequence[Shape | Slice], bounds: Float64Array) -> bool:
    """Return whether some of the points of `_share_within` are within all of some shapes."""
    if all(isinstance(each, Box | Slice) for each in shapes):
        return True
    points = bounds[0] + np.random.default_rng(0).random((POINTS, 3)) * (bounds[1] - bounds[0])
    parts = points[:FEW], points[FEW:]
    return any(len(_points_within(shapes, part)) > 0 for part in parts)


def _share_within(shapes: Sequence[Shape | Slice], bounds: Float64Array) -> float:
    """Return the share of a box (2, 3) [m] that is within all of some shapes, by points."""
    if all(isinstance(each, Box | Slice) for each in shapes):
        return 1.0  # all are axis-parallel boxes, and so is their intersection
    points = bounds[0] + np.random.default_rng(0).random((POINTS, 3)) * (bounds[1] - bounds[0])
    return float(len(_points_within(shapes, points)) / POINTS)


def _points_within(shapes: Sequence[Shape | Slice], points: Float64Array) -> Float64Array:
    """Return those of some points (N, 3) [m] that are within all of some shapes, (n, 3)."""
    # The cheapest first: a mesh tests only the points that the others leave.
    for shape in sorted(shapes, key=lambda each: isinstance(each, Mesh)):
        points = points[within(shape, points)]
    return points


def within(shape: Shape | Slice, points: Float64Array) -> np.ndarray:
    """Tell which points [m], shape (N, 3), are within a shape, shape (N,)."""
    if isinstance(shape, Mesh):
        return inside(shape.surface.vertices[shape.surface.faces], points)
    if isinstance(shape, Box):
        return np.asarray(((points >= shape.min) & (points <= shape.max)).all(axis=1))
    if isinstance(shape, Ball):
        return np.asarray(np.linalg.norm(points - shape.center, axis=1) <= shape.radius)
    if isinstance(shape, Slice):
        along = points @ shape.axis
        return np.asarray((along >= shape.low) & (along <= shape.high))
    if isinstance(shape, Cone):
        along = (points - shape.base) @ shape.axis
        across = np.linalg.norm(points - shape.base - along[:, None] * shape.axis, axis=1)
        radius = shape.radius_bottom + (shape.radius_top - shape.radius_bottom) * along / shape.height
        return np.asarray((along >= 0.0) & (along <= shape.height) & (across <= radius))
    return np.asarray((points @ shape.normal.T <= shape.offset).all(axis=1))
