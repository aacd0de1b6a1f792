"""Claims on friction in a sweep: what is taken from a contact's sliding, and what beds come of it."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.projection.friction_kernels import Rubbing, rub
from tests.scenes import box, constant, run_scene

ONE, OTHER = 0, 1


def rubbed(ball, travel, *, mass=(1.0, 1.0), spin=None, momentum=1.0, friction=0.5, grip=0.3):
    """The shifts and turns of two spheres of these masses that overlap."""
    ball, travel = np.array(ball, float), np.array(travel, float)
    spin = np.zeros((2, 3)) if spin is None else np.array(spin, float)
    shift, turned = np.zeros((2, 3)), np.zeros((2, 3))
    rubbing = Rubbing(travel, spin, turned, momentum, friction, grip)
    away = ball[ONE, :3] - ball[OTHER, :3]
    rub.py_func(ONE, OTHER, *away, ball, 1.0 / np.array(mass), rubbing, shift)
    return shift, turned


def sliding(ball, travel, spin):
    """How the surfaces of two spheres slide past each other at their contact."""
    ball = np.array(ball, float)
    normal = ball[ONE, :3] - ball[OTHER, :3]
    normal /= np.linalg.norm(normal)
    of_one = travel[ONE] + np.cross(spin[ONE], -ball[ONE, 3] * normal)
    of_other = travel[OTHER] + np.cross(spin[OTHER], ball[OTHER, 3] * normal)
    past = of_one - of_other
    return past - (past @ normal) * normal


PAIR = [[0.0, 0.0, 1.0, 0.6], [0.3, -0.2, 0.2, 0.4]]
TRAVEL = [[0.02, 0.01, -0.03], [-0.01, 0.004, 0.01]]
SPIN = [[0.01, 0.02, -0.01], [0.0, -0.03, 0.02]]


@pytest.mark.parametrize("mass", [(1.0, 1.0), (3.4, 1.0)])
def test_a_grip_of_two_sevenths_stops_the_sliding_of_a_single_contact(mass):
    shift, turned = rubbed(PAIR, TRAVEL, mass=mass, spin=SPIN, friction=1e6, grip=2.0 / 7.0)
    before = sliding(PAIR, np.array(TRAVEL), np.array(SPIN))
    after = sliding(PAIR, TRAVEL + shift, SPIN + turned)
    assert np.linalg.norm(before) > 0.01
    assert np.abs(after).max() < 1e-15


def test_friction_keeps_momentum_and_angular_momentum():
    ball, mass = np.array(PAIR), np.array([3.4, 1.0])
    shift, turned = rubbed(PAIR, TRAVEL, mass=mass, spin=SPIN)
    assert np.abs(mass @ shift).max() < 1e-17
    normal = (ball[ONE, :3] - ball[OTHER, :3]) / np.linalg.norm(ball[ONE, :3] - ball[OTHER, :3])
    # The spheres touch at one point: levers are radii.
    levers = -ball[ONE, 3] * normal, ball[OTHER, 3] * normal
    inertia = 0.4 * mass * ball[:, 3] ** 2
    for each in (ONE, OTHER):
        torque = np.cross(levers[each], mass[each] * shift[each])
        np.testing.assert_allclose(inertia[each] * turned[each], torque, atol=1e-17)


def test_friction_takes_no_more_than_its_coefficient_times_the_overlap():
    overlap = 1.0 - np.linalg.norm(np.array(PAIR[0][:3]) - PAIR[1][:3])
    for friction in (0.01, 0.05):
        shift, _ = rubbed(PAIR, TRAVEL, friction=friction, grip=0.3)
        taken = np.linalg.norm(shift[ONE] - shift[OTHER])
        assert taken == pytest.approx(friction * overlap)


def test_spheres_that_roll_on_each_other_feel_no_friction():
    # The upper one moves to the right and turns forwards, the lower one is at rest.
    ball = [[0.0, 0.0, 0.9, 0.5], [0.0, 0.0, 0.0, 0.5]]
    travel, spin = [[0.01, 0.0, 0.0], [0.0] * 3], [[0.0, 0.02, 0.0], [0.0] * 3]
    shift, turned = rubbed(ball, travel, spin=spin)
    assert np.abs(shift).max() < 1e-17
    assert np.abs(turned).max() < 1e-17


@pytest.mark.slow
@pytest.mark.physics
def test_any_number_of_threads_makes_the_same_loose_bed(tmp_path):
    zone = {"n_particles": 3000, "solid_fraction": {"value": 0.59, "of": "core"}}
    beds = [
        run_scene(tmp_path, box([0] * 3, [0.8, 0.8, 1.2]), constant(0.03), zones=[zone], threads=threads).bed
        for threads in (1, 2, 3)
    ]
    for bed in beds[1:]:
        assert bed.position.tobytes() == beds[0].position.tobytes()
