"""Start positions of broad sizes: large ones apart, small ones outside of them, seams included."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from packgen.arrange.collective.starts import APART, assign_starts
from packgen.arrange.neighbors.point_kernels import mark_near, point_grid
from packgen.arrange.space.seams import NO_SEAMS, Seams

WRAPPED = Seams(np.zeros(3), np.array([1.0, 1.0, 0.0]))


def distances(one, other, seams):
    away = one[:, None] - other[None]
    period = seams.period
    away -= period * np.rint(np.divide(away, period, out=np.zeros_like(away), where=period > 0.0))
    return np.linalg.norm(away, axis=-1)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(1, 200),
    flat=st.sampled_from([(1, 1, 1), (1, 1, 0), (1, 0, 0), (0, 0, 0)]),
    wraps=st.booleans(),
    reach=st.sampled_from([0.01, 0.2, 0.45, 3.0]),
)
def test_the_marked_points_are_those_of_brute_force(seed, count, flat, wraps, reach):
    rng = np.random.default_rng(seed)
    seams = WRAPPED if wraps else NO_SEAMS
    points, center = rng.random((count, 3)) * flat, rng.uniform(-0.2, 1.2, 3)
    mark = np.zeros(count, bool)
    mark_near(center, reach, point_grid(points, seams.low, seams.period), mark)
    assert np.array_equal(mark, distances(points, center[None], seams)[:, 0] < reach)


@pytest.mark.parametrize("seams", [NO_SEAMS, WRAPPED], ids=["walls", "seams"])
def test_large_spheres_start_apart_and_small_ones_outside_of_them(seams):
    rng = np.random.default_rng(1)
    points = rng.random((60_000, 3))
    radius = np.concatenate([np.full(20, 0.1), np.full(4000, 0.008)])
    rest, rest_radius = rng.random((5, 3)), np.full(5, 0.09)
    chosen, found = assign_starts(points, radius, rest, rest_radius, seams)
    assert found.all()
    assert len(np.unique(chosen)) == len(radius)
    start = points[chosen]
    between = distances(start[:20], start[:20], seams) + np.eye(20)
    assert between.min() >= APART * 1.5 * 0.1
    assert distances(start[20:], start[:20], seams).min() > 0.1
    assert distances(start[20:], rest, seams).min() > 0.09


def test_where_there_is_no_room_spheres_share_it_or_go_back():
    rng = np.random.default_rng(2)
    points = rng.random((400, 3)) * 0.05
    chosen, found = assign_starts(
        points, np.array([0.1, 0.1, 0.01, 0.01]), np.empty((0, 3)), np.empty(0), NO_SEAMS
    )
    assert found.tolist() == [True, True, False, False]
    assert chosen[2:].tolist() == [-1, -1]
    nothing, none_found = assign_starts(np.empty((0, 3)), np.ones(3), np.empty((0, 3)), np.empty(0), NO_SEAMS)
    assert nothing.tolist() == [-1, -1, -1]
    assert not none_found.any()
