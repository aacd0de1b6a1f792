"""Claims on the lists of cells: they tell the same distances as a look at everything."""

from __future__ import annotations

import math

import numpy as np
import pytest

from packgen.arrange.void_filling.cell_kernels import LEAF, Cells, leaf_at, nearest_at
from packgen.arrange.void_filling.hollow import Hollow
from packgen.arrays import Float64Array
from packgen.compiled import loop
from tests.arrange.void_filling.shapes import UNIT_CUBE, ell, hollow


@loop
def by_lists(walls, tree, cells, point, listed):  # type: ignore[no-untyped-def]
    """Return distances from everything (N,), and note which of them a list tells."""
    near, found = np.empty(7), np.empty(len(point))
    for k in range(len(point)):
        x, y, z = point[k, 0], point[k, 1], point[k, 2]
        cell = leaf_at(cells, x, y, z)
        listed[k] = cells.child[cell] == LEAF and cells.state[cell] & 1
        found[k] = nearest_at(walls, tree, cells, x, y, z, np.inf, near)
    return found


def told(found: Hollow, point: Float64Array) -> tuple[Float64Array, Float64Array]:
    """Return what lists tell, and which points have one."""
    cells: Cells = found._search.cells
    listed = np.zeros(len(point))
    near: Float64Array = by_lists(found._walls, found._tree, cells, point, listed)  # type: ignore[no-untyped-call]
    return near, listed


@pytest.mark.parametrize("shape", [UNIT_CUBE, ell()], ids=["box", "mesh"])
def test_lists_tell_the_distances_that_a_look_at_everything_tells(shape: object) -> None:
    found = hollow(shape)  # type: ignore[arg-type]
    found.fill(1e-3, 200, math.inf)
    point = np.random.default_rng(2).random((5000, 3))
    near, listed = told(found, point)
    np.testing.assert_allclose(near, found.distance(point), rtol=0.0, atol=1e-14)
    assert listed.sum() > 200
