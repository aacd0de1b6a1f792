"""Mixtures: orders that are mixed everywhere."""

from __future__ import annotations

import hypothesis
import numpy as np
from hypothesis import strategies as st

from packgen.supply.mixtures import mixed_order


@hypothesis.settings(max_examples=60, deadline=None, derandomize=True)
@hypothesis.given(
    counts=st.lists(st.integers(0, 400), min_size=1, max_size=4),
    seed=st.integers(0, 2**32 - 1),
    parts=st.integers(1, 12),
)
def test_any_part_of_the_order_has_its_share_of_every_size_to_a_sphere_at_each_end(counts, seed, parts):
    radius = np.repeat(3.0 ** -np.arange(len(counts)), counts)
    order = mixed_order(radius, np.zeros(len(radius), np.int32), np.random.default_rng(seed))
    assert np.array_equal(np.sort(order), np.arange(len(radius)))
    for part in np.array_split(radius[order], parts):
        for number, count in enumerate(counts):
            there = np.isclose(part, 3.0**-number).sum()
            # The place of the part itself is set by all sizes, each of which is off by less than one.
            assert abs(there - count * len(part) / max(len(radius), 1)) <= 2.0 + 2.0 * len(counts)


def test_each_set_of_one_size_is_spread_evenly_and_equal_spheres_by_chance():
    sets = np.repeat([0, 1], [900, 100]).astype(np.int32)
    order = mixed_order(np.ones(1000), sets, np.random.default_rng(0))
    ones = np.flatnonzero(sets[order] == 1)
    assert np.diff(ones).max() < 25
    equal = mixed_order(np.ones(50), np.zeros(50, np.int32), np.random.default_rng(3))
    assert np.array_equal(equal, np.random.default_rng(3).permutation(50))
