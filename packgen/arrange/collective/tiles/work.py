"""A unit from file to file: what each process of a run does."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from packgen.arrange.collective.tiles.layout import Block, Span, Unit
from packgen.arrange.collective.tiles.store import Rows, Store, UnitReport, rows_of, spheres_of
from packgen.arrange.collective.tiles.unit import Surroundings, TileTask, fill_unit
from packgen.arrays import Float64Array
from packgen.cores import free_cores


class Deal(NamedTuple):
    """The spheres that a tile gets in a round.

    Attributes:
        number: Number of the round.
        first_layer: Its first layer.
        begin: Place of the tile's first sphere among those of the round.
        end: Place after the last.
    """

    number: int
    first_layer: int
    begin: int
    end: int


def run_unit(store: Store, unit: Unit, deal: Deal, threads: int | None) -> UnitReport:
    """Do the work of a unit whose sources are done; at once, where it is done already.

    Args:
        store: Where units hand on what they leave.
        unit: The unit.
        deal: Its tile's spheres.
        threads: Threads at most; None: as many as cores are free.

    Returns:
        What it reports.
    """
    done = store.report(unit)
    if done is not None:
        return done
    task = store.task()
    stock = store.dealt(deal.number, deal.begin, deal.end)
    if unit.layer > deal.first_layer:
        stock = store.read_stock(unit._replace(layer=unit.layer - 1), stock)
    worked = fill_unit(task, unit, _before(store, task, unit), stock, threads or free_cores())
    store.write_blocks(unit, _blocks(task, unit, worked.after))
    report = UnitReport(worked.gained, worked.thrown_back, len(worked.buried))
    store.finish(unit, rows_of(worked.buried), stock, report)
    return report


def _before(store: Store, task: TileTask, unit: Unit) -> Surroundings:
    """Return what is at rest around a unit, block by block in their order."""
    layout = task.layout
    found: dict[Block, tuple[Rows, Float64Array]] = {}
    for source, blocks in layout.sources(unit).items():
        if blocks:
            found |= dict(zip(blocks, store.read_blocks(source, blocks), strict=True))
    window = layout.window(unit)
    tops = np.full([span.end - span.begin for span in window], -np.inf)
    for block, (_, of_block) in found.items():
        tops[_inside(layout.span(block), window)] = of_block
    rows = [found[block][0] for block in layout.blocks(unit) if block in found]
    return Surroundings(spheres_of(rows, task.zone_index), tops.ravel())


def _blocks(task: TileTask, unit: Unit, after: Surroundings) -> dict[Block, tuple[Rows, Float64Array]]:
    """Return what a unit leaves, block by block."""
    layout, window = task.layout, task.layout.window(unit)
    tops = after.buried_tops.reshape([span.end - span.begin for span in window])
    rows, of_row = rows_of(after.front), layout.block_index(after.front.position)
    return {
        block: (rows[of_row == layout.flat(block)], tops[_inside(layout.span(block), window)])
        for block in layout.blocks(unit)
    }


def _inside(spans: tuple[Span, Span], window: tuple[Span, Span]) -> tuple[slice, slice]:
    """Return where some columns are in a window."""
    u, v = (
        slice(span.begin - own.begin, span.end - own.begin) for span, own in zip(spans, window, strict=True)
    )
    return u, v
