"""The channel that the fluid flows through: a cylinder or box with inlet and outlet, or the vessel as it is.

A cylinder or box is a tube: its ends are open, and lie the inlet and outlet lengths before and behind the
outermost spheres, so that a container that is shorter is extended, and one that is longer is cut. Any other
container is meshed as it is, closed. A box is the background mesh itself; the sides along which it wraps
around are patches. The facets of a cylinder lie on or just outside the true wall.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from exporters.resolved.triangles import distance_to_triangles
from exporters.walls.edges import edge_uses
from packgen.arrays import BoolArray, Float64Array, unique_rows
from packgen.bed import Bed
from packgen.errors import ExportError
from packgen.geometry import Box, Cone, Container
from packgen.geometry.winding import winding_numbers

INLET_DIAMETERS, OUTLET_DIAMETERS = 3.0, 6.0  # default lengths, in mean diameters
SEGMENTS_MIN, SEGMENTS_MAX = 24, 1440
SAME_RADIUS = 1.0e-9  # of a cylinder's ends, as a fraction


@dataclass(frozen=True, eq=False, slots=True)
class Channel:
    """The channel.

    Attributes:
        kind: What bounds it.
        container: The bed's container.
        up: Unit vector along the tube from the end that gravity points to, shape (3,); of a vessel unused.
        ends: Lower and upper end of the tube along ``up`` [m], from the origin of coordinates; of a vessel
            infinite.
        bed_ends: The same of the spheres.
        inlet_low: Whether the lower end is the inlet.
    """

    kind: Literal["box", "cylinder", "vessel"]
    container: Container
    up: Float64Array
    ends: tuple[float, float]
    bed_ends: tuple[float, float]
    inlet_low: bool

    @property
    def is_tube(self) -> bool:
        """Whether it has an inlet and an outlet."""
        return math.isfinite(self.ends[0])

    @property
    def bounds(self) -> Float64Array:
        """Lower and upper corner of a box around it [m], shape (2, 3)."""
        if self.kind == "cylinder" and self.is_tube:
            axis_point, radius = cylinder_of(self.container)
            across = radius * np.sqrt(np.maximum(1.0 - self.up**2, 0.0))
            middle = [axis_point + (end - axis_point @ self.up) * self.up for end in self.ends]
            return np.stack([np.min(middle, axis=0) - across, np.max(middle, axis=0) + across])
        bounds = np.array(self.container.bounds)
        if self.kind == "box" and self.is_tube:
            axis = int(np.argmax(np.abs(self.up)))
            bounds[:, axis] = np.sort(np.array(self.ends) * self.up[axis])
        return bounds

    @property
    def bed_volume(self) -> float:
        """Volume of the part of the tube between the outermost spheres' ends, or of the vessel [m3]."""
        if not self.is_tube:
            return self.container.volume
        return self.section * (self.bed_ends[1] - self.bed_ends[0])

    @property
    def section(self) -> float:
        """Area across a tube [m2]."""
        if self.kind == "cylinder":
            return math.pi * cylinder_of(self.container)[1] ** 2
        size = self.container.bounds[1] - self.container.bounds[0]
        return float(np.prod(np.delete(size, int(np.argmax(np.abs(self.up))))))

    def clearance(self, point: Float64Array) -> Float64Array:
        """Return the distance of points (M, 3) from walls and ends [m], shape (M,); negative outside.

        Sides along which a box wraps around count as walls.
        """
        if self.kind == "vessel":
            corners = self.container.surface.vertices[self.container.surface.faces]
            distance = distance_to_triangles(point, corners)
            return np.where(self.contains(point), distance, -distance)
        if self.kind == "box":
            low, high = self.bounds
            return np.asarray(np.minimum(point - low, high - point).min(axis=1))
        along = point @ self.up
        ends = np.minimum(along - self.ends[0], self.ends[1] - along)
        return np.minimum(ends, self.wall_distance(point))

    def contains(self, point: Float64Array) -> BoolArray:
        """Return which points (M, 3) are inside, shape (M,)."""
        if self.kind != "vessel":
            return np.asarray(self.clearance(point) > 0.0)
        corners = self.container.surface.vertices[self.container.surface.faces].reshape(-1, 9)
        return np.asarray(np.abs(winding_numbers(corners, np.ascontiguousarray(point))) > 0.5)

    def wall_distance(self, point: Float64Array) -> Float64Array:
        """Return the distance of points (M, 3) from a cylinder's wall [m], shape (M,)."""
        axis_point, radius = cylinder_of(self.container)
        apart = point - axis_point
        across = apart - (apart @ self.up)[:, None] * self.up
        return np.asarray(radius - np.linalg.norm(across, axis=1))


def cylinder_of(container: Container) -> tuple[Float64Array, float]:
    """Return a point of a cylinder's axis [m], shape (3,), and its radius [m]."""
    assert isinstance(container.shape, Cone)
    return container.shape.base, container.shape.radius_bottom


def kind_of(container: Container) -> Literal["box", "cylinder", "vessel"]:
    """Return what kind of channel a container is."""
    shape = container.shape
    if isinstance(shape, Box):
        return "box"
    if isinstance(shape, Cone) and abs(shape.radius_top - shape.radius_bottom) <= SAME_RADIUS * max(
        shape.radius_top, shape.radius_bottom
    ):
        return "cylinder"
    return "vessel"


