"""Claims on the loops that part and stir spheres."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.dispersed.part_kernels import part
from packgen.arrange.dispersed.stir_kernels import crowded, stir
from tests.arrange.dispersed.rooms import room_of

COUNT = 300
HALF = np.full(COUNT, 0.05)


def parted(room):
    center = np.random.default_rng(0).random((COUNT, 3))
    sweeps, _ = part(center, 1.01 * HALF, 1.01 * HALF, np.ones(COUNT), room.region.walls, 500, 0.6, 0.005)
    return center, sweeps


def stirred(center, room, rounds, seed=1):
    center = center.copy()
    state = np.array([seed], np.uint64)
    taken = stir(center, HALF, HALF, room.region.walls, np.full(COUNT, 0.01), rounds, 1.0, state)
    return center, taken


@pytest.mark.parametrize("periodic", [(False,) * 3, (True, False, True), (True,) * 3])
def test_parted_spheres_are_free_and_stay_so_however_they_are_stirred(periodic):
    room = room_of(periodic)
    center, sweeps = parted(room)
    assert sweeps < 500  # 20 seeds: 8 to 19
    assert not crowded(center, HALF, HALF, room.region.walls).any()
    for rounds in (1, 7, 40):
        moved, taken = stirred(center, room, rounds)
        assert not crowded(moved, HALF, HALF, room.region.walls).any()
        assert 0 < taken.sum() <= rounds * COUNT  # 20 seeds of one round: 118 to 175


def test_random_starts_are_crowded_and_what_is_left_of_them_is_not():
    room = room_of()
    center = np.random.default_rng(0).random((COUNT, 3))
    kept = ~crowded(center, HALF, HALF, room.region.walls)
    assert 0 < kept.sum() < COUNT  # 20 seeds: 143 +- 7
    left = center[kept]
    assert not crowded(left, HALF[kept], HALF[kept], room.region.walls).any()


def test_fixed_spheres_stay_and_push():
    room = room_of((True,) * 3)
    center = np.array([[0.5, 0.5, 0.53], [0.5, 0.5, 0.5]])
    half = np.array([0.05, 0.05])
    part(center, half * 1.01, half[:1] * 1.01, np.ones(2), room.region.walls, 50, 0.6, 0.005)
    assert center[1].tolist() == [0.5, 0.5, 0.5]
    assert 0.1 <= np.linalg.norm(center[0] - center[1]) < 0.12


def test_spheres_at_one_place_part():
    room = room_of((True,) * 3)
    center = np.full((4, 3), 0.5)
    half = np.full(4, 0.05)
    part(center, half * 1.01, half * 1.01, np.ones(4), room.region.walls, 200, 0.6, 0.005)
    assert not crowded(center, half, half, room.region.walls).any()


def test_the_moves_are_those_of_their_seed_and_lean_to_no_side():
    room = room_of((True,) * 3)
    center, _ = parted(room)
    moved, _ = stirred(center, room, 10)
    assert np.array_equal(moved, stirred(center, room, 10)[0])
    assert not np.array_equal(moved, stirred(center, room, 10, seed=2)[0])
    step = (moved - center + 0.5) % 1.0 - 0.5
    # The mean's own standard error four times. 20 seeds: 1.9 +- 0.6 of it along one of the axes.
    assert np.abs(step.mean(axis=0)).max() < 4.0 * step.std() / np.sqrt(COUNT)
