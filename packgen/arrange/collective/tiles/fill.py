"""A zone that is filled by tiles: round after round, and the last layers as one piece."""

from __future__ import annotations

import tempfile
from contextlib import ExitStack
from pathlib import Path

import numpy as np

from packgen.arrange.collective.layers import Begun, fill_in_layers
from packgen.arrange.collective.open_zone import LayerReport, OpenZone
from packgen.arrange.collective.plan import START_FRACTION, LayerPlan
from packgen.arrange.collective.tiles.drive import Driver
from packgen.arrange.collective.tiles.layout import TileLayout, Unit
from packgen.arrange.collective.tiles.rounds import Round, Rounds
from packgen.arrange.collective.tiles.store import Rows, Store, UnitReport, spheres_of
from packgen.arrange.collective.tiles.unit import Sizes, TileTask
from packgen.arrange.collective.tiles.work import Deal
from packgen.arrange.crew import Crew
from packgen.arrange.pile import Pile
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.space.columns import ColumnMap
from packgen.arrange.space.region import Region
from packgen.arrange.spheres import Spheres, joined, no_spheres
from packgen.arrange.task import Filled, Sink, ZoneTask
from packgen.cores import free_cores
from packgen.leftovers import SCRATCH, owner
from packgen.supply.supply import Supply


def tile_layout(region: Region, supply: Supply, tile: float | None) -> TileLayout:
    """Return the tiles of a region.

    Args:
        region: The zone's space.
        supply: Its spheres.
        tile: Least width of a tile, in largest diameters; None: chosen by the region's width.
    """
    columns = ColumnMap.over(region, 2.0 * supply.radius_reference)
    return TileLayout.over(columns, tile, 2.0 * supply.radius_max)


def fill_in_tiles(
    zone: ZoneTask,
    region: Region,
    layout: TileLayout,
    recipe: Recipe,
    crew: Crew,
    on_layer: LayerReport,
    sink: Sink | None = None,
) -> Filled:
    """Fill a zone by tiles, and its last layers as one piece.

    Args:
        zone: The zone; it is the only one.
        region: Its space.
        layout: Its tiles, at least two.
        recipe: Constants of the optimiser.
        crew: Who does the work.
        on_layer: Called after each unit of a layer.
        sink: Takes the spheres in place of the result; None: the result has them.
    """
    supply, plan = zone.supply.copy(), LayerPlan()
    sizes = Sizes(
        supply.mean_volume,
        supply.radius_reference,
        supply.radius_max,
        2.0 * supply.radius_by_volume,
        supply.solid_fraction(START_FRACTION),
        supply.broad,
    )
    task = TileTask(zone.index, region, recipe, plan, sizes, layout, zone.seed)
    with ExitStack() as stack:
        folder = crew.folder
        if folder is None:
            folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix=f"{SCRATCH}{owner()}-")))
        store = Store(folder)
        store.write_task(task)
        threads = zone.setting.threads if crew.threads is None else crew.threads
        tiles = _Tiles(task, store, crew, supply, on_layer, threads)
        layers = tiles.fill()
        return _finished(zone, tiles, layers, on_layer, sink)


class _Tiles:
    """The rounds of a zone.

    Attributes:
        placed: Spheres at rest so far.
        thrown_back: Spheres that found no place so far.
    """

    def __init__(
        self,
        task: TileTask,
        store: Store,
        crew: Crew,
        supply: Supply,
        on_layer: LayerReport,
        threads: int | None,
    ) -> None:
        self.task, self.store, self.supply = task, store, supply
        self.placed = self.thrown_back = 0
        self._on_layer = on_layer
        self._driver = Driver(task.layout, store, crew, threads, self._note)

    def _note(self, unit: Unit, report: UnitReport) -> None:
        self.placed += report.gained
        self.thrown_back += report.thrown_back
        self._on_layer(unit.layer + 1, self.placed, self.task.top(unit.layer), self.thrown_back)

    def fill(self) -> int:
        """Run rounds while there are spheres and room for a whole layer; return the number of layers."""
        rounds, number, layer = Rounds(self.task), 0, 0
        while (each := rounds.next(layer, self.supply.remaining)) is not None:
            self._run(each, number)
            number, layer = number + 1, each.last + 1
        return layer

    def _run(self, each: Round, number: int) -> None:
        draw = self.supply.take(int(each.counts.sum()))
        self.store.write_supply(number, draw)
        ends = np.cumsum(each.counts).tolist()
        deals = {
            place: Deal(number, each.first, begin, end)
            for place, begin, end in zip(self.task.layout.tiles, [0, *ends], ends, strict=False)
        }
        self._driver.run(each.first, each.last, deals)
        for place in reversed(self.task.layout.tiles):
            deal = deals[place]
            stock = self.store.dealt(number, deal.begin, deal.end)
            stock = self.store.read_stock(Unit(each.last, *place), stock)
            self.supply.put_back(stock.take(len(stock.radius) + len(stock.carried.radius)))


def _finished(zone: ZoneTask, tiles: _Tiles, layers: int, on_layer: LayerReport, sink: Sink | None) -> Filled:
    """Fill what the tiles have left open as one piece, and return the whole."""
    task, store = tiles.task, tiles.store
    layout, region = task.layout, task.region
    units = [unit for layer in range(layers) for unit in layout.order(layer)]
    pile = Pile()
    rng = task.generator(Unit(layers, 0, 0))
    threads = zone.setting.threads or free_cores()
    rest = OpenZone(zone.index, region, tiles.supply, pile, rng, zone.setting.device, threads)
    begun = None
    if layers:
        front, buried_tops = _top(task, store, layers - 1)
        begun = Begun(front, buried_tops, task.top(layers - 1))

    def tell(batch: int, placed: int, level: float, thrown_back: int) -> None:
        whole = tiles.placed - (len(begun.front) if begun else 0) + placed
        on_layer(batch, whole, level, tiles.thrown_back + thrown_back)

    batch = fill_in_layers(rest, task.recipe, task.plan, tell, layers, begun)
    if sink is not None:
        for unit in units:
            sink(spheres_of([store.buried(unit)], zone.index))
        sink(pile.all())
        return Filled(no_spheres(), tiles.supply, batch)
    buried = spheres_of([store.buried(unit) for unit in units], zone.index)
    return Filled(joined([buried, pile.all()]), tiles.supply, batch)


def _top(task: TileTask, store: Store, layer: int) -> tuple[Spheres, np.ndarray]:
    """Return the spheres near the surface after a layer, and the tops of those put away, (columns,)."""
    layout = task.layout
    rows: list[Rows] = []
    tops = np.full(layout.columns.shape, -np.inf)
    for block in layout.all_blocks:
        [(of_block, tops_of_block)] = store.read_blocks(layout.last_of(block, layer), [block])
        rows.append(of_block)
        u, v = layout.span(block)
        tops[u.begin : u.end, v.begin : v.end] = tops_of_block
    return spheres_of(rows, task.zone_index), tops.ravel()
