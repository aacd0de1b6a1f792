"""Claims on how crowded a zone is."""

from __future__ import annotations

import math

import numpy as np
import pytest

from packgen.arrange.dispersed.crowding import missing_layer
from packgen.arrange.task import Gap
from tests.arrange.dispersed.rooms import room_of

WRAPPED = (True, True, True)


def test_a_thin_gas_lacks_a_radius_at_a_wall_and_a_dense_fluid_less():
    assert missing_layer(0.0) == 1.0
    assert missing_layer(0.45) == pytest.approx(0.55 / 1.9)


def test_the_fraction_of_a_periodic_box_is_the_plain_one_and_walls_raise_it():
    half = np.full(500, 0.05)
    plain = 500 * 4 / 3 * math.pi * 0.05**3
    assert room_of(WRAPPED).fraction(half, half) == pytest.approx(plain, rel=1e-9)
    found = room_of().fraction(half, half)
    assert found == pytest.approx(plain / (1 - 2 * 0.05 * missing_layer(found)) ** 3, rel=0.02)
    assert room_of().solid(found, half, half) == pytest.approx(plain, rel=0.02)


def test_room_ends_at_the_spheres_that_are_there():
    fixed = np.array([[0.5, 0.5, 0.5], [0.0, 0.0, 0.0]]), np.array([0.3, 0.2])
    free = 1 - 4 / 3 * math.pi * (0.3**3 + 0.2**3)
    assert room_of(WRAPPED, fixed=fixed).volume(0.0) == pytest.approx(free, abs=0.015)


def test_a_gap_is_halved_between_two_spheres_and_whole_at_a_wall():
    radius = np.array([1.0, 2.0])
    gap = Gap(0.1, 0.5)
    assert gap.half(radius).sum() - radius.sum() == pytest.approx(0.1 * 1.5 + 0.5)
    np.testing.assert_allclose(gap.wall(radius) - radius, [0.6, 0.7])
    assert (Gap().half(radius) == radius).all()
