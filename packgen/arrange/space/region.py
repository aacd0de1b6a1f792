"""The space that one zone's spheres live in: container and location together, seen along gravity."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from packgen.arrange.space.feature_kernels import CENTER_PLANE, Features
from packgen.arrange.space.map_kernels import least_gap
from packgen.arrange.space.seams import Seams
from packgen.arrange.space.sides import InsideMap
from packgen.arrange.space.walls import WallTable, wall_table
from packgen.arrays import Float64Array
from packgen.errors import PackingError
from packgen.geometry import Container, Mesh, Shape, Slice
from packgen.geometry.bounds import altitude_range, gravity_frame, shape_bounds
from packgen.portable import components

SECTION_POINTS = 4096
"""Points that measure a cross-section."""

FLAT_SHARE = 0.5
"""A shape that lies askew to its bounding box and fills less than this share of the box's height along
gravity is flat: layers below and above it would look for room in vain."""

ROUND_MAX = 1.1
"""Largest area of the circle around a round section, over the section's: 1.05 for a dodecagon, 1.21 for a
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
        gap: Float64Array = least_gap(np.ascontiguousarray(position), radius, walls.features, walls.near)
        if self.sides is not None:
            gap[~self.sides.inside(position, walls)] = -np.inf
        return gap

    def holds(self, position: Float64Array) -> NDArray[np.bool_]:
        """Tell which centres are on the inner side of every mesh, shape (N,); gaps do not tell sides."""
        if self.sides is None:
            return np.ones(len(position), bool)
        return self.sides.inside(position, self.walls)

    def contains(self, position: Float64Array, radius: Float64Array) -> NDArray[np.bool_]:
        """Tell which spheres are in the region however far they stick out of it, shape (N,).

        Their centres are on the inner side of every wall. Of those that a slice bounds by their centres, some
        part is in the slice.

        Args:
            position: Centres [m], shape (N, 3).
            radius: Radii [m], shape (N,).
        """
        return self._within(position, np.zeros(len(radius)), radius)

    def encloses(self, position: Float64Array, radius: Float64Array, slack: float) -> NDArray[np.bool_]:
        """Tell which spheres are in the region as a zone's own are, shape (N,).

        Args:
            position: Centres [m], shape (N, 3).
            radius: Radii [m], shape (N,).
            slack: How far a sphere may stick out of a wall, in its radii.
        """
        return self._within(position, (1.0 - slack) * radius, np.zeros(len(radius)))

    def _within(self, position: Float64Array, inner: Float64Array, outer: Float64Array) -> NDArray[np.bool_]:
        """Tell which centres are at least ``inner`` [m] off walls and ``outer`` at most beyond slices."""
        kind, row = self.walls.features
        sheet = kind == CENTER_PLANE
        inside = self.holds(position)
        if sheet.any():
            beyond = components(position, row[sheet, :3]) - row[sheet, 3]
            inside &= (beyond <= outer[:, None]).all(axis=1)
            row = row.copy()
            row[sheet, 3] = np.inf
        gap = least_gap(np.ascontiguousarray(position), 0.0, Features(kind, row), self.walls.near)
        return np.asarray(inside & (gap >= inner))

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
    for shape in (container.shape, *locations):
        low, high = altitude_range(shape, frame[2])
        if high - low < FLAT_SHARE * (ceiling - floor):
            floor, ceiling = max(floor, low), min(ceiling, high)
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
    """Return what keeps centres from wrapping around where a location ends: it does not wrap with them.

    A centre on a periodic side is on both. It is written at the lower one, where solvers want it.
    """
    planes = []
    for axis in np.flatnonzero(seams.period):
        if any(np.isfinite([each[axis] for each in shape_bounds(location)]).any() for location in locations):
            low = float(seams.low[axis])
            planes.append(Slice(np.eye(3)[axis], low, low + float(seams.period[axis]), centers_only=True))
    return planes
