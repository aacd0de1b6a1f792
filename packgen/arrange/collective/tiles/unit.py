"""The work of a unit, one layer of one tile: from the spheres at rest in its columns to those after it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.random import SeedSequence

from packgen.arrange.collective.layer_starts import NARROW_SHARE, SPARE_STARTS
from packgen.arrange.collective.open_zone import settled_in
from packgen.arrange.collective.plan import LayerPlan
from packgen.arrange.collective.starts import assign_starts
from packgen.arrange.collective.tiles.layout import Span, TileLayout, Unit
from packgen.arrange.collective.tiles.stock import Stock
from packgen.arrange.collective.tiles.window import Window
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.space.region import Region
from packgen.arrange.spheres import Spheres, joined
from packgen.arrays import BoolArray, Float64Array
from packgen.portable import components, cube
from packgen.supply.supply import Draw

RIM = 2.25
"""Width of the rim on either side of a seam that is arranged once more with the later tile, in diameters."""

DEEPER = 2.0
"""How much deeper spheres lie that are put away than in a bed without tiles, in diameters: that is how much
lower the surface of a tile beside may be."""


@dataclass(frozen=True, slots=True)
class Sizes:
    """What a unit needs to know of the spheres of its zone.

    Attributes:
        mean_volume: Mean volume of a sphere [m3].
        radius_reference: Radius of a sphere of that volume [m].
        radius_max: Largest radius [m].
        diameter: Mean diameter, each sphere counted by its volume: the unit of the plan [m].
        fraction: Solid fraction at which a layer starts.
        broad: Whether large spheres choose their places first.
    """

    mean_volume: float
    radius_reference: float
    radius_max: float
    diameter: float
    fraction: float
    broad: bool


@dataclass(frozen=True, eq=False, slots=True)
class TileTask:
    """What all units of a zone share; plain data that can be sent to another process.

    Attributes:
        zone_index: Number of the zone.
        region: Its space.
        recipe: Constants of the optimiser.
        plan: Thickness of the layers.
        sizes: Its spheres.
        layout: Where the tiles are.
        seed: Seed of the zone's randomness.
    """

    zone_index: int
    region: Region
    recipe: Recipe
    plan: LayerPlan
    sizes: Sizes
    layout: TileLayout
    seed: SeedSequence

    @property
    def thickness(self) -> float:
        """Thickness of a layer [m]."""
        return self.plan.thickness * self.sizes.diameter

    def top(self, layer: int) -> float:
        """Return the altitude up to which a layer fills all tiles [m]: no tile asks another one for it."""
        return self.region.floor + (self.plan.first + layer) * self.thickness

    def generator(self, unit: Unit) -> np.random.Generator:
        """Return a unit's own source of randomness, the same one each time."""
        key = (*self.seed.spawn_key, *unit)
        return np.random.default_rng(SeedSequence(self.seed.entropy, spawn_key=key))


@dataclass(frozen=True, eq=False, slots=True)
class Surroundings:
    """The spheres at rest in the columns of a unit's window.

    Attributes:
        front: Those near the surface.
        buried_tops: Top of those put away, column by column [m]; -inf where there is none.
    """

    front: Spheres
    buried_tops: Float64Array


@dataclass(frozen=True, eq=False, slots=True)
class Worked:
    """What a unit leaves.

    Attributes:
        after: Its surroundings.
        buried: Spheres that no layer can reach any more.
        gained: How many more spheres are at rest.
        thrown_back: How many found no place.
    """

    after: Surroundings
    buried: Spheres
    gained: int
    thrown_back: int


