"""Claims on layers of bodies: they stay rigid, part as bodies do, and come to rest inside the walls."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from packgen.arrange.rigid.layer import members_at, state_of
from packgen.arrange.rigid.recipe import RigidRecipe
from packgen.arrange.rigid.settle import settle_bodies
from packgen.arrange.space.walls import wall_table
from packgen.bodies import Bodies, Template, members_of, random_turns, rotations
from packgen.geometry import Box
from tests.seeds import raised

DOWN = np.array([0.0, 0.0, -1.0])
LEFT = Template(
    "bent",
    np.array([[-0.5, 0.1, 0.0, 0.5], [0.0, -0.2, 0.0, 0.5], [0.5, 0.1, 0.0, 0.5]]),
    1.2,
    np.array([[0.15, 0.02, 0.0], [0.02, 0.3, 0.0], [0.0, 0.0, 0.35]]),
    np.zeros(3),
)
FALLING = RigidRecipe.of_bodies(0.5, 1e-6)
FLOATING = replace(FALLING, sink_first=0.0, sink_last=0.0, friction=0.0, momentum=0.0, calm=0.0)


def bodies_at(position: np.ndarray, seed: int = 0) -> Bodies:
    count = len(position)
    turn = random_turns(np.random.default_rng(seed), count)
    return Bodies((LEFT,), np.zeros(count, np.int32), np.ones(count), position, turn)


def walls(high: tuple[float, float, float]):
    box = Box(np.zeros(3), np.array(high))
    return wall_table([box], np.array([box.min, box.max]), 1.5)


def heap() -> Bodies:
    grid = np.stack(np.meshgrid([1.2, 3.4], [1.2, 3.4], 1.3 + 2.1 * np.arange(6)), axis=-1)
    return bodies_at(grid.reshape(-1, 3))


@pytest.fixture(scope="module")
def settled() -> tuple[Bodies, np.ndarray]:
    return settle_bodies(heap(), np.empty((0, 4)), walls((4.6, 4.6, 20.0)), DOWN, FALLING)


def test_bodies_come_to_rest_without_overlap_inside_the_walls(settled):
    bodies, kept = settled
    assert kept.sum() >= 22  # 40 seeds: 24, twice 23
    bodies = bodies[kept]
    ball = members_at(bodies)
    owner = np.repeat(np.arange(len(bodies)), 3)
    apart = np.linalg.norm(ball[:, None, :3] - ball[None, :, :3], axis=2)
    apart[owner[:, None] == owner] = np.inf
    assert apart.min() > 1.0 - 0.5e-6
    assert ball[:, :3].min() > 0.5 - 0.5e-6
    assert ball[:, :2].max() < 4.1 + 0.5e-6
    assert ball[:, 2].max() < 8.0  # 20 seeds: 3.61 +- 0.24; they started at up to 11.8


def test_spheres_keep_their_places_in_their_bodies_to_rounding(settled):
    bodies, _ = settled
    assert np.abs(np.linalg.norm(bodies.orientation, axis=1) - 1.0).max() < 1e-15
    ball = members_at(bodies)
    centre, radius, _ = members_of(bodies)
    assert np.abs(ball[:, :3] - centre).max() < 1e-13
    assert np.array_equal(ball[:, 3], radius)


def test_the_same_layer_comes_to_rest_alike(settled):
    again, _ = settle_bodies(heap(), np.empty((0, 4)), walls((4.6, 4.6, 20.0)), DOWN, FALLING)
    assert np.array_equal(again.position, settled[0].position)
    assert np.array_equal(again.orientation, settled[0].orientation)


def depth(two: Bodies) -> float:
    ball = members_at(two)[:, :3]
    return 1.0 - float(np.linalg.norm(ball[:3, None] - ball[None, 3:], axis=2).min())


@pytest.mark.parametrize("seed", range(3))
def test_two_bodies_part_without_moving_their_common_centre_of_mass(seed):
    # Of bodies deep in each other one is cut short by the longest way that a sweep may take.
    pairs = (
        bodies_at(np.array([[4.0, 4.0, 4.0], [4.0 + way, 4.2, 4.1]]), raised(seed))
        for way in np.arange(2.5, 0.0, -0.02)
    )
    start = next(pair for pair in pairs if depth(pair) > 0.05)
    apart, kept = settle_bodies(start, np.empty((0, 4)), walls((9.0, 9.0, 9.0)), DOWN, FLOATING)
    assert kept.all()
    assert depth(apart) < 0.5e-6
    assert np.abs(apart.position - start.position).max() > 0.004  # 20 seeds: 0.012 to 0.031
    assert np.allclose(apart.position.mean(axis=0), start.position.mean(axis=0), atol=1e-12)


def test_a_body_that_is_pushed_off_its_centre_turns():
    start = bodies_at(np.array([[4.0, 4.0, 4.0]]))
    tip = members_at(start)[2, :3] + [0.0, 0.0, 0.7]
    moved, kept = settle_bodies(start, np.append(tip, 0.5)[None], walls((9.0, 9.0, 9.0)), DOWN, FLOATING)
    assert kept.all()
    # 20 seeds: 0.10 +- 0.04, from 0.02 on; a body that does not turn keeps every digit.
    assert np.abs(moved.orientation - start.orientation).max() > 1e-3
    assert np.linalg.norm(members_at(moved)[:, :3] - tip, axis=1).min() > 1.0 - 0.5e-6


def test_a_body_without_room_goes_as_a_whole_and_the_other_stays():
    both = bodies_at(np.array([[1.05, 0.72, 0.57], [1.1, 0.72, 0.57]]))
    both = replace(both, orientation=np.tile([1.0, 0.0, 0.0, 0.0], (2, 1)))  # one alone fits lengthwise
    _, kept = settle_bodies(both, np.empty((0, 4)), walls((2.1, 1.45, 1.15)), DOWN, FALLING)
    assert kept.tolist().count(True) == 1


def test_the_inverse_of_inertia_turns_with_the_body():
    bodies = replace(heap(), scale=np.linspace(0.5, 2.0, 24))
    state = state_of(bodies, np.empty((0, 4)), 1.0)
    full = np.empty((24, 3, 3))
    for place, (i, j) in enumerate(((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))):
        full[:, i, j] = full[:, j, i] = state.slackness[:, place]
    turn = rotations(bodies.orientation)
    mass = 4.0 / 3.0 * np.pi * state.reference**3
    product = turn @ full @ turn.transpose(0, 2, 1) @ bodies.inertia / mass
    assert np.allclose(product, np.eye(3), atol=1e-12)
