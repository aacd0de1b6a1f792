"""How many layers all tiles can fill, and how many spheres each gets for them."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.collective.plan import LayerPlan
from packgen.arrange.collective.tiles.fill import tile_layout
from packgen.arrange.collective.tiles.rounds import DEALT, LID, Rounds
from packgen.arrange.collective.tiles.unit import Sizes, TileTask
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.space.region import make_region
from packgen.supply.supply import Supply
from tests.scenes import box, constant, read_scene


@pytest.fixture(scope="module")
def task(tmp_path_factory):
    scene, container = read_scene(
        tmp_path_factory.mktemp("scene"), box([0, 0, 0], [6.1, 1, 2]), constant(0.05)
    )
    supply = Supply(scene.zones[0], scene.particle_sets, np.random.default_rng(0))
    region = make_region(container, (), np.array([0.0, 0.0, -1.0]), 0.05, "zones[0]")
    sizes = Sizes(supply.mean_volume, 0.05, 0.05, 0.1, 0.6, False)
    layout = tile_layout(region, supply, 20.0)
    return TileTask(0, region, Recipe(), LayerPlan(), sizes, layout, np.random.SeedSequence(0))


def test_tiles_get_spheres_by_their_volume_and_some_to_spare(task):
    each = Rounds(task).next(0, 6000)
    solid = each.counts * task.sizes.mean_volume / (task.top(each.last) * 1.0)
    widths = [2.0, 2.0, 2.1]
    assert solid / widths == pytest.approx([DEALT * 0.6] * 3, rel=0.02)


def test_a_round_has_as_many_layers_as_there_are_spheres_for(task):
    rounds = Rounds(task)
    for remaining in (3000, 5000, 9000):
        each = rounds.next(0, remaining)
        assert each.counts.sum() <= remaining
        one_more = rounds.next(each.last + 1, remaining - int(each.counts.sum()))
        assert one_more is None


def test_what_a_round_has_left_is_dealt_for_the_layers_after_it(task):
    each = Rounds(task).next(4, 3000)
    assert each.first == 4
    assert each.last > 4


def test_too_few_spheres_for_a_layer_make_no_round(task):
    assert Rounds(task).next(0, 500) is None


def test_layers_without_an_end_stop_below_the_lid(task):
    each = Rounds(task).next(0, None)
    lid = task.region.ceiling - LID * task.thickness
    assert task.top(each.last) <= lid < task.top(each.last + 1)
    assert Rounds(task).next(each.last + 1, None) is None
