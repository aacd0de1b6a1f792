"""Mixtures: orders that are mixed everywhere, and solid fractions with their closed limits."""

from __future__ import annotations

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from packgen.supply.mixtures import mixed_order, mixture_fraction, size_classes

ALONE = 0.6


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


def fraction(ratio, fine):
    return mixture_fraction(*size_classes(np.array([1.0, 1.0 / ratio]), np.array([1.0 - fine, fine])), ALONE)


def test_equal_spheres_pack_as_they_do_alone():
    assert mixture_fraction(*size_classes(np.full(9, 0.1), np.ones(9)), ALONE) == pytest.approx(ALONE)
    assert fraction(1.0 + 1e-9, 0.4) == pytest.approx(ALONE, abs=1e-6)


@pytest.mark.parametrize("fine", [0.05, 0.2])
def test_dust_lies_in_the_voids_of_large_spheres(fine):
    assert fraction(1e6, fine) == pytest.approx(ALONE / (1.0 - fine), rel=1e-4)


@pytest.mark.parametrize("fine", [0.5, 0.9])
def test_large_spheres_stand_in_much_dust_as_solid_lumps(fine):
    assert fraction(1e6, fine) == pytest.approx(1.0 / (1.0 - fine + fine / ALONE), rel=1e-4)


def test_the_densest_mixture_of_two_far_sizes_fills_the_voids_just_so():
    densest = max(fraction(1e6, fine) for fine in np.linspace(0.2, 0.4, 401))
    assert densest == pytest.approx(1.0 - (1.0 - ALONE) ** 2, rel=1e-3)


def test_the_farther_two_sizes_are_apart_the_more_densely_they_pack():
    fractions = [fraction(ratio, 0.3) for ratio in (1.5, 2.0, 3.0, 5.0, 10.0, 20.0)]
    assert np.all(np.diff(fractions) > 0.0)


def test_a_few_classes_stand_for_a_law_of_many_radii():
    radius = np.exp(np.random.default_rng(0).normal(0.0, 0.5, 20_000))
    sizes, share = size_classes(radius, radius**3)
    assert len(sizes) <= 24
    assert share.sum() == pytest.approx(1.0)
    assert np.all(np.diff(sizes) < 0.0)
    # Farr (Powder Technology 245 (2013) 28): lognormal laws pack by a few hundredths more densely.
    assert 0.62 < mixture_fraction(sizes, share, ALONE) < 0.66
