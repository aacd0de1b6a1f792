"""Bodies with an inside: containers and locations as the judge sees them, in closed form or by force."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

Array = NDArray[np.float64]
BLOCK = 150_000  # pairs of a point and a triangle that are held at a time
FLAT = 1e-5  # of a volume, what float32 bends in a mesh


class Solid(Protocol):
    """What container and location have in common."""

    @property
    def bounds(self) -> Array:
        """Lower and upper corner [m], shape (2, 3)."""

    def clearance(self, point: Array) -> Array:
        """Return how far points (N, 3) are inside [m], negative outside, shape (N,)."""

    def moved(self, scale: float, shift: Array) -> Any:
        """Return the body made larger about the origin and then shifted [m]."""


@dataclass(frozen=True)
class Box:
    """A box along the axes; it has no walls across the axes along which it is periodic."""

    low: Array
    high: Array
    periodic: tuple[bool, bool, bool] = (False, False, False)

    @property
    def bounds(self) -> Array:
        return np.stack([self.low, self.high])

    @property
    def volume(self) -> float:
        return float(np.prod(self.high - self.low))

    def clearance(self, point: Array) -> Array:
        gap = np.minimum(point - self.low, self.high - point)
        return np.where(self.periodic, np.inf, gap).min(axis=1)

    def moved(self, scale: float, shift: Array) -> Box:
        return replace(self, low=scale * self.low + shift, high=scale * self.high + shift)

    def spec(self) -> dict[str, Any]:
        return {"box": {"min": self.low.tolist(), "max": self.high.tolist()}}


@dataclass(frozen=True)
class Cone:
    """A cone, truncated or not; a cylinder where both radii are the same."""

    base: Array
    axis: Array
    height: float
    bottom: float
    top: float

    @property
    def bounds(self) -> Array:
        across = np.sqrt(np.maximum(1.0 - self.axis**2, 0.0))
        ends = np.stack([self.base, self.base + self.height * self.axis])
        reach = np.array([self.bottom, self.top])[:, None] * across
        return np.stack([(ends - reach).min(axis=0), (ends + reach).max(axis=0)])

    @property
    def volume(self) -> float:
        return np.pi / 3.0 * self.height * (self.bottom**2 + self.bottom * self.top + self.top**2)

    def clearance(self, point: Array) -> Array:
        along = (point - self.base) @ self.axis
        across = np.linalg.norm(np.cross(point - self.base, self.axis), axis=1)
        slope = np.arctan2(self.top - self.bottom, self.height)
        side = (self.bottom - across) * np.cos(slope) + along * np.sin(slope)
        return np.minimum(side, np.minimum(along, self.height - along))

    def moved(self, scale: float, shift: Array) -> Cone:
        return Cone(
            scale * self.base + shift, self.axis, scale * self.height, scale * self.bottom, scale * self.top
        )

    def spec(self) -> dict[str, Any]:
        place = {"height": self.height, "base": self.base.tolist(), "axis": self.axis.tolist()}
        if self.bottom == self.top:
            return {"cylinder": {"radius": self.bottom, **place}}
        return {"cone": {"radius_bottom": self.bottom, "radius_top": self.top, **place}}


@dataclass(frozen=True)
class Ball:
    """The inside of a sphere."""

    center: Array
    radius: float

    @property
    def bounds(self) -> Array:
        return np.stack([self.center - self.radius, self.center + self.radius])

    @property
    def volume(self) -> float:
        return 4.0 / 3.0 * np.pi * self.radius**3

    def clearance(self, point: Array) -> Array:
        return self.radius - np.linalg.norm(point - self.center, axis=1)

    def moved(self, scale: float, shift: Array) -> Ball:
        return Ball(scale * self.center + shift, scale * self.radius)

    def spec(self) -> dict[str, Any]:
        return {"sphere": {"radius": self.radius, "center": self.center.tolist()}}


@dataclass(frozen=True)
class Slab:
    """What is between two planes across an axis."""

    axis: int
    low: float
    high: float

    @property
    def bounds(self) -> Array:
        bounds = np.array([[-np.inf] * 3, [np.inf] * 3])
        bounds[:, self.axis] = self.low, self.high
        return bounds

    def clearance(self, point: Array) -> Array:
        return np.minimum(point[:, self.axis] - self.low, self.high - point[:, self.axis])

    def moved(self, scale: float, shift: Array) -> Slab:
        return Slab(self.axis, *(scale * each + float(shift[self.axis]) for each in (self.low, self.high)))

    def spec(self) -> dict[str, Any]:
        return {"slice": {"axis": "xyz"[self.axis], "min_bound": self.low, "max_bound": self.high}}


@dataclass(frozen=True)
class Hull:
    """The convex hull of points."""

    vertices: Array

    @property
    def bounds(self) -> Array:
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def volume(self) -> float:
        return float(ConvexHull(self.vertices).volume)

    def clearance(self, point: Array) -> Array:
        plane = ConvexHull(self.vertices).equations
        return -(point @ plane[:, :3].T + plane[:, 3]).max(axis=1)

    def moved(self, scale: float, shift: Array) -> Hull:
        return Hull(scale * self.vertices + shift)


@dataclass(frozen=True)
class Solidmesh:
    """A closed surface; its triangles face outward, and an open-topped file leaves those of ``lid`` out."""

    vertices: Array
    faces: NDArray[np.int64]
    lid: NDArray[np.bool_]

    @property
    def bounds(self) -> Array:
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def volume(self) -> float:
        a, b, c = self._relative(self.vertices.mean(axis=0))
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0)

    @property
    def is_convex(self) -> bool:
        """Whether it fills its convex hull, but for the rounding of a file's numbers."""
        return float(ConvexHull(self.vertices).volume) < (1.0 + FLAT) * self.volume

    def _relative(self, origin: Array) -> tuple[Array, Array, Array]:
        a, b, c = (self.vertices[self.faces[:, corner]] - origin for corner in range(3))
        return a, b, c

    def clearance(self, point: Array) -> Array:
        result = np.empty(len(point))
        step = max(1, BLOCK // len(self.faces))
        for start in range(0, len(point), step):
            some = point[start : start + step]
            distance = self._distance(some)
            result[start : start + step] = np.where(self._winding(some) > 0.5, distance, -distance)
        return result

    def _winding(self, point: Array) -> Array:
        """Times that the surface goes round each point: the solid angles of its triangles over the whole."""
        a, b, c = (self.vertices[self.faces[:, corner]][None] - point[:, None, :] for corner in range(3))
        la, lb, lc = (np.sqrt((each**2).sum(axis=-1)) for each in (a, b, c))
        above = (a * np.cross(b, c)).sum(axis=-1)
        below = la * lb * lc + (a * b).sum(-1) * lc + (b * c).sum(-1) * la + (c * a).sum(-1) * lb
        return np.arctan2(above, below).sum(axis=1) / (2.0 * np.pi)

    def _distance(self, point: Array) -> Array:
        """Distance to the nearest triangle: to the plane above a triangle, to its edges elsewhere."""
        best = np.full(len(point), np.inf)
        corner = [self.vertices[self.faces[:, index]] for index in range(3)]
        normal = np.cross(corner[1] - corner[0], corner[2] - corner[0])
        unit = normal / np.linalg.norm(normal, axis=1)[:, None]
        above = np.ones((len(point), len(self.faces)), bool)
        for index in range(3):
            start, edge = corner[index], corner[(index + 1) % 3] - corner[index]
            relative = point[:, None, :] - start[None]
            above &= (relative * np.cross(unit, edge)[None]).sum(-1) >= 0.0
            part = np.clip((relative * edge).sum(-1) / (edge**2).sum(-1), 0.0, 1.0)
            rest = relative - part[..., None] * edge
            best = np.minimum(best, np.sqrt((rest**2).sum(-1)).min(axis=1))
        height = np.abs(((point[:, None, :] - corner[0][None]) * unit).sum(-1))
        return np.minimum(best, np.where(above, height, np.inf).min(axis=1))

    def moved(self, scale: float, shift: Array) -> Solidmesh:
        return replace(self, vertices=scale * self.vertices + shift)