def tube_direction(container: Container, down: Float64Array, axis: str | None) -> Float64Array | None:
    """Return the unit vector along a tube from its lower end (3,), or None where it is none.

    Args:
        container: The container.
        down: Unit vector of gravity, shape (3,).
        axis: What the user wants of a box, ``x``, ``y`` or ``z``; None: the one along gravity.

    Raises:
        ExportError: A cylinder or a vessel is asked for another axis, or the box wraps around along it.
    """
    kind = kind_of(container)
    if kind == "vessel" or (kind == "cylinder" and axis is not None):
        if axis is None:
            return None
        raise ExportError(f"surface: axis={axis} is of a box, the container is none; leave surface.axis out")
    if kind == "cylinder":
        assert isinstance(container.shape, Cone)
        along = container.shape.axis
    else:
        index = int(np.argmax(np.abs(down))) if axis is None else "xyz".index(axis)
        if container.periodic[index]:
            if axis is None:
                return None
            raise ExportError(f"surface: the box wraps around along {axis}; choose another surface.axis")
        along = np.eye(3)[index]
    return np.asarray(-along if along @ down > 1e-12 else along)


def check_lengths(
    container: Container, down: Float64Array, axis: str | None, lengths: tuple[float | None, float | None]
) -> None:
    """Refuse inlet and outlet lengths of a container that is no tube.

    Raises:
        ExportError: It is none, or `tube_direction` refuses the axis.
    """
    if tube_direction(container, down, axis) is None and lengths != (None, None):
        raise ExportError(
            "surface: inlet_length and outlet_length are of a cylinder, or of a box that does not wrap "
            f"around along the flow; {container.name} is meshed as it is, leave them out"
        )


def check_closed(container: Container) -> None:
    """Refuse a vessel whose surface is open: the fluid's mesh would leak out of it.

    Raises:
        ExportError: It is.
    """
    _, index = unique_rows(container.surface.vertices)
    count = int((edge_uses(index[container.surface.faces]) == 1).sum())
    if kind_of(container) == "vessel" and count:
        raise ExportError(
            f"surface: the walls of {container.name} have {count} open edges, expected a closed surface: a "
            "mesh of the fluid would leak out of it; close the container's mesh"
        )


def make_channel(
    bed: Bed, axis: str | None, lengths: tuple[float | None, float | None], *, inlet_low: bool
) -> Channel:
    """Return the channel of a bed.

    Args:
        bed: The bed.
        axis: Axis of the flow through a box; None: the one along gravity.
        lengths: Inlet and outlet length [m]; None: a default.
        inlet_low: Whether the inlet is at the lower end.

    Raises:
        ExportError: The container has no ends, and lengths or an axis are given, or its surface is open.
    """
    check_lengths(bed.container, bed.down, axis, lengths)
    check_closed(bed.container)
    kind = kind_of(bed.container)
    up = tube_direction(bed.container, bed.down, axis)
    if up is None:
        none = (-math.inf, math.inf)
        return Channel(kind, bed.container, -bed.down, none, none, inlet_low)
    along = bed.position @ up
    low, high = float((along - bed.radius).min()), float((along + bed.radius).max())
    diameter = 2 * float(bed.radius.mean())
    defaults = (INLET_DIAMETERS * diameter, OUTLET_DIAMETERS * diameter)
    before, behind = (own if given is None else given for given, own in zip(lengths, defaults, strict=True))
    first, last = (before, behind) if inlet_low else (behind, before)
    return Channel(kind, bed.container, up, (low - first, high + last), (low, high), inlet_low)


def wall_solids(channel: Channel, error: float) -> dict[str, Float64Array]:
    """Return the triangles of the walls by their names, shapes (F, 3, 3); none of a box.

    Args:
        channel: The channel.
        error: How far the facets of a cylinder may be from the true wall [m].
    """
    if channel.kind == "box":
        return {}
    if channel.kind == "vessel":
        surface = channel.container.surface
        return {"wall": surface.vertices[surface.faces]}
    axis_point, radius = cylinder_of(channel.container)
    count = segments(radius, error)
    first = np.cross(channel.up, np.eye(3)[int(np.argmin(np.abs(channel.up)))])
    first /= np.linalg.norm(first)
    second = np.cross(channel.up, first)
    angle = 2.0 * math.pi * np.arange(count) / count
    ring = np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * second
    ring *= radius / math.cos(math.pi / count)
    middle = [axis_point + (end - axis_point @ channel.up) * channel.up for end in channel.ends]
    low, high = middle[0] + ring, middle[1] + ring
    low_next, high_next = np.roll(low, -1, axis=0), np.roll(high, -1, axis=0)
    sides = np.concatenate(
        [np.stack([low, low_next, high_next], axis=1), np.stack([low, high_next, high], axis=1)]
    )
    bottom = np.stack([np.broadcast_to(middle[0], low.shape), low_next, low], axis=1)
    top = np.stack([np.broadcast_to(middle[1], high.shape), high, high_next], axis=1)
    inlet, outlet = (bottom, top) if channel.inlet_low else (top, bottom)
    return {"wall": sides, "inlet": inlet, "outlet": outlet}


def segments(radius: float, error: float) -> int:
    """Return how many sides a polygon around a circle has whose middle lies within ``error`` of it [m]."""
    share = min(max(error / radius, 0.0), 0.5)
    count = math.ceil(math.pi / math.acos(1.0 / (1.0 + share))) if share > 0.0 else SEGMENTS_MAX
    return min(max(count, SEGMENTS_MIN), SEGMENTS_MAX)
