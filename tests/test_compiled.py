"""Compiled loops are all compiled in one way, and Python goes on while they run."""

from __future__ import annotations

from pathlib import Path

import pytest

from packgen.arrange.projection.layer_kernels import run_sweeps
from packgen.arrange.space.map_kernels import least_gap, map_triangles

ROOT = Path(__file__).resolve().parent.parent


def test_only_one_module_says_how_loops_are_compiled():
    text = {path: path.read_text(encoding="utf-8") for path in ROOT.glob("packgen/**/*.py")}
    assert [path.name for path, each in text.items() if "import njit" in each] == ["compiled.py"]


@pytest.mark.parametrize("loop", [run_sweeps, least_gap, map_triangles])
def test_loops_free_the_interpreters_lock_and_keep_the_order_of_sums(loop):
    assert loop.targetoptions["nogil"]
    assert not loop.targetoptions.get("fastmath")
