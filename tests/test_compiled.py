"""Compiled loops are all compiled in one way, and Python goes on while they run."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from numba import types
from numba.core.dispatcher import Dispatcher

from packgen.arrange.neighbors.point_kernels import point_grid
from packgen.arrange.projection.layer_kernels import run_sweeps
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.projection.settle import settle
from packgen.arrange.space.map_kernels import least_gap, map_triangles
from packgen.arrange.space.seams import Seams
from packgen.arrange.space.walls import wall_table
from packgen.geometry import Box

ROOT = Path(__file__).resolve().parent.parent


def test_only_one_module_says_how_loops_are_compiled():
    text = {path: path.read_text(encoding="utf-8") for path in ROOT.glob("packgen/**/*.py")}
    assert [path.name for path, each in text.items() if "import njit" in each] == ["compiled.py"]


@pytest.mark.parametrize("loop", [run_sweeps, least_gap, map_triangles])
def test_loops_free_the_interpreters_lock_and_keep_the_order_of_sums(loop):
    assert loop.targetoptions["nogil"]
    assert not loop.targetoptions.get("fastmath")


def named(kind):
    """Tell whether a type of numba is a named tuple, or holds one."""
    return isinstance(kind, types.BaseNamedTuple) or any(named(each) for each in getattr(kind, "types", ()))


def test_no_loop_that_python_calls_returns_a_named_tuple():
    down, walls = np.array([0.0, 0.0, -1.0]), Seams(np.zeros(3), np.array([1.0, 1.0, 0.0]))
    box = np.array([[0.0] * 3, [1.0] * 3])
    ball = np.random.default_rng(0).random((40, 4)) * 0.08 + np.array([0.4, 0.4, 0.4, 0.02])
    settle(ball, 40, wall_table([Box(*box)], box, 0.1, walls), down, Recipe())
    point_grid(ball[:, :3].copy(), np.zeros(3), np.zeros(3))
    seen = 0
    for module in [each for name, each in sys.modules.items() if name.startswith("packgen.")]:
        for loop in [each for each in vars(module).values() if isinstance(each, Dispatcher)]:
            if loop.targetoptions.get("no_cpython_wrapper"):
                continue
            for signature in loop.nopython_signatures:
                seen += 1
                assert not named(signature.return_type), loop
    assert seen > 5
