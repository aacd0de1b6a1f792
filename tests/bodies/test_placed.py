"""Bodies at their places."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from packgen.bodies import SINGLE, Bodies, members_of, rotations
from packgen.clumps import template_of_spheres


@pytest.fixture
def bodies():
    pair = template_of_spheres("pair", np.array([[0.0, 0, 0, 1.0], [1.5, 0, 0, 0.7]]))
    three = template_of_spheres("three", np.array([[0.0, 0, 0, 1.0], [1, 0, 0, 0.5], [0, 2, 0, 1.2]]))
    turn = np.random.default_rng(3).normal(size=(4, 4))
    return Bodies(
        (pair, three),
        np.array([1, SINGLE, 0, 1], np.int32),
        np.array([1.0, 0.3, 2.0, 0.5]),
        np.arange(12.0).reshape(4, 3),
        turn / np.linalg.norm(turn, axis=1, keepdims=True),
    )


def test_rotations_are_those_of_scipy(bodies):
    theirs = Rotation.from_quat(np.roll(bodies.orientation, -1, axis=1)).as_matrix()
    assert np.abs(rotations(bodies.orientation) - theirs).max() < 1e-15


def test_members_stand_where_their_template_turned_and_moved_has_them(bodies):
    position, radius, owner = members_of(bodies)
    assert owner.tolist() == [0, 0, 0, 1, 2, 2, 3, 3, 3]
    assert radius.tolist() == pytest.approx([1.0, 0.5, 1.2, 0.3, 2.0, 1.4, 0.5, 0.25, 0.6])
    turn = Rotation.from_quat(np.roll(bodies.orientation[2], -1).copy())
    expected = bodies.position[2] + 2.0 * turn.apply(bodies.templates[0].spheres[:, :3].copy())
    assert np.abs(position[4:6] - expected).max() < 1e-14
    assert position[3].tolist() == bodies.position[1].tolist()


def test_volume_and_inertia_are_those_of_the_union_where_it_stands(bodies):
    position, radius, owner = members_of(bodies)
    for each in range(len(bodies)):
        own = owner == each
        moved = template_of_spheres("moved", np.column_stack([position, radius])[own])
        # 20 seeds: at most 2.5e-8 off, which the union's own rule of integration is in another pose.
        assert bodies.volume[each] == pytest.approx(moved.volume, rel=1e-7)
        assert np.abs(bodies.inertia[each] - moved.inertia).max() < 1e-7 * np.trace(moved.inertia)
        assert np.abs(bodies.position[each] - moved.place).max() < 1e-7


def test_chosen_bodies_keep_their_shapes(bodies):
    assert bodies[np.array([2, 0])].sphere_count.tolist() == [2, 3]
    assert bodies.equivalent_radius[1] == pytest.approx(0.3)
