from __future__ import annotations

import numpy as np

from exporters.walls.edges import edge_uses, edges_of, shared_edges
from tests.beds import box_surface

# Two triangles on an edge, a third on one of their others, and a fourth that shares that one too.
FACES = np.array([[0, 1, 2], [2, 1, 3], [3, 1, 4], [1, 3, 5]])


def test_each_edge_is_counted_at_each_of_its_facets():
    np.testing.assert_array_equal(edge_uses(FACES), [[1, 2, 1], [2, 3, 1], [3, 1, 1], [3, 1, 1]])
    assert (edge_uses(box_surface([0, 0, 0], [1, 1, 1]).faces) == 2).all()


def test_shared_edges_are_those_of_exactly_two_facets():
    first, second = shared_edges(FACES)
    assert [(int(a) // 3, int(b) // 3) for a, b in zip(first, second, strict=True)] == [(0, 1)]
    flat = edges_of(FACES).reshape(-1, 2)
    np.testing.assert_array_equal(flat[first], [[1, 2]])
    np.testing.assert_array_equal(flat[second], [[1, 2]])
    assert [len(each) for each in shared_edges(np.zeros((0, 3), np.int64))] == [0, 0]
