"""The space that one zone's spheres live in: container and location together, seen along gravity."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.inside import InsideMap
from packgen.arrange.seams import Seams
from packgen.arrange.walls import WallTable, least_gap, wall_table
from packgen.arrays import Float64Array
from packgen.errors import PackingError
from packgen.geometry import Ball, Box, Cone, Container, Mesh, Shape, Slice
from packgen.portable import components, length

COLUMNS_MAX = 4_000_000

SECTION_POINTS = 4096
"""Points that measure a cross-section."""

ROUND_MAX = 1.1
"""A section is round whose circle around it is at most so much larger: 1.05 for a dodecagon, 1.21 for a
hexagon."""


@dataclass(frozen=True, eq=False, slots=True)
class Region:
    """A zone's space.

    Attributes:
        walls: What bounds its spheres.
        bounds: Its bounding box [m], shape (2, 3).
        frame: Unit vectors across and against gravity: rows u, v, up, shape (3, 3).
        floor: Lowest altitude (distance along up) [m].
        ceiling: Highest altitude [m].
        sides: Which side of its meshes a point is on; None: no mesh bounds it, gaps alone tell.
    """

    walls: WallTable
    bounds: Float64Array
    frame: Float64Array
    floor: float
    ceiling: float
    sides: InsideMap | None = None

    @property
    def down(self) -> Float64Array:
        """Unit vector along which things fall, shape (3,)."""
        return np.asarray(-self.frame[2])

    def clearance(self, position: Float64Array, radius: float = 0.0) -> Float64Array:
        """Return how far spheres of one radius are inside the region [m], shape (N,); negative is outside."""
        walls = self.walls
        gap: Float64Array = least_gap(
            np.ascontiguousarray(position), radius, walls.kind, walls.row, walls.map_origin, walls.map_size,
            walls.map_cells, walls.map_start, walls.map_item,
        )  # fmt: skip
        if self.sides is not None:
            gap[~self.sides.inside(position, walls)] = -np.inf
        return gap

    def holds(self, position: Float64Array) -> NDArray[np.bool_]:
        """Tell which centres are on the inner side of every mesh, shape (N,); gaps do not tell sides."""
        if self.sides is None:
            return np.ones(len(position), bool)
        return self.sides.inside(position, self.walls)

    def rectangle(self) -> tuple[Float64Array, Float64Array]:
        """Return lower and upper corner of the region's shadow along gravity, in u and v [m], each (2,)."""
        corners = np.array(
            [[x, y, z] for x in self.bounds[:, 0] for y in self.bounds[:, 1] for z in self.bounds[:, 2]]
        )
        shadow = components(corners, self.frame[:2])
        return shadow.min(axis=0), shadow.max(axis=0)

    def sample(
        self, rng: np.random.Generator, count: int, low: float, high: float, radius: float = 0.0
    ) -> Float64Array:
        """Return the points inside the region out of ``count`` uniform ones between two altitudes, (n, 3)."""
        least, most = self.rectangle()
        across = least + rng.random((count, 2)) * (most - least)
        up = low + rng.random((count, 1)) * (high - low)
        points = components(np.concatenate([across, up], axis=1), self.frame.T)
        return points[self.clearance(points, radius) >= 0.0]

    def area(self, altitude: float) -> float:
        """Return the region's horizontal area at an altitude [m2], to about 2 %."""
        least, most = self.rectangle()
        rng = np.random.default_rng(0)
        inside = self.sample(rng, SECTION_POINTS, altitude, altitude)
        return float(np.prod(most - least)) * max(len(inside), 1) / SECTION_POINTS

    def tube_width(self) -> float | None:
        """Return the diameter [m] of the cross-section halfway up, to about 1 %; None: it is not round."""
        altitude = 0.5 * (self.floor + self.ceiling)
        points = self.sample(np.random.default_rng(0), SECTION_POINTS, altitude, altitude)
        points = components(points, self.frame[:2])
        if len(points) == 0:
            return None
        least, most = self.rectangle()
        area = float(np.prod(most - least)) * len(points) / SECTION_POINTS
        farthest = float(np.linalg.norm(points - points.mean(axis=0), axis=1).max())
        return 2.0 * math.sqrt(area / math.pi) if math.pi * farthest**2 < ROUND_MAX * area else None


