"""What units hand on: files that are whole, the same when written twice, and read block by block."""

from __future__ import annotations

import os

import numpy as np
import pytest

from packgen.arrange.collective.tiles.layout import Block, Unit
from packgen.arrange.collective.tiles.stock import Stock, no_draw
from packgen.arrange.collective.tiles.store import Store, UnitReport, rows_of, spheres_of
from packgen.arrange.spheres import Spheres
from packgen.errors import ReadError
from packgen.supply.supply import Draw

UNIT = Unit(3, 1, 0)


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path)


def some_spheres(count, zone=0):
    rng = np.random.default_rng(count)
    numbers = np.arange(count, dtype=np.int32)
    return Spheres(
        rng.random((count, 3)), rng.random(count), numbers, np.full(count, zone, np.int32), numbers
    )


def test_spheres_come_back_as_they_were():
    spheres = some_spheres(7, zone=2)
    back = spheres_of([rows_of(spheres)[:3], rows_of(spheres)[3:]], 2)
    for name in ("position", "radius", "set_index", "zone_index", "batch_index"):
        assert np.array_equal(getattr(back, name), getattr(spheres, name))
    assert len(spheres_of([], 2)) == 0


def test_each_block_is_read_by_itself(store):
    blocks = {Block(0, each): (rows_of(some_spheres(each)), np.full((2, 3), float(each))) for each in (2, 5)}
    store.write_blocks(UNIT, blocks)
    [(rows, tops)] = store.read_blocks(UNIT, [Block(0, 5)])
    assert np.array_equal(rows, blocks[Block(0, 5)][0])
    assert (tops == 5.0).all()
    store.forget(UNIT)
    store.forget(UNIT)
    assert os.listdir(store.folder) == []


def test_a_unit_is_done_with_its_report_and_leaves_the_same_files_again(store):
    assert store.report(UNIT) is None
    stock = Stock(np.ones(9), np.zeros(9, np.int32), 4, Draw(np.full(2, 0.5), np.ones(2, np.int32)))
    written = []
    for _ in range(2):
        store.finish(UNIT, rows_of(some_spheres(6)), stock, UnitReport(5, 4, 6))
        [name] = os.listdir(store.folder)
        written.append((store.folder / name).read_bytes())
    assert written[0] == written[1]
    assert store.report(UNIT) == UnitReport(5, 4, 6)
    assert len(store.buried(UNIT)) == 6
    left = store.read_stock(UNIT, Stock(np.ones(9), np.zeros(9, np.int32), 0, no_draw()))
    assert left.cursor == 4
    assert left.take(99).radius.tolist() == [0.5, 0.5, 1.0, 1.0, 1.0, 1.0, 1.0]


def test_a_part_is_on_the_disk_before_it_has_its_name(store, monkeypatch):
    called = []
    monkeypatch.setattr("os.fsync", lambda descriptor: called.append(os.listdir(store.folder)))
    store.write_blocks(UNIT, {Block(0, 0): (rows_of(some_spheres(3)), np.zeros(1))})
    assert len(called) == 1
    assert not [name for name in called[0] if not name.startswith(".")]


def test_a_file_that_cannot_be_written_to_its_end_is_not_there(store):
    with pytest.raises(ValueError, match="pickle"):
        store.write_blocks(UNIT, {Block(0, 0): (Unpicklable(), np.zeros(1))})
    assert os.listdir(store.folder) == []


@pytest.mark.parametrize("size", [0, 1, 300, -30], ids=["none", "byte", "beginning", "no end"])
def test_a_part_that_is_damaged_is_told_in_a_line_with_the_remedy(store, size):
    block = Block(0, 0)
    stock = Stock(np.ones(9), np.zeros(9, np.int32), 4, no_draw())
    store.write_blocks(UNIT, {block: (rows_of(some_spheres(9)), np.zeros((2, 3)))})
    store.finish(UNIT, rows_of(some_spheres(9)), stock, UnitReport(5, 4, 9))
    for name in os.listdir(store.folder):
        path = store.folder / name
        path.write_bytes(path.read_bytes()[:size])
    reads = (
        lambda: store.report(UNIT),
        lambda: store.buried(UNIT),
        lambda: store.read_stock(UNIT, stock),
        lambda: store.read_blocks(UNIT, [block]),
    )
    for read in reads:
        with pytest.raises(
            ReadError, match=r"layer_00003.*: found a damaged part.*; remove .* --resume"
        ) as told:
            read()
        assert len(str(told.value).splitlines()) == 1


def test_blocks_that_are_gone_are_told_in_a_line_with_the_remedy(store):
    with pytest.raises(ReadError, match=r"layer_00003.*state.npz: found no such part.*; remove .* --resume"):
        store.read_blocks(UNIT, [Block(0, 0)])


class Unpicklable:
    def __array__(self, dtype=None, copy=None):
        raise ValueError("pickle")


def test_a_tile_has_its_own_share_of_what_is_dealt(store):
    store.write_supply(1, Draw(np.arange(1.0, 11.0), np.arange(10, dtype=np.int32)))
    stock = store.dealt(1, 3, 6)
    assert stock.take(2).radius.tolist() == [4.0, 5.0]
    stock.put_back(np.array([4.0]), np.array([3], np.int32))
    last = stock.take(9)
    assert last.radius.tolist() == [4.0, 6.0]
    assert last.set_index.tolist() == [3, 5]
