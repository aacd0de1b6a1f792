"""Where tiles are: every column has one owner in each layer, and units of one colour never meet."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from packgen.arrange.collective.tiles.layout import HALO, TileLayout, Unit
from packgen.arrange.space.columns import ColumnMap

WIDE, STRIPES, NARROW = (200, 170), (120, 40), (39, 30)


def layout_of(shape, tile=20.0, diameter=1.0):
    """Tiles over so many columns, each 1 m wide."""
    return TileLayout.over(
        ColumnMap(np.eye(3), np.ones(2), shape, np.zeros(2), (False, False)), tile, diameter
    )


def cells(spans):
    (u, u_end), (v, v_end) = spans
    return {(each, other) for each in range(u, u_end) for other in range(v, v_end)}


@pytest.mark.parametrize("layer", range(4))
@pytest.mark.parametrize("shape", [WIDE, STRIPES])
def test_every_column_is_the_own_of_one_unit_of_a_layer(shape, layer):
    layout = layout_of(shape)
    count = np.zeros(shape, int)
    for unit in layout.order(layer):
        (u, u_end), (v, v_end) = layout.tile(unit)
        count[u:u_end, v:v_end] += 1
    assert (count == 1).all()


@pytest.mark.parametrize("layer", range(4))
@pytest.mark.parametrize("shape", [WIDE, STRIPES])
def test_units_of_one_colour_share_no_column(shape, layer):
    layout = layout_of(shape)
    units = layout.order(layer)
    for one, other in combinations(units, 2):
        if layout.rank(one)[0] == layout.rank(other)[0]:
            assert not cells(layout.window(one)) & cells(layout.window(other))


@pytest.mark.parametrize("shape", [WIDE, STRIPES])
def test_seams_do_not_stand_on_those_of_the_layer_below(shape):
    layout = layout_of(shape)
    for unit in layout.order(0):
        begin, above = layout.tile(unit)[0].begin, layout.tile(unit._replace(layer=1))[0].begin
        assert begin == above == 0 or abs(begin - above) >= 2 * HALO


def test_blocks_cover_the_window_of_their_unit():
    layout = layout_of(WIDE)
    for unit in layout.order(3):
        covered = [cell for block in layout.blocks(unit) for cell in cells(layout.span(block))]
        assert len(covered) == len(set(covered))
        assert set(covered) == cells(layout.window(unit))


def test_a_unit_takes_each_block_from_the_last_one_that_had_it():
    layout = layout_of(WIDE)
    holder = {}
    for layer in range(5):
        for unit in layout.order(layer):
            taken = {block: source for source, blocks in layout.sources(unit).items() for block in blocks}
            assert taken == {block: holder[block] for block in layout.blocks(unit) if block in holder}
            holder |= dict.fromkeys(layout.blocks(unit), unit)
    assert holder == {block: layout.last_of(block, 4) for block in layout.all_blocks}


def test_a_unit_stands_on_its_own_tile_below():
    layout = layout_of(STRIPES)
    assert Unit(4, 2, 0) in layout.sources(Unit(5, 2, 0))


def test_points_belong_to_the_block_of_their_column():
    layout = layout_of(STRIPES)
    rng = np.random.default_rng(0)
    points = rng.uniform([0, 0, 0], [*STRIPES, 1], (200, 3))
    number = layout.block_index(points)
    for point, found in zip(points, number, strict=True):
        [block] = [each for each in layout.all_blocks if layout.flat(each) == found]
        assert tuple(int(each) for each in point[:2]) in cells(layout.span(block))


def test_a_vessel_of_few_tiles_has_stripes_and_a_wide_one_tiles():
    assert layout_of(STRIPES).shape == (6, 1)
    assert layout_of(WIDE).shape == (10, 8)
    assert layout_of(NARROW).shape == (1, 1)


@pytest.mark.parametrize(("width", "stripes"), [(59, 1), (60, 2), (120, 4), (240, 4), (419, 6)])
def test_a_vessel_chooses_tiles_a_quarter_as_wide_as_it_from_30_to_60_diameters(width, stripes):
    assert layout_of((width, 20), None).shape == (stripes, 1)


def test_tiles_are_as_wide_in_diameters_whatever_the_columns_are():
    assert layout_of((120, 40), 20.0, diameter=2.0).shape == (3, 1)
