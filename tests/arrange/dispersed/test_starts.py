"""Claims on where dispersed spheres start."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.dispersed.starts import even_points, start_classes, starts_of, voids
from tests.arrange.dispersed.rooms import NONE, room_of

WRAPPED = (True, True, True)


@pytest.mark.parametrize("fraction", [0.05, 0.45])
def test_numbers_in_an_eighth_vary_as_those_of_a_fluid_do(fraction):
    room, counts = room_of(WRAPPED), []
    for seed in range(200):
        points = even_points(room, 800, 0.0, NONE, fraction, np.random.default_rng(seed))
        assert len(points) == 800
        counts.append(int((points < 0.5).all(axis=1).sum()))
    compressibility = (1 - fraction) ** 4 / (1 + 2 * fraction) ** 2
    # Of points without a rule: 800 / 8 * 7 / 8. The cells that the eighth's sides cut add a little.
    found = np.var(counts) / (100 * 7 / 8)
    assert compressibility * 0.7 < found < compressibility * 1.3 + 0.25


def test_points_keep_away_from_walls_and_out_of_spheres():
    around = np.array([[0.5, 0.5, 0.5]]), np.array([0.3])
    points = even_points(room_of(), 300, 0.1, around, 0.3, np.random.default_rng(0))
    assert len(points) == 300
    assert (points >= 0.1).all()
    assert (points <= 0.9).all()
    assert np.linalg.norm(points - 0.5, axis=1).min() >= 0.3


def test_where_there_is_no_room_there_are_fewer_points():
    around = np.array([[0.5, 0.5, 0.5]]), np.array([0.9])
    assert len(even_points(room_of(), 50, 0.0, around, 0.3, np.random.default_rng(0))) < 50


def test_small_spheres_start_in_no_large_one():
    half = np.full(200, 0.02)
    placed = np.array([[0.3, 0.3, 0.3], [0.7, 0.7, 0.7]]), np.array([0.2, 0.2])
    points = starts_of(room_of(), (half, half), placed, 0.3, np.random.default_rng(0))
    apart = np.linalg.norm(points[:, None] - placed[0], axis=2)
    assert apart.min() >= 0.2


def test_classes_are_octaves_of_size_the_largest_first():
    sizes = np.array([0.1, 0.04, 0.09, 0.02, 0.05])
    assert [each.tolist() for each in start_classes(sizes)] == [[0, 2], [1, 4], [3]]


def test_the_largest_void_comes_first():
    placed = np.array([[0.25, 0.25, 0.25], [0.25, 0.75, 0.25]]), np.array([0.2, 0.2])
    points = voids(room_of(), np.full(3, 0.1), 0.1, placed, np.random.default_rng(0))
    assert len(points) == 3
    # Along y the void is nearly as wide everywhere. 20 seeds: 0.88 +- 0.01 and 0.89 +- 0.01, from 0.85 on.
    assert points[0, [0, 2]] == pytest.approx([0.9, 0.9], abs=0.1)
    apart = np.linalg.norm(points[:, None] - points, axis=2)[np.triu_indices(3, 1)]
    assert apart.min() >= 0.2
