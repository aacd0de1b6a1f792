"""What ``settle`` promises: no overlap, nothing shrunk, nothing fixed moved, and the same again."""

from __future__ import annotations

import dataclasses
from functools import cache

import numpy as np
import pytest
from scipy.spatial import cKDTree

from packgen.arrange.projection.numba_layer import FusedLayer
from packgen.arrange.projection.recipe import Recipe
from packgen.arrange.projection.settle import SettleStats, settle
from packgen.arrange.projection.stepwise import throw_back
from packgen.arrange.projection.throw_back import spheres_to_go
from packgen.arrange.space.seams import Seams
from packgen.arrange.space.walls import wall_table
from packgen.geometry import Box, Cone, Slice
from packgen.portable import octaves
from tests.seeds import raised

DOWN = np.array([0.0, 0.0, -1.0])
TOLERANCE = 1e-6


def walls_of(*shapes, radius_max=0.1, low=(0, 0, 0), high=(1, 1, 1)):
    return wall_table(shapes, np.array([low, high], float), radius_max)


@cache
def cube():
    return walls_of(Box([0, 0, 0], [1, 1, 1]))


def crowd(count, seed=0, low=0.05, high=0.08, fixed=()):
    """Random spheres, overlapping, over a floor of fixed ones."""
    rng = np.random.default_rng(raised(seed))
    ball = np.column_stack([rng.uniform(0.1, 0.9, (count, 3)), rng.uniform(low, high, count)])
    return np.concatenate([ball, np.reshape(fixed, (-1, 4))])


def floor_of_spheres(radius=0.1):
    middles = np.arange(radius, 1.0, 2 * radius)
    x, y = (each.ravel() for each in np.meshgrid(middles, middles))
    return np.column_stack([x, y, np.full(x.size, radius), np.full(x.size, radius)])


def depths(position, radius, others=None):
    """Overlap of every pair over the smaller radius; with ``others`` (k, 4), of each with each of them."""
    if others is None:
        distance = np.linalg.norm(position[:, None] - position[None], axis=2)
        reach, smaller = radius[:, None] + radius[None], np.minimum(radius[:, None], radius[None])
        return ((reach - distance) / smaller)[np.triu_indices(len(radius), 1)]
    distance = np.linalg.norm(position[:, None] - others[None, :, :3], axis=2)
    return (
        (radius[:, None] + others[None, :, 3] - distance) / np.minimum(radius[:, None], others[None, :, 3])
    ).ravel()


@pytest.mark.parametrize("sink", [True, False])
@pytest.mark.parametrize("high", [0.08, 0.02])
def test_what_is_kept_overlaps_nothing(sink, high):
    fixed = floor_of_spheres()
    ball = crowd(150, low=0.01 if high < 0.05 else 0.05, high=high, fixed=fixed)
    before = ball.copy()
    position, kept = settle(ball, 150, cube(), DOWN, Recipe(), sink=sink)
    assert np.array_equal(ball, before), "what was given is as it was: radii, and the fixed spheres"
    assert kept.sum() > 142  # 20 seeds: 146 to 150.
    position, radius = position[kept], ball[:150, 3][kept]
    assert depths(position, radius).max() <= TOLERANCE
    assert depths(position, radius, fixed).max() <= TOLERANCE
    assert (
        np.minimum(position - radius[:, None], 1.0 - position - radius[:, None]).min()
        >= -TOLERANCE * radius.max()
    )


def test_only_spheres_that_do_not_fit_are_thrown_back_and_counted():
    stats = SettleStats()
    ball = crowd(900, low=0.06, high=0.06)  # solid fraction 0.81, random packings reach 0.64, less at walls
    position, kept = settle(ball, 900, cube(), DOWN, Recipe(), stats)
    assert 555 < kept.sum() < 595  # 20 seeds: 568 to 580.
    assert stats.thrown_back == 900 - kept.sum()
    assert np.isfinite(position).all()
    assert depths(position[kept], ball[kept, 3]).max() <= TOLERANCE


def test_a_sphere_with_nowhere_to_go_is_thrown_back_and_its_cage_stays():
    cage = np.array([[*(0.5 + 0.11 * np.array(d)), 0.06] for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)])
    cage[:, :3] -= 0.11
    ball = np.concatenate([[[0.5, 0.5, 0.5, 0.09]], cage])
    _, kept = settle(ball, 1, cube(), DOWN, Recipe())
    assert not kept[0]