def gravity_frame(down: Float64Array) -> Float64Array:
    """Return unit vectors u, v and up as the rows of a rotation, shape (3, 3); up is ``-down``."""
    up = -np.asarray(down, float) / length(np.asarray(down, float))
    first = np.eye(3)[int(np.argmin(np.abs(up)))]
    u = first - (first * up).sum() * up
    u /= length(u)
    return np.stack([u, np.cross(up, u), up])


def make_region(
    container: Container,
    locations: Sequence[Shape | Slice],
    down: Float64Array,
    radius_max: float,
    place: str,
    radius_min: float | None = None,
) -> Region:
    """Return the region inside the container and all locations.

    Args:
        container: The vessel.
        locations: What else bounds the zone.
        down: Unit vector along which things fall, shape (3,).
        radius_max: Largest radius that will be placed [m].
        place: Where the scene names the zone, for messages.
        radius_min: Smallest radius that will be placed [m]; None: the largest.

    Returns:
        The region.

    Raises:
        PackingError: Location and container do not meet.
    """
    bounds = np.array(container.bounds)
    for location in locations:
        least, most = shape_bounds(location)
        bounds = np.stack([np.maximum(bounds[0], least), np.minimum(bounds[1], most)])
    if (bounds[0] >= bounds[1]).any():
        raise PackingError(f"{place}: the location lies outside the container; move it inside")
    frame = gravity_frame(down)
    seams = Seams.of(container)
    shapes = [container.shape, *locations, *_seam_planes(locations, seams)]
    walls = wall_table(shapes, bounds, radius_max, seams)
    corners = np.array([[x, y, z] for x in bounds[:, 0] for y in bounds[:, 1] for z in bounds[:, 2]])
    altitude = components(corners, frame[2])
    floor, ceiling = float(altitude.min()), float(altitude.max())
    for location in locations:
        if isinstance(location, Slice):
            along = float((location.axis * frame[2]).sum())
            if abs(along) > 0.999999:
                ends = sorted((location.low * along, location.high * along))
                floor, ceiling = max(floor, ends[0]), min(ceiling, ends[1])
    if floor >= ceiling:
        raise PackingError(f"{place}: the slice lies outside the container; move it inside")
    meshes = [each.surface for each in (container.shape, *locations) if isinstance(each, Mesh)]
    sides = InsideMap.over(meshes, bounds, radius_min or radius_max) if meshes else None
    return Region(walls, bounds, frame, floor, ceiling, sides)


def _seam_planes(locations: Sequence[Shape | Slice], seams: Seams) -> list[Slice]:
    """Return what keeps centres from wrapping around where a location ends: it does not wrap with them."""
    planes = []
    for axis in np.flatnonzero(seams.period):
        if any(np.isfinite([each[axis] for each in shape_bounds(location)]).any() for location in locations):
            low = float(seams.low[axis])
            planes.append(Slice(np.eye(3)[axis], low, low + float(seams.period[axis]), centers_only=True))
    return planes


def shape_bounds(shape: Shape | Slice) -> tuple[Float64Array, Float64Array]:
    """Return lower and upper corner of a shape's bounding box [m]; infinite where a slice leaves it open."""
    if isinstance(shape, Box):
        return shape.min, shape.max
    if isinstance(shape, Ball):
        return shape.center - shape.radius, shape.center + shape.radius
    if isinstance(shape, Cone):
        across = np.sqrt(np.maximum(1.0 - shape.axis**2, 0.0))
        top = shape.base + shape.height * shape.axis
        bottom_reach, top_reach = shape.radius_bottom * across, shape.radius_top * across
        return np.minimum(shape.base - bottom_reach, top - top_reach), np.maximum(
            shape.base + bottom_reach, top + top_reach
        )
    if isinstance(shape, Slice):
        least, most = np.full(3, -np.inf), np.full(3, np.inf)
        axis = int(np.argmax(np.abs(shape.axis)))
        if abs(shape.axis[axis]) > 0.999999:
            ends = sorted((shape.low * shape.axis[axis], shape.high * shape.axis[axis]))
            least[axis], most[axis] = ends
        return least, most
    vertices = shape.surface.vertices
    return vertices.min(axis=0), vertices.max(axis=0)


