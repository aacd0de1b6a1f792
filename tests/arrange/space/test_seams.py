"""Pairs across the seams of a periodic box: found as by brute force, pushed as all others, in both forms."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from packgen.arrange.neighbors.seam_pairs import SeamPairs, seam_pairs
from packgen.arrange.projection.numba_layer import FusedLayer
from packgen.arrange.projection.pair_rules import list_reach
from packgen.arrange.projection.recipe import Recipe, Step
from packgen.arrange.projection.settle import settle
from packgen.arrange.projection.torch_layer import PlainLayer
from packgen.arrange.space.seams import NO_SEAMS, Seams
from packgen.arrange.space.walls import wall_table
from packgen.geometry import Box
from tests.scenes import box, constant, read_scene

DOWN = np.array([0.0, 0.0, -1.0])
ASKEW = np.array([0.1, 0.2, -1.0])
AXES = st.sampled_from([each for each in product((0.0, 1.0), repeat=3) if any(each)])


def walls_of(seams, low=(0.0, 0.0, 0.0), high=(1.0, 1.0, 1.0), radius_max=0.06):
    bounds = np.array([low, high], float)
    return wall_table([Box(*bounds)], bounds, radius_max, seams)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(axes=AXES, seed=st.integers(0, 2**32 - 1), ratio=st.sampled_from([1.0, 3.0, 20.0]),
       skin=st.sampled_from([0.0, 0.8]), far=st.sampled_from([0.0, -7.0, 1e3]))  # fmt: skip
def test_the_pairs_across_seams_are_those_of_brute_force(axes, seed, ratio, skin, far):
    rng = np.random.default_rng(seed)
    count, period = int(rng.integers(1, 120)), np.array([4.0, 5.0, 9.0]) * axes
    radius = rng.choice([1.0, 1.0 / ratio], count) * rng.uniform(0.9, 1.0, count)
    seams = Seams(np.full(3, far), period)
    position = seams.low + rng.random((count, 3)) * [4.0, 5.0, 9.0]
    moving = int(rng.integers(0, count + 1))
    ball = np.column_stack([position, radius])
    reach = list_reach(ball, moving, skin, 1.0)
    found = SeamPairs(*seam_pairs(ball, reach, moving, seams))
    listed = sorted(
        (min(i, j), max(i, j), *np.round(np.sign(j - i) * offset + 0.0, 6))
        for i, j, offset in zip(found.first, found.second, found.offset, strict=True)
    )
    expected = []
    for steps in product((-1, 0, 1), repeat=3):
        shift = np.array(steps) * period
        if not shift.any() or (np.array(steps) * (period == 0.0)).any():
            continue
        for i in range(count):
            distance = np.linalg.norm(position[i] - (position[i + 1 :] + shift), axis=1)
            close = distance < reach[i] + reach[i + 1 :]
            later = np.flatnonzero(close) + i + 1
            expected += [(i, j, *np.round(shift + 0.0, 6)) for j in later if i < moving]
    assert listed == sorted(expected)


@pytest.mark.parametrize("axes", [(1, 0, 0), (0, 1, 1), (1, 1, 1)])
@pytest.mark.parametrize(("ratio", "friction"), [(1.0, 0.0), (3.0, 0.0), (1.0, 0.4)])
def test_the_fused_loops_equal_the_plain_torch_form_across_seams(axes, ratio, friction):
    rng = np.random.default_rng(3)
    radius = np.where(rng.random(300) < 0.15, 0.06, 0.06 / ratio)
    ball = np.column_stack([rng.random((300, 3)), radius])
    walls = walls_of(Seams(np.zeros(3), np.array(axes, float)))
    fused_layer = FusedLayer(ball.copy(), 200, walls, rubs=friction > 0.0)
    layers = fused_layer, PlainLayer(ball.copy(), 200, walls, "torch")
    step = Step(0.8, 1.0, 0.2, friction=friction, grip=0.3)
    for number in range(12):
        if number % 5 == 0:
            for layer in layers:
                layer.rebuild(0.8)
        fall = DOWN * 0.06 * 0.02 if number < 6 else 0.0 * DOWN
        fused, plain = (layer.sweep(fall, step) for layer in layers)
        assert fused[0] == pytest.approx(plain[0], rel=1e-9)
        assert fused[1] == plain[1]
    for layer in layers:
        layer.rebuild(1.6)
    assert len(layers[0].lists[0].seam.first) > 0
    (fused, fused_blame), (plain, plain_blame) = (layer.overlaps(1.02, ASKEW) for layer in layers)
    assert fused == pytest.approx(plain, rel=1e-9)
    in_order = [np.argsort(layer.identity) for layer in layers]
    assert np.allclose(fused_blame[in_order[0]], plain_blame[in_order[1]], rtol=1e-7, atol=1e-11)
    end = [layer.positions()[order] for layer, order in zip(layers, in_order, strict=True)]
    assert np.abs(end[0] - end[1]).max() < 1e-11
    inside = (end[0] >= 0.0) & (end[0] < 1.0)
    assert inside[:, np.array(axes, bool)].all()


@pytest.mark.parametrize("form", ["fused", "plain"])
def test_a_pair_across_a_corner_parts_by_mass_and_the_smaller_sphere_is_blamed(form):
    step = 0.98 / np.sqrt(3.0) * 0.3  # 2 % of the reach of 0.3 is overlap
    ball = np.array([[0.0, 0.0, 0.0, 0.1], [*(1.0 - step * np.ones(3)), 0.2], [0.5, 0.5, 0.5, 0.05]])
    walls = walls_of(Seams(np.zeros(3), np.ones(3)), radius_max=0.2)
    layer = FusedLayer(ball.copy(), 2, walls) if form == "fused" else PlainLayer(ball, 2, walls, "torch")
    layer.rebuild(0.5)
    worst, blame = layer.overlaps(1.0, DOWN)
    assert worst == pytest.approx(0.06)
    assert blame[np.argsort(layer.identity)] == pytest.approx([0.06, 0.0]), "the smaller one goes"
    worst, _ = layer.sweep(0.0 * DOWN, Step(0.0, 1.0, 0.2))
    assert worst == pytest.approx(0.06)
    moved = layer.positions()[np.argsort(layer.identity)] - ball[:2, :3]
    moved -= np.round(moved)
    along = 0.006 / np.sqrt(3.0)
    assert moved == pytest.approx(np.array([[8 / 9] * 3, [-1 / 9] * 3]) * along)


@pytest.mark.parametrize("device", ["cpu", "torch"])
def test_what_is_kept_overlaps_nothing_across_any_seam(device):
    rng = np.random.default_rng(1)
    ball = np.column_stack([rng.random((90, 3)), rng.uniform(0.06, 0.12, 90)])
    seams = Seams(np.zeros(3), np.ones(3))
    position, kept = settle(
        ball, 80, walls_of(seams, radius_max=0.12), DOWN, Recipe(), sink=False, device=device
    )
    everything = np.concatenate([np.column_stack([position, ball[:80, 3]])[kept], ball[80:]])
    apart = everything[:, None, :3] - everything[None, :, :3]
    distance = np.linalg.norm(apart - np.round(apart), axis=2)
    reach = everything[:, None, 3] + everything[None, :, 3]
    overlap = (reach - distance)[np.triu_indices(len(everything), 1)]
    one_moves = np.triu_indices(len(everything), 1)[0] < kept.sum()
    assert kept.sum() > 60
    assert overlap[one_moves].max() <= 1e-6 * 0.12


def test_points_are_wrapped_into_the_box_and_those_inside_keep_every_digit():
    seams = Seams(np.array([1.0, -2.0, 0.0]), np.array([0.5, 0.0, 3.0]))
    tiny = np.nextafter(0.0, -1.0)
    points = np.array([[1.1, 9.0, 2.9], [1.5, -9.0, 3.0], [0.9, 0.0, -7.0], [2.7, 0.0, tiny]])
    wrapped = seams.wrapped(points)
    assert np.array_equal(wrapped[0], points[0])
    assert wrapped == pytest.approx(np.array([[1.1, 9.0, 2.9], [1, -9, 0], [1.4, 0, 2], [1.2, 0, 0]]))
    assert (wrapped[:, [0, 2]] < [1.5, 3.0]).all()
    assert (wrapped[:, [0, 2]] >= [1.0, 0.0]).all()
    assert np.array_equal(NO_SEAMS.wrapped(points), points)


def test_a_tree_measures_across_the_seams():
    seams = Seams(np.array([-1.0, 0.0, 0.0]), np.array([2.0, 0.0, 4.0]))
    tree = seams.tree(np.array([[0.9, 7.0, 0.1], [-0.5, 7.0, 2.0]]))
    distance, index = tree.query(seams.placed(np.array([[-0.9, 7.0, 3.9]])))
    assert distance == pytest.approx([np.sqrt(0.2**2 + 0.2**2)])
    assert index == [0]


@pytest.mark.parametrize("form", ["fused", "plain"])
def test_a_sphere_taken_out_touches_nothing_neither_across_a_seam_nor_a_wall(form):
    rng = np.random.default_rng(8)
    ball = np.column_stack([rng.random((120, 3)), np.full(120, 0.1)])
    walls = walls_of(Seams(np.zeros(3), np.array([1.0, 0.0, 0.0])), radius_max=0.1)
    out = rng.random(80) < 0.4

    def run(spheres, moving, taken):
        layer = (
            FusedLayer(spheres.copy(), moving, walls)
            if form == "fused"
            else PlainLayer(spheres, moving, walls, "torch")
        )
        layer.rebuild(0.8)
        layer.take_out(taken[layer.identity])
        results = [layer.sweep(DOWN * 1e-3, Step(0.8, 1.0, 0.2, 0.3)) for _ in range(3)]
        overlaps = layer.overlaps(1.0, ASKEW)[0]
        layer.rebuild(0.8)
        position = np.full((moving, 3), np.nan)
        position[layer.identity] = layer.positions()
        return results, overlaps, position

    taken = run(ball, 80, out)
    assert np.isnan(taken[2][out]).all()
    # As if they had never been; the others keep their numbers, by which walls are rough to them.
    away = ball.copy()
    away[:80][out, 1] = 500.0 + 3.0 * np.arange(out.sum())
    never = run(away, 80, np.zeros(80, bool))
    assert np.allclose(taken[2][~out], never[2][~out], rtol=0.0, atol=1e-12)
    assert [worst for worst, _ in taken[0]] == pytest.approx([worst for worst, _ in never[0]])


@pytest.mark.parametrize("seed", range(3))
def test_a_point_on_a_side_is_written_at_the_lower_one_and_none_beyond_the_upper_one(seed, tmp_path):
    _, unit = read_scene(tmp_path, box([0, 0, 0], [1, 1, 1]) | {"periodic": ["x"]}, constant(0.1))
    rng = np.random.default_rng(seed)
    for low, high in np.sort(rng.choice(np.arange(-999, 1000) / 1000.0, (300, 2)), axis=1):
        if low == high:
            continue
        vessel = replace(unit, bounds=np.array([[low, 0.0, 0.0], [high, 1.0, 1.0]]))
        position = np.zeros((6, 3))
        below, above = np.nextafter([low, high], -1.0), np.nextafter(high, 1.0)
        position[:, 0] = [low, below[0], below[1], high, above, low - 1e-300]
        found = Seams.of(vessel).wrapped(position)[:, 0]
        assert (found >= low).all()
        assert (found < high).all()
        assert found[0] == low
        assert found[3] - low < 1e-15
