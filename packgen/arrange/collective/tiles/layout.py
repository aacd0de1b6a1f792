"""Where the tiles are: which columns each covers in a layer, whose work each stands on, and in what order.

A vessel is divided across gravity by its width and the spheres' alone: into stripes, a wide one into tiles.
A unit is one layer of one tile. It moves spheres in its tile and its halo, the columns around it, so that
tiles side by side take turns: by colour, two of stripes, four of tiles. In odd layers the seams are moved, or
they would stand on each other.

The columns are cut where a tile or a halo begins or ends in any layer. The pieces, blocks, are what units
hand on: the block in the middle of a tile is always that tile's own, the others are strips as wide as a halo.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product
from typing import NamedTuple

import numpy as np

from packgen.arrange.space.columns import ColumnMap
from packgen.arrays import Float64Array, Int64Array

HALO = 5.0
"""Width of a halo, in largest diameters: spheres roll four of them down the side of a layer."""

TILE_AUTO, TILES_AUTO = (30.0, 60.0), 4
"""Least and largest width of a tile that the vessel chooses, and how many it would be wide."""

STRIPES_MAX = 7
"""Most tiles along the longest side of a vessel that is divided across that side alone: stripes have fewer
seams, and half as many processes as stripes find work."""


class Unit(NamedTuple):
    """The work on one layer of one tile.

    Attributes:
        layer: Number of the layer, from 0 on.
        u: Place of the tile along u.
        v: Place along v.
    """

    layer: int
    u: int
    v: int


class Block(NamedTuple):
    """The columns between neighbouring cuts along u and v."""

    u: int
    v: int


class Span(NamedTuple):
    """Columns along one axis, from ``begin`` to before ``end``."""

    begin: int
    end: int


@dataclass(frozen=True, eq=False)
class TileLayout:
    """The tiles of a region.

    Attributes:
        columns: Columns over the region.
        halo: Width of a halo, in columns.
        edges: Where tiles meet on average, with both ends, along u and v, in columns.
        width_min: Least width of a tile [m].
    """

    columns: ColumnMap
    halo: int
    edges: tuple[tuple[int, ...], tuple[int, ...]]
    width_min: float

    @classmethod
    def over(cls, columns: ColumnMap, tile: float | None, diameter: float) -> TileLayout:
        """Divide columns into tiles.

        Args:
            columns: Columns over a region.
            tile: Least width of a tile, in largest diameters; None: chosen by the region's width.
            diameter: Largest diameter [m].
        """
        widths = (columns.width / diameter).tolist()
        longest = max(count * width for count, width in zip(columns.shape, widths, strict=True))
        if tile is None:
            tile = min(max(longest / TILES_AUTO, TILE_AUTO[0]), TILE_AUTO[1])
        halo = math.ceil(HALO / min(widths) - 1e-9)
        # Halos of both sides of a tile are apart, in odd and in even layers.
        least = [max(math.floor(tile / width + 1e-9), 4 * halo) for width in widths]
        numbers = [max(count // each, 1) for count, each in zip(columns.shape, least, strict=True)]
        if max(numbers) <= STRIPES_MAX:
            across = numbers.index(max(numbers))
            numbers = [number if axis == across else 1 for axis, number in enumerate(numbers)]
        edges = [
            tuple(count * place // number for place in range(number + 1))
            for count, number in zip(columns.shape, numbers, strict=True)
        ]
        return cls(columns, halo, (edges[0], edges[1]), float((columns.width * least).min()))

    @property
    def shape(self) -> tuple[int, int]:
        """Number of tiles along u and v."""
        return len(self.edges[0]) - 1, len(self.edges[1]) - 1

    @property
    def tiles(self) -> list[tuple[int, int]]:
        """Places of all tiles."""
        return list(product(range(self.shape[0]), range(self.shape[1])))

    @cached_property
    def cuts(self) -> tuple[tuple[int, ...], tuple[int, ...]]:
        """Where blocks meet, with both ends, along u and v, in columns."""
        both = []
        for edges in self.edges:
            inner = {edge + step * self.halo for edge in edges[1:-1] for step in range(-2, 3)}
            both.append(tuple(sorted(inner | {edges[0], edges[-1]})))
        return both[0], both[1]

    @property
    def all_blocks(self) -> list[Block]:
        """All blocks, in their order."""
        u, v = (range(len(cuts) - 1) for cuts in self.cuts)
        return [Block(*place) for place in product(u, v)]

    def order(self, layer: int) -> list[Unit]:
        """Return the units of a layer in their order."""
        return sorted((Unit(layer, *place) for place in self.tiles), key=self.rank)

    def rank(self, unit: Unit) -> tuple[int, int, int]:
        """Return what orders the units of a layer: colour, then place; colours take turns to be first."""
        colour = unit.u % 2 + 2 * (unit.v % 2)
        return (3 - colour if unit.layer // 2 % 2 else colour), unit.u, unit.v

    def tile(self, unit: Unit) -> tuple[Span, Span]:
        """Return the columns that are a unit's own, along u and v."""
        return self._tile(unit.layer, unit.u, 0), self._tile(unit.layer, unit.v, 1)

    def window(self, unit: Unit) -> tuple[Span, Span]:
        """Return the columns that a unit works in, along u and v: its tile and the halo."""
        return self._window(unit.layer, unit.u, 0), self._window(unit.layer, unit.v, 1)

    def _tile(self, layer: int, place: int, axis: int) -> Span:
        edges, shift = self.edges[axis], self.halo if layer % 2 else -self.halo
        last = len(edges) - 1
        begin = edges[place] + (shift if place > 0 else 0)
        return Span(begin, edges[place + 1] + (shift if place + 1 < last else 0))

    def _window(self, layer: int, place: int, axis: int) -> Span:
        begin, end = self._tile(layer, place, axis)
        return Span(max(begin - self.halo, 0), min(end + self.halo, self.edges[axis][-1]))

    def span(self, block: Block) -> tuple[Span, Span]:
        """Return the columns of a block, along u and v."""
        u, v = self.cuts
        return Span(u[block.u], u[block.u + 1]), Span(v[block.v], v[block.v + 1])

    def blocks(self, unit: Unit) -> list[Block]:
        """Return the blocks that a unit works in."""
        pieces = []
        for cuts, (begin, end) in zip(self.cuts, self.window(unit), strict=True):
            pieces.append(range(cuts.index(begin), cuts.index(end)))
        return [Block(u, v) for u, v in product(*pieces)]

    def flat(self, block: Block) -> int:
        """Return the number of a block among all."""
        return block.u * (len(self.cuts[1]) - 1) + block.v

    def block_index(self, position: Float64Array) -> Int64Array:
        """Return the number of the block that each point lies in, (N,)."""
        place = np.divmod(self.columns.index(position), self.columns.shape[1])
        u, v = (np.searchsorted(cuts, each, "right") - 1 for cuts, each in zip(self.cuts, place, strict=True))
        return np.asarray(u * (len(self.cuts[1]) - 1) + v)

    def sources(self, unit: Unit) -> dict[Unit, list[Block]]:
        """Return which units had a unit's blocks last, and which of them; nothing for the first units.

        The tile's own unit of the layer below is always there, as it hands on its spheres to come.
        """
        found: dict[Unit, list[Block]] = {}
        if unit.layer > 0:
            found[unit._replace(layer=unit.layer - 1)] = []
        for block in self.blocks(unit):
            last = self.last(block, unit)
            if last is not None:
                found.setdefault(last, []).append(block)
        return found

    def last(self, block: Block, before: Unit) -> Unit | None:
        """Return the last unit before another one that worked in a block; None: none did."""
        same = [each for each in self._workers(block, before.layer) if self._comes_before(each, before)]
        if same:
            return max(same, key=self.rank)
        return self.last_of(block, before.layer - 1) if before.layer else None

    def last_of(self, block: Block, layer: int) -> Unit:
        """Return the last unit of a layer that worked in a block; one did in each layer."""
        return max(self._workers(block, layer), key=self.rank)

    def _comes_before(self, unit: Unit, other: Unit) -> bool:
        return self.rank(unit) < self.rank(other)

    def _workers(self, block: Block, layer: int) -> Iterator[Unit]:
        """Return the units of a layer that work in a block."""
        u, v = self._at_work[layer % 2]
        return (Unit(layer, *place) for place in product(u[block.u], v[block.v]))

    @cached_property
    def _at_work(self) -> list[list[list[list[int]]]]:
        """Which places of tiles work in each piece of an axis: by odd and even layers, axis, and piece."""
        return [[self._places(layer, axis) for axis in (0, 1)] for layer in (0, 1)]

    def _places(self, layer: int, axis: int) -> list[list[int]]:
        cuts, windows = self.cuts[axis], [self._window(layer, each, axis) for each in range(self.shape[axis])]
        return [
            [place for place, (low, high) in enumerate(windows) if low <= begin and end <= high]
            for begin, end in pairwise(cuts)
        ]

    def earlier_neighbors(self, unit: Unit) -> list[Unit]:
        """Return the units of tiles beside a unit's that come before it in its layer."""
        around = product((unit.u - 1, unit.u, unit.u + 1), (unit.v - 1, unit.v, unit.v + 1))
        inside = [
            Unit(unit.layer, u, v) for u, v in around if 0 <= u < self.shape[0] and 0 <= v < self.shape[1]
        ]
        return [each for each in inside if self._comes_before(each, unit)]
