"""A container and its zones as cells of a grid that stands along gravity: how far they will be filled.

A cell belongs to the container where its centre does. What a zone takes, it takes from below, layer by layer;
the last layer in part. Layers end where slices do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from packgen.arrays import Float64Array
from packgen.filling.room import Locations, within
from packgen.geometry import Container, Mesh, Polyhedron, Shape, Slice
from packgen.geometry.bounds import altitude_range, gravity_frame

__all__ = ["Cells", "Taken"]

CELLS, CELLS_SLOW = 60_000, 10_000  # of the box around a container; fewer where shapes have many facets
MANY_FACETS = 100
LEAST, LAYERS = 8, 64  # cells along each side, and layers along gravity, at least
CHUNK = 10_000  # cells that are looked at together
SAME = 1.0e-6  # of the height: ends of layers nearer than that are one


@dataclass(frozen=True, slots=True)
class Taken:
    """What a zone takes of its part of the container.

    Attributes:
        room: Volume of the part that was free [m3].
        volume: Volume that it takes of it [m3].
        bottom: Altitude of the part's lower end [m].
        top: Altitude up to which it is filled [m].
        area: Mean cross-section of the part [m2].
    """

    room: float
    volume: float
    bottom: float
    top: float
    area: float


class Cells:
    """The cells of a container, and what is free of each.

    Attributes:
        inside: Whether a cell belongs to the container, shape (nu, nv, nz).
        free: Share of each cell that is free, shape (nu, nv, nz), float64; 0 outside.
        zone: Zone that fills a cell for the most part, -1 for none, shape (nu, nv, nz), int32.
        height: Height of each layer [m], shape (nz,).
    """

    def __init__(
        self, container: Container, down: Float64Array, locations: Sequence[tuple[Locations, float]]
    ) -> None:
        """Divide a container.

        Args:
            container: The container.
            down: Unit vector of gravity, or any without it, shape (3,).
            locations: What bounds each zone beside the container, and how far its spheres reach beyond a
                slice that bounds their centres [m].
        """
        frame = gravity_frame(down)
        self._up = frame[2]
        turned = np.array(list(product(*container.bounds.T))) @ frame.T
        start, extent = turned.min(axis=0), np.ptp(turned, axis=0)
        shapes = [container.shape, *(shape for own, _ in locations for shape in own)]
        most = CELLS_SLOW if any(_is_slow(each) for each in shapes) else CELLS
        size = float(np.cbrt(np.prod(extent) / most))
        count = np.maximum(np.ceil(extent / size).astype(int), [LEAST, LEAST, LAYERS])
        axes = [start[axis] + extent[axis] * (np.arange(count[axis]) + 0.5) / count[axis] for axis in (0, 1)]
        self._edge = self._edges(np.linspace(start[2], start[2] + extent[2], count[2] + 1), locations)
        self.height = np.diff(self._edge)
        axes.append(0.5 * (self._edge[1:] + self._edge[:-1]))
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
        self._points = grid.reshape(-1, 3) @ frame
        self.inside = self._belonging(container.shape, np.ones(grid.shape[:3], dtype=bool))
        self.free = self.inside.astype(np.float64)
        self.zone = np.full(self.inside.shape, -1, np.int32)
        # So that they fill the container exactly.
        whole = float((self.inside.sum(axis=(0, 1)) * self.height).sum())
        self._volume = self.height * (container.volume / max(whole, 1e-300))

    def _edges(self, regular: Float64Array, locations: Sequence[tuple[Locations, float]]) -> Float64Array:
        """Return the ends of the layers [m]: regular ones, and those of the zones."""
        ends = [
            end
            for own, reach in locations
            for shape in own
            for end in self._ends(shape, reach)
            if regular[0] < end < regular[-1]
        ]
        edges = np.unique(np.concatenate([regular, ends]))
        kept = np.diff(edges, prepend=-np.inf) > SAME * (regular[-1] - regular[0])
        return np.asarray(edges[kept])

    def _ends(self, shape: Shape | Slice, reach: float) -> tuple[float, float]:
        """Return the altitudes of a shape's ends [m]; infinite where it has none."""
        if not isinstance(shape, Slice):
            return altitude_range(shape, self._up)
        along = float(shape.axis @ self._up)
        if abs(along) < 0.999999:
            return -np.inf, np.inf
        more = reach if shape.centers_only else 0.0
        low, high = sorted((shape.low * along, shape.high * along))
        return low - more, high + more

    def _belonging(self, shape: Shape | Slice, among: np.ndarray) -> np.ndarray:
        """Return which of some cells, shape (nu, nv, nz), belong to a shape."""
        found = np.zeros(among.size, dtype=bool)
        asked = np.flatnonzero(among)
        # A mesh is prepared anew each time; planes are held for all cells at once.
        step = max(len(asked), 1) if isinstance(shape, Mesh) else CHUNK
        for first in range(0, len(asked), step):
            chunk = asked[first : first + step]
            found[chunk] = within(shape, self._points[chunk])
        return found.reshape(among.shape)

    def within(self, own: Locations, reach: float) -> np.ndarray:
        """Return which cells belong to a zone, shape (nu, nv, nz).

        Args:
            own: What bounds it beside the container.
            reach: How far its spheres reach beyond a slice that bounds their centres [m].
        """
        chosen = self.inside
        for shape in own:
            wide = shape
            if isinstance(shape, Slice) and shape.centers_only:
                wide = Slice(shape.axis, shape.low - reach, shape.high + reach, centers_only=True)
            chosen = self._belonging(wide, chosen)
        return chosen

    def below(self, altitude: float) -> np.ndarray:
        """Return which cells of the container are below an altitude [m], shape (nu, nv, nz)."""
        return np.asarray(self.inside & (self._edge[:-1] < altitude))

    def take(self, index: int, part: np.ndarray, wanted: float | None, *, mark: bool = True) -> Taken:
        """Fill a part of the container from below.

        Args:
            index: The zone.
            part: Its cells, shape (nu, nv, nz).
            wanted: Volume to take [m3]; None: all that is free.
            mark: Whether it is taken; else it is only looked at.

        Returns:
            What it takes.
        """
        free = np.where(part, self.free, 0.0)
        layer = free.sum(axis=(0, 1)) * self._volume
        room = float(layer.sum())
        volume = room if wanted is None else min(wanted, room)
        used = np.flatnonzero(layer > 0.0)
        if len(used) == 0:
            return Taken(0.0, 0.0, float(self._edge[0]), float(self._edge[0]), 0.0)
        below = np.concatenate([[0.0], np.cumsum(layer)])
        share = np.clip((volume - below[:-1]) / np.where(layer > 0.0, layer, 1.0), 0.0, 1.0)
        last = int(np.flatnonzero((share > 0.0) & (layer > 0.0)).max(initial=used[0]))
        bottom, end = float(self._edge[used[0]]), float(self._edge[used[-1] + 1])
        top = float(self._edge[last] + self.height[last] * share[last])
        if mark:
            taken = free * share
            self.free = np.where(taken > (1.0 - 1e-9) * self.free, 0.0, self.free - taken)
            self.zone[(taken > 0.0) & (self.free < 0.5)] = index
        return Taken(room, volume, bottom, top, room / (end - bottom))


def _is_slow(shape: Shape | Slice) -> bool:
    """Return whether it takes long to tell what is within a shape."""
    return isinstance(shape, Mesh) or (isinstance(shape, Polyhedron) and len(shape.normal) > MANY_FACETS)
