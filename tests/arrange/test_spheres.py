"""The columns of placed spheres, and the pile: bodies stay whole and different."""

from __future__ import annotations

import numpy as np

from packgen.arrange.pile import Pile
from packgen.arrange.spheres import Spheres, joined, no_spheres


def spheres(count, body=None, zone=0):
    index = np.full(count, zone, np.int32)
    column = None if body is None else np.array(body, np.int32)
    return Spheres(np.zeros((count, 3)), np.ones(count), index, index, index, column)


def test_joined_keeps_bodies_of_different_parts_apart():
    both = joined([spheres(3, [0, 0, 1]), spheres(2, [0, 0])])
    assert both.body_index.tolist() == [0, 0, 1, 2, 2]
    assert both.body_index.dtype == np.int32
    assert joined([spheres(1), spheres(2, [4, 4])]).body_index.tolist() == [5, 4, 4]


def test_chosen_spheres_keep_their_bodies():
    chosen = spheres(4, [3, 3, 5, 5])[np.array([True, True, False, False])]
    assert chosen.body_index.tolist() == [3, 3]


def test_spheres_without_bodies_stay_without():
    assert no_spheres().body_index is None
    assert joined([]).body_index is None
    assert joined([spheres(2), spheres(1)]).body_index is None
    assert spheres(2)[np.array([True, False])].body_index is None


def test_a_pile_buries_whole_bodies_only():
    pile = Pile()
    pile.front = spheres(5, [0, 0, 1, 1, 2])
    pile.bury(np.array([True, True, True, False, True]))
    assert pile.front.body_index.tolist() == [1, 1]
    assert len(pile) == 5
    assert np.bincount(pile.all().body_index).tolist() == [2, 2, 1]


def test_spheres_are_chosen_by_places_as_well_as_by_marks():
    three = Spheres(np.arange(9.0).reshape(3, 3), np.arange(3.0), *[np.arange(3, dtype=np.int32)] * 3)
    assert three[np.array([2, 1])].radius.tolist() == [2.0, 1.0]
    assert three[np.array([False, True, True])].radius.tolist() == [1.0, 2.0]
    assert three[np.ones(3, bool)].radius.tolist() == [0.0, 1.0, 2.0]
