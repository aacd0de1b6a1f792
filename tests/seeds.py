"""The seeds of what the tests pack: ``pytest --seed-shift N`` raises them all by N.

A claim about a bed holds whatever its seed. The shift shows which claims hang on one draw.
Scenes that a test loads in its own process are reached by ``raise_seeds``. ``raised`` is for the other ones:
seeds that no scene file holds, and scenes that another process loads.
"""

from __future__ import annotations

import os
import sys
from dataclasses import replace
from typing import Any

import pytest

from packgen.scene import Scene, load_scene

SHIFT = "PACKGEN_TESTS_SEED_SHIFT"


def shift() -> int:
    """By how much seeds are raised."""
    return int(os.environ.get(SHIFT, "0"))


def raised(seed: int) -> int:
    return seed + shift()


def raise_seeds(monkeypatch: pytest.MonkeyPatch, by: int) -> None:
    """Raise the seed of every scene that this process loads by so much more, also where its file has none."""
    loader = sys.modules[load_scene.__module__]
    build = loader._scene

    def build_raised(*parts: Any) -> Scene:
        scene: Scene = build(*parts)
        return replace(scene, seed=scene.seed + by)

    monkeypatch.setenv(SHIFT, str(shift() + by))
    monkeypatch.setattr(loader, "_scene", build_raised)


unshifted = pytest.mark.skipif("config.getoption('--seed-shift')", reason="the numbers are those of one seed")
