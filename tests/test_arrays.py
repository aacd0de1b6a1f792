"""What all arrays pass through, and sums at named places."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrays import add_at, distinct, read_only


@pytest.mark.parametrize("index", [[], [3], [7, 3, 3, 9], [0, 9]], ids=str)
def test_values_are_added_as_often_as_their_place_is_named(index):
    index = np.array(index, np.int32)
    values = np.random.default_rng(0).random(len(index))
    total, counts = np.arange(10.0), np.zeros(10, np.int32)
    expected = total.copy()
    np.add.at(expected, index, values)
    add_at(total, index, values)
    add_at(counts, index)
    assert total == pytest.approx(expected)
    assert counts.tolist() == [int((index == place).sum()) for place in range(10)]


def test_distinct_integers_come_rising_and_once():
    assert distinct(np.array([5, -1, 5, 3, -1, 3, 3])).tolist() == [-1, 3, 5]
    assert distinct(np.zeros(0, np.int64)).tolist() == []


def test_what_is_read_only_cannot_be_written_and_has_the_shape_it_says():
    array = read_only([[1, 2, 3]], np.float64, (None, 3), "bed.position")
    with pytest.raises(ValueError, match="read-only"):
        array[0, 0] = 5.0
    with pytest.raises(ValueError, match=r"bed.position: shape \(2,\), expected \('any', 3\)"):
        read_only([1, 2], np.float64, (None, 3), "bed.position")
