"""Spheres that were taken out are forgotten, and those that left the periodic box come back."""

from __future__ import annotations

import numpy as np

from packgen.arrange.projection.ranks import closed_ranks
from packgen.arrange.space.seams import NO_SEAMS, Seams


def test_what_was_taken_out_is_forgotten_and_what_is_fixed_stays():
    ball = np.arange(16.0).reshape(4, 4)
    previous, identity = ball[:3, :3] - 0.5, np.array([7, 8, 9])
    expected = ball[[0, 2, 3]].copy()
    ball[1, :3] = np.nan
    left, before, place = closed_ranks(ball, previous, identity, NO_SEAMS)
    assert np.array_equal(left, expected)
    assert np.array_equal(before, expected[:2, :3] - 0.5)
    assert place.tolist() == [7, 9]


def test_a_sphere_that_left_the_box_comes_back_with_its_displacement():
    ball = np.array([[1.2, 0.5, -0.3, 0.1], [1.5, 0.5, 0.5, 0.1]])
    previous = np.array([[1.1, 0.4, -0.2]])
    left, before, _ = closed_ranks(ball, previous, np.arange(1), Seams(np.zeros(3), np.array([1.0, 0, 0])))
    np.testing.assert_allclose(left[0, :3], [0.2, 0.5, -0.3])
    np.testing.assert_allclose(before, [[0.1, 0.4, -0.2]])
    assert left[1, 0] == 1.5, "what is fixed is not moved"