def test_the_same_start_gives_the_same_end_bit_for_bit():
    first, second = (settle(crowd(200), 200, cube(), DOWN, Recipe()) for _ in range(2))
    assert np.array_equal(first[0], second[0])
    assert np.array_equal(first[1], second[1])


def test_a_layer_that_gives_signals_their_turn_ever_so_often_is_the_same_one(monkeypatch):
    whole = settle(crowd(200), 200, cube(), DOWN, Recipe())
    lengths, run = [], FusedLayer.run

    def counted(layer, down, schedule, strays):
        lengths.append(len(schedule.fall))
        return run(layer, down, schedule, strays)

    monkeypatch.setattr(FusedLayer, "run", counted)
    monkeypatch.setattr("packgen.arrange.projection.settle.STEPS_MAX", 1400)
    stats = SettleStats()
    in_turns = settle(crowd(200), 200, cube(), DOWN, Recipe(), stats)
    assert max(lengths) == 7
    assert sum(lengths) >= stats.sweeps > 100
    assert np.array_equal(whole[0], in_turns[0])
    assert np.array_equal(whole[1], in_turns[1])


def test_without_sinking_spheres_that_touch_nothing_stay_where_they_are():
    ball = np.array(
        [[0.3, 0.3, 0.9, 0.05], [0.7, 0.7, 0.5, 0.05], [0.3, 0.7, 0.5, 0.05], [0.33, 0.7, 0.5, 0.05]]
    )
    position, kept = settle(ball, 4, cube(), DOWN, Recipe(), sink=False)
    assert kept.all()
    assert np.array_equal(position[:2], ball[:2, :3])
    assert not np.array_equal(position[2], ball[2, :3])


def test_a_lone_sphere_sinks_by_the_recipes_steps_until_it_lies_on_the_floor():
    ball = np.array([[0.5, 0.5, 0.2, 0.1]])
    position, kept = settle(ball, 1, cube(), DOWN, Recipe())
    assert kept[0]
    assert position[0, :2] == pytest.approx([0.5, 0.5])
    assert position[0, 2] == pytest.approx(0.1, rel=1e-3)


def test_no_tolerance_leaves_the_layer_as_the_sinking_left_it():
    recipe = dataclasses.replace(Recipe(), tolerance=None)
    ball = crowd(300, low=0.08, high=0.08)
    position, kept = settle(ball, 300, cube(), DOWN, recipe)
    assert kept.all()
    assert depths(position, ball[:, 3]).max() > 0.2  # 20 seeds: 0.37 to 0.58.


def test_an_empty_layer_is_done_at_once():
    position, kept = settle(np.empty((0, 4)), 0, cube(), DOWN, Recipe())
    assert position.shape == (0, 3)
    assert kept.shape == (0,)


def test_cones_and_slices_hold_their_spheres():
    cone = Cone([0.5, 0.5, 0.0], [0.0, 0.0, 1.0], 1.0, 0.2, 0.5)
    sheet = Slice([0.0, 0.0, 1.0], 0.3, 0.6, centers_only=True)
    ball = crowd(60)
    ball[:, :3] = 0.5 + 0.3 * (ball[:, :3] - 0.5)
    position, kept = settle(ball, 60, walls_of(cone, sheet), DOWN, Recipe())
    position, radius = position[kept], ball[kept, 3]
    assert kept.sum() > 53  # 20 seeds: 57 to 60.
    off = np.hypot(*(position[:, :2] - 0.5).T)
    room = ((0.2 + 0.3 * position[:, 2]) - off) / np.hypot(1.0, 0.3) - radius
    assert room.min() >= -TOLERANCE * radius.max()
    assert position[:, 2].min() >= 0.3 - TOLERANCE * radius.max()
    assert position[:, 2].max() <= 0.6 + TOLERANCE * radius.max()


@pytest.mark.parametrize("sink", [True, False])
def test_plain_torch_settles_as_well(sink):
    ball = crowd(60)
    position, kept = settle(ball, 60, cube(), DOWN, Recipe(), sink=sink, device="torch")
    assert kept.sum() > 56  # 20 seeds: 60.
    assert depths(position[kept], ball[kept, 3]).max() <= TOLERANCE


