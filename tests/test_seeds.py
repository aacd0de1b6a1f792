"""A shift raises the seed of whatever the tests pack."""

from __future__ import annotations

import pytest

from packgen.scene import load_scene
from tests.scenes import box, constant, read_scene
from tests.seeds import raise_seeds, raised, shift


@pytest.mark.parametrize("keys", [{"seed": 5}, {}], ids=["named", "default"])
def test_a_shift_raises_the_seed_of_every_scene_that_is_loaded(tmp_path, monkeypatch, request, keys):
    before, _ = read_scene(tmp_path, box([0] * 3, [1] * 3), constant(0.1), **keys)
    assert before.seed == raised(keys.get("seed", 0))
    with monkeypatch.context() as patch:
        raise_seeds(patch, 1000)
        assert load_scene(before.path).seed == before.seed + 1000
        assert raised(2) == 1002 + request.config.getoption("--seed-shift")
    assert load_scene(before.path) == before


def test_the_option_is_the_shift(request):
    assert shift() == request.config.getoption("--seed-shift")
