"""Neighbour lists: sorted spheres and their pairs, whatever room there is to begin with."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.neighbors.list_kernels import SortedSpheres
from packgen.arrange.neighbors.listing import list_pairs


@pytest.mark.parametrize("moving", [0, 40, 60])
def test_a_list_that_begins_too_short_holds_all_pairs_that_move(moving):
    rng = np.random.default_rng(3)
    ball = np.column_stack([rng.random((60, 3)), rng.choice([0.02, 0.2], 60)])
    reach = 1.2 * ball[:, 3]
    order, arrays, (owner, neighbor) = list_pairs(ball, reach, moving, np.empty(1, np.int32))
    spheres = SortedSpheres(*arrays)
    assert np.array_equal(spheres.ball, ball[order])
    assert np.array_equal(spheres.reach, reach[order])
    found = {frozenset(pair) for pair in zip(order[owner], order[neighbor[: len(owner)]], strict=True)}
    distance = np.linalg.norm(ball[:, None, :3] - ball[None, :, :3], axis=2)
    first, second = np.nonzero(np.triu(distance < reach[:, None] + reach, 1))
    assert found == {frozenset(pair) for pair in zip(first, second, strict=True) if pair[0] < moving}
    assert len(found) == len(owner)
