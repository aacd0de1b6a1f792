"""The closed forms against the library ``overlap``, and against each other."""

from __future__ import annotations

import numpy as np
import overlap
import pytest

from exporters.fields import ball_cuts as cuts
from exporters.fields import grid_cells as cells

CORNERS = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
)  # fmt: skip
BALL = overlap.Sphere(np.zeros(3), 1.0)


def by_the_library(low, high):
    return overlap.overlap_volume(BALL, overlap.Hexahedron(low + CORNERS * (np.asarray(high) - low)))


def test_what_is_beyond_planes_is_what_the_library_finds():
    planes = np.random.default_rng(0).uniform(-1, 1, (2000, 3))
    corner, wedge = cuts.corner(*planes.T), cuts.wedge(planes[:, 0], planes[:, 1])
    for (a, b, c), three, two in zip(planes, corner, wedge, strict=True):
        assert three == pytest.approx(by_the_library([a, b, c], [2, 2, 2]), abs=1e-13)
        assert two == pytest.approx(by_the_library([a, b, -2], [2, 2, 2]), abs=1e-13)


@pytest.mark.parametrize("value", [-1.0, 0.0, 1.0])
def test_planes_through_the_centre_and_beside_the_ball_have_their_simple_values(value):
    at = np.array([value])
    share = {-1.0: 1.0, 0.0: 0.5, 1.0: 0.0}[value]
    assert cuts.cap(at)[0] == pytest.approx(share * cuts.BALL, abs=1e-15)
    assert cuts.wedge(at, at)[0] == pytest.approx(share**2 * cuts.BALL, abs=1e-15)
    assert cuts.corner(at, at, at)[0] == pytest.approx(share**3 * cuts.BALL, abs=1e-15)


def test_pieces_of_a_ball_in_many_cells_match_the_library_and_add_up_to_the_ball():
    center, radius, spacing = np.array([[1.3, 1.1, 0.9]]), np.array([0.8]), np.array([0.35, 0.5, 0.28])
    shape = (7, 5, 7)
    volume = cells.grid_volumes(center, radius, np.zeros(3), spacing, shape)
    ball = overlap.Sphere(center[0], 0.8)
    for cell in np.ndindex(shape):
        body = overlap.Hexahedron((np.array(cell) + CORNERS) * spacing)
        assert volume[cell] == pytest.approx(overlap.overlap_volume(ball, body), abs=1e-14)
    assert volume.sum() == pytest.approx(cuts.BALL * 0.8**3, rel=1e-14)
    assert volume.min() >= 0


def test_what_is_beyond_the_grid_is_in_no_cell():
    def held(*low):
        return cells.grid_volumes(
            np.zeros((1, 3)), np.ones(1), np.array(low), np.full(3, 4.0), (1, 1, 1)
        ).sum()

    assert held(0.0, -2.0, -2.0) == pytest.approx(cuts.BALL / 2, rel=1e-14)
    assert held(1.5, 1.5, 1.5) == held(-6.0, -6.0, -6.0) == 0