def fill_unit(task: TileTask, unit: Unit, before: Surroundings, stock: Stock, threads: int) -> Worked:
    """Add one layer to one tile.

    Args:
        task: What all units share.
        unit: Which one this is.
        before: What is at rest around it.
        stock: The tile's spheres to come; changes.
        threads: Threads at most; what comes out does not depend on it.
    """
    surface = TileSurface(task, unit, before)
    starts = start_points(surface, task.generator(unit))
    start, draw = _assigned(task, starts, stock, before.front)
    reopened = surface.reopened(start)
    count = len(draw.radius)
    moving = joined(
        [
            Spheres(
                start,
                draw.radius,
                draw.set_index,
                np.full(count, task.zone_index, np.int32),
                np.full(count, unit.layer, np.int32),
            ),
            before.front[reopened],
        ]
    )
    fixed = before.front[~reopened]
    position, kept = settled_in(task.region, moving, fixed, task.recipe, threads=threads)
    kept &= surface.allows(position, moving.radius)
    settled, thrown = replace(moving, position=position)[kept], moving[~kept]
    if float(np.sum(cube(settled.radius))) < float(np.sum(cube(before.front.radius[reopened]))):
        # A layer that removes more volume than it adds is discarded.
        stock.put_back(draw.radius, draw.set_index)
        settled, fixed, thrown = before.front, before.front[:0], moving[:count]
    else:
        stock.put_back(thrown.radius, thrown.set_index)
    front = joined([fixed, settled])
    return _put_away(surface, front, before, len(thrown))


def _put_away(surface: TileSurface, front: Spheres, before: Surroundings, thrown_back: int) -> Worked:
    """Put away what no layer can reach any more, and return what the unit leaves."""
    deep = surface.deep(front)
    buried_tops = np.maximum(
        before.buried_tops, surface.window.tops(front.position[deep], front.radius[deep])
    )
    return Worked(
        Surroundings(front[~deep], buried_tops), front[deep], len(front) - len(before.front), thrown_back
    )


class TileSurface:
    """Where the next layer of a tile goes.

    Attributes:
        task: What all units share.
        unit: Which one this is.
        window: The columns of the tile and its halo.
        top: Altitude up to which the layer fills the tile [m].
        tops: Top of the bed column by column [m].
    """

    def __init__(self, task: TileTask, unit: Unit, before: Surroundings) -> None:
        self.task, self.unit, self._before = task, unit, before
        self.window = Window(task.layout, unit)
        self.top = task.top(unit.layer)
        self.tops = self._tops(before.front)

    @property
    def level(self) -> float:
        """Altitude up to which the layer before filled all tiles [m]."""
        task, layer = self.task, self.unit.layer
        return task.top(layer - 1) if layer else task.region.floor

    def _tops(self, front: Spheres) -> Float64Array:
        tops = self.window.tops(front.position, front.radius)
        tops[np.isneginf(tops)] = self.level
        return np.maximum(tops, self.task.region.floor)

    def reopened(self, start: Float64Array) -> BoolArray:
        """Tell which spheres at rest move again, (N,): those below newcomers, and those at a seam's rim.

        Args:
            start: Start positions of the newcomers [m], shape (n, 3).
        """
        task, window, front = self.task, self.window, self._before.front
        column = window.index(front.position)
        altitude = components(front.position, task.region.frame[2])
        depth = task.plan.reopened * task.sizes.diameter
        fresh = np.zeros(window.count)
        fresh[window.index(start)] = 1.0
        touched = window.highest(fresh, 2.0 * task.sizes.radius_max) > 0.0
        shallow = touched[column] & (self.tops[column] - altitude < depth)
        rim, width = self._rim()
        # What stands a layer higher at the seam is loose down to the foot of its side.
        lowest = window.lowest(self.tops, width)
        return np.asarray(shallow | (rim[column] & (lowest[column] - altitude < depth)))

    def _rim(self) -> tuple[BoolArray, float]:
        """Return which columns are near a seam to a tile that came earlier, (columns,), and how near [m]."""
        task, layout = self.task, self.task.layout
        width = float(layout.columns.width.min())
        count = round(RIM * task.sizes.diameter / width)
        rim, own = np.zeros(self.window.count, bool), self.window.near(layout.tile(self.unit), count)
        for other in layout.earlier_neighbors(self.unit):
            rim |= own & self.window.near(layout.tile(other), count)
        return rim, (count + 1) * width

    def allows(self, position: Float64Array, radius: Float64Array) -> BoolArray:
        """Tell which places may be kept, (N,): above all buried spheres near, and away from unseen ones."""
        task, layout = self.task, self.task.layout
        column = self.window.index(position)
        guard = int(np.ceil(2.0 * task.sizes.radius_max / float(layout.columns.width.min())))
        seen = self.window.near(layout.tile(self.unit), layout.halo - guard)
        bottom = components(position, task.region.frame[2]) - radius
        buried = self.window.highest(self._before.buried_tops, 2.0 * task.sizes.radius_max)
        return np.asarray(seen[column] & (bottom > buried[column]))

    def deep(self, front: Spheres) -> BoolArray:
        """Tell which spheres of the tile are too deep below all surfaces near to be reached again, (N,)."""
        task, window = self.task, self.window
        tops = window.tops(front.position, front.radius)
        found = np.isfinite(tops)
        tops[~found] = self.level
        # Where the bed ends under a sloping wall its top says nothing of the surface.
        radius = task.sizes.radius_reference
        tops[found & (task.region.clearance(window.points(tops + radius), radius) < 0.0)] = np.inf
        lowest = np.minimum(window.lowest(tops, self._rim()[1]), self.level)
        depth = (task.plan.reopened + task.plan.buffer + DEEPER) * task.sizes.diameter
        column = window.index(front.position)
        top = components(front.position, task.region.frame[2]) + front.radius
        return np.asarray(window.own[column] & (top < lowest[column] - depth - 2.0 * task.sizes.radius_max))


