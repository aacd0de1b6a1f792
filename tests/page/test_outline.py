"""Lines that show a surface."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.container.primitives import ball_surface, box_surface, cone_surface
from packgen.geometry import Ball, Box, Cone
from packgen.page.outline import LINES_MAX, outline, section

UP = np.array([0.0, 0.0, 1.0])


def lengths(lines):
    return np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1)


def test_a_box_is_its_twelve_edges():
    lines = outline(box_surface(Box(np.zeros(3), np.array([1.0, 2.0, 3.0]))), UP)
    assert sorted(lengths(lines).round(9)) == [1.0] * 4 + [2.0] * 4 + [3.0] * 4


def test_a_cylinder_is_its_two_rims_and_the_cuts_through_its_middle():
    lines = outline(cone_surface(Cone(np.zeros(3), UP, 2.0, 0.5, 0.5)), UP)
    at_ends = np.isin(lines[:, :, 2].round(9), [0.0, 2.0]).all(axis=1)
    rims = lines[at_ends & (lengths(lines) < 0.1)]
    assert lengths(rims).sum() >= 2 * np.pi
    upright = np.ptp(lines[:, :, 2], axis=1) > 0.0
    assert lengths(lines[upright]).sum() == pytest.approx(8.0)  # four lines from end to end


def test_a_ball_is_three_great_circles():
    lines = outline(ball_surface(Ball(np.zeros(3), 1.0)), UP)
    assert lengths(lines).sum() == pytest.approx(6 * np.pi, rel=0.01)
    assert len(lines) <= LINES_MAX


@pytest.mark.parametrize("level", [0.25, 0.5])
def test_a_plane_cuts_a_box_in_its_outline(level):
    lines = section(box_surface(Box(np.zeros(3), np.ones(3))), UP, level)
    np.testing.assert_allclose(lines[:, :, 2], level)
    assert lengths(lines).sum() == pytest.approx(4.0)


def test_a_plane_beside_a_surface_cuts_nothing():
    assert section(box_surface(Box(np.zeros(3), np.ones(3))), UP, 2.0).shape == (0, 2, 3)
