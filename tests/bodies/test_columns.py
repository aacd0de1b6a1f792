"""Spheres that belong together: which bodies are whole, which pairs lie between two, how parts are joined."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from packgen.bodies import (
    are_in_rows,
    body_starts,
    joined_bodies,
    touched_bodies,
    whole_bodies,
)

QUICK = settings(max_examples=60, deadline=None, derandomize=True)


def index(*numbers):
    return np.array(numbers, np.int32)


@QUICK
@given(st.lists(st.tuples(st.integers(0, 5), st.booleans()), max_size=20))
def test_whole_and_touched_bodies_are_those_of_a_count_by_hand(spheres):
    body, chosen = index(*(each[0] for each in spheres)), np.array([each[1] for each in spheres], bool)
    whole = [all(c for b, c in spheres if b == own) for own, _ in spheres]
    touched = [any(c for b, c in spheres if b == own) for own, _ in spheres]
    assert whole_bodies(chosen, body).tolist() == whole
    assert touched_bodies(chosen, body).tolist() == touched


def test_without_a_column_each_sphere_is_a_body_and_nothing_is_copied():
    chosen = np.array([True, False])
    assert whole_bodies(chosen, None) is chosen
    assert touched_bodies(chosen, None) is chosen
    assert joined_bodies([None, None], [2, 3]) is None


def test_bodies_begin_where_the_number_changes_and_none_may_come_again():
    assert body_starts(index(4, 4, 2, 7, 7, 7)).tolist() == [0, 2, 3]
    assert body_starts(index()).tolist() == []
    assert are_in_rows(index(4, 4, 2, 7))
    assert not are_in_rows(index(4, 2, 4))


def test_parts_keep_their_numbers_unless_they_meet():
    apart = joined_bodies([index(5, 5, 2), index(9, 8, 8)], [3, 3])
    assert apart.tolist() == [5, 5, 2, 9, 8, 8]
    met = joined_bodies([index(0, 0, 1), index(1, 1, 3), index(0)], [3, 3, 1])
    assert met.tolist() == [0, 0, 1, 4, 4, 5, 6]
    assert met.dtype == np.int32


def test_spheres_without_numbers_get_some_of_their_own_when_joined_to_bodies():
    assert joined_bodies([None, index(0, 0, 3), None], [2, 3, 1]).tolist() == [4, 5, 0, 0, 3, 6]
    assert joined_bodies([index(), None], [0, 2]).tolist() == [0, 1]


def test_numbers_joined_again_and_again_stay_within_32_bits():
    top = np.iinfo(np.int32).max
    assert joined_bodies([index(top, top, 0), index(top)], [3, 1]).tolist() == [1, 1, 0, 2]
    column = index(0, 0, 1)
    for _ in range(100):
        column = joined_bodies([index(0, 1), column], [2, len(column)])
    assert len(np.unique(column)) == 2 + 2 + 99 * 2
