from __future__ import annotations

import numpy as np
import pytest

from packgen.geometry import Ball, Cone, Mesh, Surface
from packgen.measure.volumes import container_volume_below, sphere_volume, surface_volume_below, volume_below
from tests.beds import box_container, box_surface, make_container, revolved_surface

UP = np.array([0.0, 0.0, 1.0])
ASKEW = np.array([2.0, -1.0, 2.0]) / 3.0


def test_a_sphere_cut_through_its_middle_is_halved():
    radius = np.array([0.3])
    assert volume_below(np.array([1.0]), radius, 1.0)[0] == pytest.approx(sphere_volume(radius)[0] / 2)
    assert volume_below(np.array([1.0]), radius, 9.0)[0] == pytest.approx(sphere_volume(radius)[0])
    assert volume_below(np.array([1.0]), radius, 0.7)[0] == 0.0


def test_volumes_of_a_box_below_levels():
    surface = box_surface([0, 0, 0], [1, 2, 3])
    found = surface_volume_below(surface, UP, np.array([9.0, 0.5, -1.0, 3.0, 2.25]))
    np.testing.assert_allclose(found, [6.0, 1.0, 0.0, 6.0, 4.5], rtol=0, atol=1e-12)


def test_a_fine_cone_far_from_the_origin_is_cut_as_exactly_as_a_near_one():
    level = np.linspace(0.1, 2.9, 15)
    near = revolved_surface([(0, 0.001), (1.5, 0.6), (3, 1)], 4000)
    far = Surface(near.vertices + np.array([3e4, -2e4, 1e4]), near.faces)
    radius = np.interp(level, [0, 1.5, 3], [0.001, 0.6, 1])
    frustum = np.pi / 3 * 1.5 * (0.001**2 + 0.001 * 0.6 + 0.6**2)
    exact = np.where(
        level < 1.5,
        np.pi / 3 * level * (0.001**2 + 0.001 * radius + radius**2),
        frustum + np.pi / 3 * (level - 1.5) * (0.6**2 + 0.6 * radius + radius**2),
    )
    found = surface_volume_below(near, UP, level)
    np.testing.assert_allclose(found, exact, rtol=1e-6)
    np.testing.assert_allclose(surface_volume_below(far, UP, level + 1e4), found, rtol=1e-9)


def test_volume_below_an_askew_plane_and_above_it_make_the_whole():
    surface = box_surface([5, 5, 5], [6, 7, 8])
    level = float(np.array([5.4, 6.2, 6.1]) @ ASKEW)
    below = surface_volume_below(surface, ASKEW, np.array([level]))[0]
    above = surface_volume_below(surface, -ASKEW, np.array([-level]))[0]
    assert below + above == pytest.approx(6.0)
    assert 1.0 < below < 5.0


def test_an_open_top_needs_no_lid():
    closed = box_surface([0, 0, 0], [1, 2, 3])
    top = (closed.vertices[closed.faces][:, :, 2] == 3.0).all(axis=1)
    open_box = Surface(closed.vertices, closed.faces[~top])
    assert surface_volume_below(open_box, UP, np.array([2.0]))[0] == pytest.approx(4.0)
    assert surface_volume_below(open_box, UP, np.array([np.inf]))[0] == pytest.approx(6.0)


@pytest.mark.parametrize("axis", [UP, -UP])
def test_a_cone_is_cut_exactly(axis):
    # A full cone of height 3 with its tip at the origin, standing on the tip: V(z) = pi z^3 / 27.
    tip_first = axis[2] > 0
    cone = Cone(np.zeros(3) if tip_first else 3.0 * UP, axis, 3.0, *((0.0, 1.0) if tip_first else (1.0, 0.0)))
    container = make_container(cone, revolved_surface([(0, 0.001), (3, 1)], 12), np.pi)
    assert container_volume_below(container, UP, np.array([2.0]))[0] == pytest.approx(np.pi * 8 / 27)


def test_a_ball_and_a_box_are_cut_exactly():
    ball = make_container(Ball(np.ones(3), 0.5), box_surface([0, 0, 0], [1, 1, 1]), 1.0)
    assert container_volume_below(ball, UP, np.array([1.0]))[0] == pytest.approx(np.pi / 12)
    assert container_volume_below(box_container([0, 0, 0], [1, 1, 2]), UP, np.array([0.25]))[
        0
    ] == pytest.approx(0.25)


def test_a_body_that_pokes_out_of_the_vessel_takes_from_it_what_lies_in_it():
    vessel, body = box_surface([0, 0, 0], [1, 1, 1]), box_surface([0.5, 0.25, 0.25], [2.0, 0.75, 0.75])
    faces = np.concatenate([vessel.faces, body.faces[:, ::-1] + len(vessel.vertices)])
    both = Surface(np.concatenate([vessel.vertices, body.vertices]), faces)
    container = make_container(Mesh(both), both, 0.875)
    found = container_volume_below(container, UP, np.array([0.25, 0.5, 1.0]))
    np.testing.assert_allclose(found, [0.25, 0.4375, 0.875], atol=0.02)
