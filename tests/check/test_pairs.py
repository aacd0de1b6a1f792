from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from packgen.check import pairs as module
from packgen.check.pairs import near_pairs


def brute_force(position, radius, gap_fraction, period=(None, None, None)):
    """All pairs by the definition, every image written out: the oracle."""
    found = []
    shifts = list(itertools.product(*[(-1, 0, 1) if length else (0,) for length in period]))
    lengths = np.array([length or 0.0 for length in period])
    for i in range(len(radius)):
        for j in range(i + 1, len(radius)):
            for shift in shifts:
                image = position[j] + np.array(shift) * lengths
                gap = np.linalg.norm(position[i] - image) - radius[i] - radius[j]
                if gap <= gap_fraction * min(radius[i], radius[j]):
                    found.append((i, j, gap))
    return sorted(found)


def collected(position, radius, gap_fraction, period=(None, None, None)):
    found = []
    for piece in near_pairs(position, radius, gap_fraction=gap_fraction, period=period):
        low, high = np.minimum(piece.first, piece.second), np.maximum(piece.first, piece.second)
        found += list(zip(low.tolist(), high.tolist(), piece.gap.tolist(), strict=True))
    return sorted(found)


def assert_same(got, wanted):
    assert [pair[:2] for pair in got] == [pair[:2] for pair in wanted]
    np.testing.assert_allclose([p[2] for p in got], [p[2] for p in wanted], rtol=0, atol=1e-12)


@settings(max_examples=25, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(0, 60),
    ratio=st.sampled_from([1.0, 1.4, 8.0, 50.0]),
    periodic=st.tuples(st.booleans(), st.booleans(), st.booleans()),
    slab=st.sampled_from([3, 17, 1000]),
)
def test_pairs_are_those_of_brute_force(seed, count, ratio, periodic, slab):
    rng = np.random.default_rng(seed)
    position = rng.uniform(-0.5, 1.5, (count, 3)) + 7.0
    radius = 0.2 * rng.uniform(1.0 / ratio, 1.0, count)
    period = tuple(2.0 if wraps else None for wraps in periodic)
    before, module.SLAB_SIZE = module.SLAB_SIZE, slab
    try:
        got = collected(position, radius, 0.05, period)
    finally:
        module.SLAB_SIZE = before
    assert_same(got, brute_force(position, radius, 0.05, period))


def test_touching_spheres_of_very_different_size_are_a_pair():
    position = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.02]])
    assert len(collected(position, np.array([1.0, 0.02]), 1e-9)) == 1


@pytest.mark.parametrize("gap_fraction", [0.0, 0.01])
def test_spheres_that_are_apart_are_no_pair(gap_fraction):
    position = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.02]])
    assert collected(position, np.array([1.0, 1.0]), gap_fraction) == []


@settings(max_examples=25, deadline=None, derandomize=True)
@given(seed=st.integers(0, 2**32 - 1), ratio=st.sampled_from([1.0, 8.0]), periodic=st.booleans())
def test_pairs_within_a_body_are_left_out_and_no_others(seed, ratio, periodic):
    rng = np.random.default_rng(seed)
    position, radius = rng.uniform(0.0, 2.0, (40, 3)), 0.3 * rng.uniform(1.0 / ratio, 1.0, 40)
    body = rng.integers(0, 10, 40).astype(np.int32)
    period = (2.0, None, 2.0) if periodic else (None, None, None)
    pieces = list(near_pairs(position, radius, gap_fraction=0.05, period=period, body_index=body))
    got = sorted(
        pair
        for piece in pieces
        for pair in zip(
            np.minimum(piece.first, piece.second).tolist(),
            np.maximum(piece.first, piece.second).tolist(),
            piece.gap.tolist(),
            strict=True,
        )
    )
    wanted = [pair for pair in collected(position, radius, 0.05, period) if body[pair[0]] != body[pair[1]]]
    assert_same(got, wanted)


def test_a_sphere_that_meets_its_own_image_is_a_pair_whatever_its_body():
    position, radius = np.array([[0.5, 0.5, 0.5]]), np.array([0.3])
    pieces = list(near_pairs(position, radius, period=(0.5, None, None), body_index=np.zeros(1, np.int32)))
    assert [piece.gap.tolist() for piece in pieces] == [pytest.approx([-0.1])]