SINGLE = np.empty(0, np.int64)  # each sphere is a body


class Crowd:
    """As much of a layer as throwing back needs."""

    def __init__(self, position, radius=1.0):
        self.position, self.moving, self.out = position, len(position), None
        self.identity = np.arange(self.moving)
        self.radius = np.full(len(position), radius)

    def positions(self):
        return self.position

    def radii(self):
        return self.radius

    def take_out(self, out):
        self.out = out


def test_of_spheres_squeezed_together_only_the_worst_is_thrown_back():
    crowd = Crowd(np.array([[0.0, 0, 0], [1.5, 0, 0], [3.0, 0, 0], [50.0, 0, 0], [80.0, 0, 0]]))
    blame = np.array([0.2, 0.3, 0.1, 0.05, 0.001])
    assert throw_back(crowd, blame, 0.01, 1.0, SINGLE) == 2
    assert np.flatnonzero(crowd.out).tolist() == [1, 3]
    assert throw_back(crowd, blame, 0.01, 0.2, SINGLE) == 1
    assert np.flatnonzero(crowd.out).tolist() == [1]
    alike = Crowd(np.array([[0.0, 0, 0], [1.5, 0, 0]]))
    assert throw_back(alike, np.array([0.2, 0.2]), 0.01, 1.0, SINGLE) == 1


def test_large_spheres_that_touch_are_thrown_back_singly_despite_small_ones_between():
    position = np.array([[0.0, 0, 0], [19.0, 0, 0], *([500.0 + 9 * k, 0, 0] for k in range(50))])
    crowd = Crowd(position, np.where(position[:, 0] < 500.0, 10.0, 1.0))
    blame = np.zeros(52)
    blame[:2] = 0.2, 0.1
    assert throw_back(crowd, blame, 0.01, 0.05, SINGLE) == 1
    assert np.flatnonzero(crowd.out).tolist() == [0]


def worst_by_tree(position, radius, blame, limit, most):
    """Who goes, by scipy's trees and sorting: octave by octave of radius, of equals the first."""
    out = np.flatnonzero(blame > limit)
    octave = octaves(radius[out].max() / radius[out], slack=0.0)
    first, second = cKDTree(position[out]).query_pairs(4.0 * radius[out].max(), output_type="ndarray").T
    first, second = (
        np.where(octave[first] <= octave[second], first, second),
        np.where(octave[first] <= octave[second], second, first),
    )
    distance = np.linalg.norm(position[out[first]] - position[out[second]], axis=1)
    near = distance <= 2.0 * (radius[out[first]] + radius[out[second]])
    worst = np.ones(len(out), bool)
    worst[np.where(blame[out[first]] < blame[out[second]], first, second)[near]] = False
    out = out[worst]
    return np.sort(out[np.argsort(-blame[out], kind="stable")[:most]]).tolist()


@pytest.mark.parametrize("count", [1, 2, 40, 600])
@pytest.mark.parametrize("radii", [(1.0,), (0.004, 0.007, 0.01, 0.03, 0.08)])
@pytest.mark.parametrize("levels", [3, 1000])
def test_who_is_thrown_back_is_what_trees_and_sorting_say(count, radii, levels):
    rng = np.random.default_rng(count)
    radius = 0.02 * np.array(radii)[rng.integers(0, len(radii), count)] / max(radii)
    position = np.round(rng.random((count, 3)), 2)
    blame = rng.integers(0, levels, count) / levels  # many are blamed alike
    blame[0] = 0.9
    for limit in (0.0, 0.3, 0.8):
        for most in (1, 7, 1000):
            chosen = spheres_to_go(np.column_stack([position, radius]), blame, limit, most)
            expected = worst_by_tree(position, radius, blame, limit, most)
            assert np.flatnonzero(chosen).tolist() == expected


def test_with_a_sphere_its_whole_body_is_thrown_back():
    crowd = Crowd(np.array([[0.0, 0, 0], [50.0, 0, 0], [80.0, 0, 0], [90.0, 0, 0]]))
    blame = np.array([0.0, 0.2, 0.0, 0.0])
    # The layer's own order is not that in which the bodies were given.
    crowd.identity = np.array([3, 0, 1, 2])
    assert throw_back(crowd, blame, 0.01, 1.0, np.array([1, 0, 0, 1])) == 2
    assert np.flatnonzero(crowd.out).tolist() == [0, 1]