def start_points(surface: TileSurface, rng: np.random.Generator) -> Float64Array:
    """Return start positions between the bed and the top of a tile's layer [m], shape (n, 3)."""
    task, window = surface.task, surface.window
    region, sizes = task.region, task.sizes
    own = surface.tops[window.own]
    low = min(max(float(own.min()), surface.top - 2.0 * task.thickness), surface.top)
    least, most = _rectangle(task.layout, task.layout.tile(surface.unit), region)
    spare = SPARE_STARTS if sizes.broad else 1
    mean = spare * sizes.fraction / sizes.mean_volume * float(np.prod(most - least)) * (surface.top - low)
    count = int(rng.poisson(mean))
    across = least + rng.random((count, 2)) * (most - least)
    up = low + rng.random((count, 1)) * (surface.top - low)
    points = components(np.concatenate([across, up], axis=1), region.frame.T)
    height = components(points, region.frame[2]) - surface.tops[window.index(points)]
    clearance = region.clearance(points, sizes.radius_reference)
    close = -0.5 * sizes.radius_reference
    if (clearance >= 0.0).sum() > NARROW_SHARE * (clearance >= close).sum():
        close = 0.0
    return points[(height >= 0.0) & (height <= 2.0 * task.thickness) & (clearance >= close)]


def _rectangle(
    layout: TileLayout, spans: Sequence[Span], region: Region
) -> tuple[Float64Array, Float64Array]:
    """Return lower and upper corner of columns in u and v [m], within the region's, each (2,)."""
    columns = layout.columns
    least = columns.corner + columns.width * [span.begin for span in spans]
    most = columns.corner + columns.width * [span.end for span in spans]
    return least, np.minimum(most, region.rectangle()[1])


def _assigned(
    task: TileTask, points: Float64Array, stock: Stock, front: Spheres
) -> tuple[Float64Array, Draw]:
    """Take a sphere for each start position [m], (n, 3); of broad sizes the large ones choose first."""
    if not task.sizes.broad:
        draw = stock.take(len(points))
        return points[: len(draw.radius)], draw
    draw = stock.take(max(len(points) // SPARE_STARTS, 1))
    seams = task.region.walls.seams
    chosen, found = assign_starts(points, draw.radius, front.position, front.radius, seams)
    stock.put_back(draw.radius[~found], draw.set_index[~found])
    return points[chosen[found]], Draw(draw.radius[found], draw.set_index[found])
