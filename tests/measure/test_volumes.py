from __future__ import annotations

import numpy as np
import pytest

from packgen.geometry import Ball, Cone, Surface
from packgen.measure.volumes import container_volume_below, sphere_volume, surface_volume_below, volume_below
from tests.beds import box_container, box_surface, make_container, revolved_surface

UP = np.array([0.0, 0.0, 1.0])
ASKEW = np.array([2.0, -1.0, 2.0]) / 3.0


def test_a_sphere_cut_through_its_middle_is_halved():
    radius = np.array([0.3])
    assert volume_below(np.array([1.0]), radius, 1.0)[0] == pytest.approx(sphere_volume(radius)[0] / 2)
    assert volume_below(np.array([1.0]), radius, 9.0)[0] == pytest.approx(sphere_volume(radius)[0])
    assert volume_below(np.array([1.0]), radius, 0.7)[0] == 0.0


@pytest.mark.parametrize(("level", "expected"), [(-1.0, 0.0), (0.5, 1.0), (3.0, 6.0), (9.0, 6.0)])
def test_volume_of_a_box_below_a_level(level, expected):
    surface = box_surface([0, 0, 0], [1, 2, 3])
    assert surface_volume_below(surface, UP, level) == pytest.approx(expected, abs=1e-12)


def test_volume_below_an_askew_plane_and_above_it_make_the_whole():
    surface = box_surface([5, 5, 5], [6, 7, 8])
    level = float(np.array([5.4, 6.2, 6.1]) @ ASKEW)
    below = surface_volume_below(surface, ASKEW, level)
    above = surface_volume_below(surface, -ASKEW, -level)
    assert below + above == pytest.approx(6.0)
    assert 1.0 < below < 5.0


def test_an_open_top_needs_no_lid():
    closed = box_surface([0, 0, 0], [1, 2, 3])
    top = (closed.vertices[closed.faces][:, :, 2] == 3.0).all(axis=1)
    open_box = Surface(closed.vertices, closed.faces[~top])
    assert surface_volume_below(open_box, UP, 2.0) == pytest.approx(4.0)
    assert surface_volume_below(open_box, UP, np.inf) == pytest.approx(6.0)


@pytest.mark.parametrize("axis", [UP, -UP])
def test_a_cone_is_cut_exactly(axis):
    # A full cone of height 3 with its tip at the origin, standing on the tip: V(z) = pi z^3 / 27.
    tip_first = axis[2] > 0
    cone = Cone(np.zeros(3) if tip_first else 3.0 * UP, axis, 3.0, *((0.0, 1.0) if tip_first else (1.0, 0.0)))
    container = make_container(cone, revolved_surface([(0, 0.001), (3, 1)], 12), np.pi)
    assert container_volume_below(container, UP, 2.0) == pytest.approx(np.pi * 8 / 27)


def test_a_ball_and_a_box_are_cut_exactly():
    ball = make_container(Ball(np.ones(3), 0.5), box_surface([0, 0, 0], [1, 1, 1]), 1.0)
    assert container_volume_below(ball, UP, 1.0) == pytest.approx(np.pi / 12)
    assert container_volume_below(box_container([0, 0, 0], [1, 1, 2]), UP, 0.25) == pytest.approx(0.25)