@dataclass(frozen=True, eq=False, slots=True)
class ColumnMap:
    """A grid of columns along gravity over a region's shadow.

    Attributes:
        frame: The region's frame, shape (3, 3).
        width: Column width along u and v [m], shape (2,); it divides a period.
        shape: Number of columns along u and v.
        corner: Lower corner of the grid in u and v [m], shape (2,).
        wraps: Whether the region wraps around along u and v.
    """

    frame: Float64Array
    width: Float64Array
    shape: tuple[int, int]
    corner: Float64Array
    wraps: tuple[bool, bool]

    @classmethod
    def over(cls, region: Region, width: float) -> ColumnMap:
        """Return columns of about this width [m] over a region; wider ones where they would be too many."""
        least, most = region.rectangle()
        width = max(width, float(np.sqrt(np.prod(most - least) / COLUMNS_MAX)))
        columns = np.maximum(np.ceil((most - least) / width), 1.0)
        # Down is across every periodic axis: each is one of the frame's own.
        wraps = (np.abs(region.frame[:2]) * (region.walls.seams.period > 0.0)).sum(axis=1) > 0.5
        # A narrow column at the seam would have fewer spheres, and a lower top, than all others.
        widths = np.where(wraps, (most - least) / columns, width)
        u, v = wraps.tolist()
        return cls(region.frame, widths, (int(columns[0]), int(columns[1])), least, (u, v))

    @property
    def count(self) -> int:
        """Number of columns."""
        return self.shape[0] * self.shape[1]

    def index(self, position: Float64Array) -> NDArray[np.int64]:
        """Return the column that each point lies in, flat, shape (N,)."""
        place = ((components(position, self.frame[:2]) - self.corner) / self.width).astype(np.int64)
        place = np.clip(place, 0, np.array(self.shape) - 1)
        return np.asarray(place[:, 0] * self.shape[1] + place[:, 1])

    def covers(self, position: Float64Array) -> NDArray[np.bool_]:
        """Tell which points lie in some column, shape (N,)."""
        place = (components(position, self.frame[:2]) - self.corner) / self.width
        inside = (place >= 0.0) & (place < np.array(self.shape))
        return np.asarray((inside | np.array(self.wraps)).all(axis=1))

    def tops(self, position: Float64Array, radius: Float64Array) -> Float64Array:
        """Return the altitude of the highest sphere of each column [m], -inf where there is none."""
        tops = np.full(self.count, -np.inf)
        np.maximum.at(tops, self.index(position), components(position, self.frame[2]) + radius)
        return tops

    def nearby(self, tops: Float64Array, reach: float, chosen: Callable[..., Float64Array]) -> Float64Array:
        """Return the lowest or highest top [m] among the columns within reach [m] of each column.

        Args:
            tops: Altitude of each column, shape (columns,).
            reach: How far to look across gravity.
            chosen: ``scipy.ndimage.minimum_filter`` or ``maximum_filter``.
        """
        sizes = [2 * math.ceil(reach / width) + 1 for width in self.width]
        modes = ["wrap" if wraps else "nearest" for wraps in self.wraps]
        return chosen(tops.reshape(self.shape), size=sizes, mode=modes).ravel()

    def points(self, altitude: Float64Array) -> Float64Array:
        """Return the middle of each column at its own altitude [m], shape (columns, 3)."""
        u, v = np.divmod(np.arange(self.count), self.shape[1])
        across = self.corner + self.width * (np.column_stack([u, v]) + 0.5)
        return components(np.column_stack([across, altitude]), self.frame.T)