def pairs_of_bodies(count, radius=0.05):
    """Bodies of two spheres 1.5 radii apart, and their column."""
    one = crowd(count, 1, radius, radius)
    other = one + 1.5 * radius * np.array([1.0, 0.0, 0.0, 0.0])
    return np.stack([one, other], axis=1).reshape(-1, 4), np.repeat(np.arange(count, dtype=np.int32), 2)


@pytest.mark.parametrize("device", ["cpu", "torch"])
@pytest.mark.parametrize("sink", [True, False])
def test_spheres_of_one_body_may_overlap_and_those_of_two_may_not(sink, device):
    ball, body = pairs_of_bodies(12)
    stats = SettleStats()
    position, kept = settle(ball, 24, cube(), DOWN, Recipe(), stats, sink, device, body)
    assert kept.all()
    assert stats.thrown_back == 0
    first, second = np.triu_indices(24, 1)
    within = body[first] == body[second]
    overlap = depths(position, ball[:, 3])
    assert overlap[~within].max() <= TOLERANCE
    assert overlap[within].max() > 0.1  # 20 seeds: 0.50 to 1.97.


def test_two_spheres_in_one_place_stay_there_where_they_are_one_body():
    ball = np.array([[0.5, 0.5, 0.5, 0.1], [0.5, 0.5, 0.52, 0.1], [0.5, 0.5, 0.1, 0.1]])
    body = np.array([0, 0, 1], np.int32)
    position, kept = settle(ball, 2, cube(), DOWN, Recipe(), sink=False, body_index=body[:2])
    assert kept.all()
    assert np.array_equal(position, ball[:2, :3])


def test_pairs_of_one_body_are_lawful_across_a_seam_too():
    seams = Seams(np.zeros(3), np.array([1.0, 0.0, 0.0]))
    walls = wall_table([Box([0, 0, 0], [1, 1, 1])], np.array([[0.0] * 3, [1.0] * 3]), 0.1, seams)
    ball = np.array([[0.02, 0.5, 0.5, 0.1], [0.98, 0.5, 0.5, 0.1]])
    for device in ("cpu", "torch"):
        position, kept = settle(
            ball, 2, walls, DOWN, Recipe(), sink=False, device=device, body_index=np.zeros(2, np.int32)
        )
        assert kept.all()
        assert np.array_equal(position, ball[:, :3])


def test_a_body_with_nowhere_to_go_is_thrown_back_as_a_whole():
    cage = np.array([[*(0.5 + 0.11 * np.array(d)), 0.06] for d in np.ndindex(3, 3, 3) if d != (1, 1, 1)])
    cage[:, :3] -= 0.11
    ball = np.concatenate([[[0.5, 0.5, 0.5, 0.09], [0.5, 0.5, 0.9, 0.05], [0.2, 0.2, 0.9, 0.05]], cage])
    position, kept = settle(ball, 3, cube(), DOWN, Recipe(), body_index=np.array([0, 0, 1], np.int32))
    assert kept.tolist() == [False, False, True]
    assert np.isfinite(position).all()


def test_a_crowd_of_bodies_loses_none_in_part():
    # Too many even where the two of each body lie in one place: a solid fraction of 0.75.
    ball, body = pairs_of_bodies(350, 0.08)
    stats = SettleStats()
    _, kept = settle(ball, 700, cube(), DOWN, Recipe(), stats, body_index=body)
    assert np.array_equal(kept[::2], kept[1::2])
    assert 0 < kept.sum() < 700  # 20 seeds: 394 to 424.
    assert stats.thrown_back == 700 - kept.sum()


def test_bodies_of_one_sphere_settle_as_spheres_do():
    plain = settle(crowd(200), 200, cube(), DOWN, Recipe())
    single = settle(crowd(200), 200, cube(), DOWN, Recipe(), body_index=np.arange(200, dtype=np.int32))
    assert np.array_equal(plain[0], single[0])
    assert np.array_equal(plain[1], single[1])
