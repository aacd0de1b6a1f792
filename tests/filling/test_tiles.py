"""Whether a bed is divided: by its own settings, or as several processes work on it."""

from __future__ import annotations

import pytest

from packgen.errors import PackingError, SceneError
from packgen.filling.tiles import in_tiles
from tests.scenes import box, constant, read_scene

BOX = box([0, 0, 0], [1, 1, 1])


def scene_with(folder, **keys):
    return read_scene(folder, BOX, constant(0.1), **keys)[0]


def test_a_bed_has_tiles_where_its_scene_says_so_or_processes_share_the_work(tmp_path):
    plain, tiled = scene_with(tmp_path), scene_with(tmp_path, params={"tile": 25})
    assert in_tiles(plain, shared=False) is plain
    assert in_tiles(plain, shared=True).params.tile == "auto"
    assert in_tiles(tiled, shared=True).params.tile == in_tiles(tiled, shared=False).params.tile == 25


@pytest.mark.parametrize("keys", [{"params": {"optimizer": "adam"}}, {"algorithm": "DISPERSED"}])
def test_algorithms_without_tiles_are_refused_by_name(tmp_path, keys):
    zone = {"n_particles": 9}
    scene = scene_with(tmp_path, zones=[zone], **keys)
    assert in_tiles(scene, shared=False) is scene
    with pytest.raises(PackingError, match=r"found (ADAM|DISPERSED), expected COLLECTIVE_ARRANGEMENT"):
        in_tiles(scene, shared=True)


@pytest.mark.parametrize("tile", [19, "wide", True, [20]])
def test_a_tile_is_wide_enough_for_its_halos(tmp_path, tile):
    with pytest.raises(SceneError, match="expected auto, or a number of at least 20 diameters"):
        scene_with(tmp_path, params={"tile": tile})
