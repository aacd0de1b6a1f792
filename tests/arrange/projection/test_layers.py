"""The fused loops against brute force, independent formulas, and their plain torch form."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from packgen.arrange.projection.layer_kernels import run_sweeps
from packgen.arrange.projection.numba_layer import FusedLayer
from packgen.arrange.projection.pair_rules import list_reach
from packgen.arrange.projection.recipe import SWEEPS_MAX, Recipe, Step
from packgen.arrange.projection.settle import settle
from packgen.arrange.projection.stepwise import run_by_steps
from packgen.arrange.projection.torch_layer import PlainLayer
from packgen.arrange.space.feature_kernels import wall_gap
from packgen.arrange.space.seams import NO_SEAMS, Seams
from packgen.arrange.space.walls import wall_table
from packgen.geometry import Ball, Box, Cone, Mesh, Slice, Surface
from tests.beds import box_surface

DOWN = np.array([0.0, 0.0, -1.0])
ASKEW = np.array([0.1, 0.2, -1.0])  # no two spheres at one height: who is blamed is no matter of order
QUICK = settings(max_examples=60, deadline=None, derandomize=True)


def box_walls(low, high, radius_max):
    bounds = np.array([np.broadcast_to(low, 3), np.broadcast_to(high, 3)], float)
    return wall_table([Box(bounds[0], bounds[1])], bounds, radius_max)


@st.composite
def crowds(draw):
    """Spheres, how many of them move, and a skin: broad and narrow, here and far away, coincident or not."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    count = draw(st.integers(1, 150))
    ratio = draw(st.sampled_from([1.0, 1.5, 4.0, 50.0]))
    form = draw(st.sampled_from(["uniform", "two sizes", "log"]))
    if form == "uniform":
        radius = rng.uniform(1.0, ratio, count)
    elif form == "two sizes":
        radius = np.where(rng.random(count) < 0.2, ratio, 1.0)
    else:
        radius = ratio ** rng.random(count)
    side = draw(st.sampled_from([0.0, 2.0, 12.0, 300.0]))
    extent = side * np.array(draw(st.sampled_from([(1, 1, 1), (1, 1, 0.01), (10, 0.01, 0.01)])))
    position = rng.random((count, 3)) * extent
    if draw(st.booleans()):
        position = np.round(position)
    position += draw(st.sampled_from([0.0, -1e3, 1e6]))
    return (
        np.column_stack([position, radius]),
        draw(st.integers(0, count)),
        draw(st.sampled_from([0.0, 0.3, 0.8])),
    )


def listed_pairs(layer):
    """The owners and the others of a layer's pairs, in the layer's own order."""
    owner, other = layer.lists[0].pairs
    return owner, other[: len(owner)]


@QUICK
@given(crowds())
def test_the_neighbour_list_is_that_of_brute_force(crowd):
    ball, moving, skin = crowd
    layer = FusedLayer(ball.copy(), moving, box_walls(-1.0, 1.0, 1.0))
    layer.rebuild(skin)
    assert sorted(map(tuple, layer.ball)) == sorted(map(tuple, ball))
    assert np.array_equal(layer.ball[:moving], ball[layer.identity])
    owner, other = listed_pairs(layer)
    listed = {(min(a, b), max(a, b)) for a, b in zip(owner.tolist(), other.tolist(), strict=True)}
    assert len(listed) == len(owner), "a pair is listed twice"
    position = layer.ball[:, :3]
    first, second = np.triu_indices(len(ball), 1)
    distance = np.linalg.norm(position[first] - position[second], axis=1)
    each = list_reach(layer.ball, moving, skin, layer.state.reference)
    reach = each[first] + each[second]
    for slack, are_subset in ((-1e-9, True), (1e-9, False)):
        near = (distance < reach * (1.0 + slack)) & (first < moving)
        pairs = set(zip(first[near].tolist(), second[near].tolist(), strict=True))
        assert pairs <= listed if are_subset else listed <= pairs


SHAPES = {
    "box": [Box([0, 0, 0], [1, 1, 1])],
    "cone": [Cone([0.5, 0.5, 0], [0, 0, 1], 1.0, 0.3, 0.6)],
    "ball": [Ball([0.5, 0.5, 0.5], 0.55)],
    "slices": [
        Box([0, 0, 0], [1, 1, 1]),
        Slice([0, 0, 1], 0.2, 0.8, centers_only=True),
        Slice([0.6, 0.8, 0], 0.3, 1.1, centers_only=False),
    ],
    "triangles": [Mesh(box_surface([0, 0, 0], [1, 1, 1]))],
}


@pytest.mark.parametrize("shapes", SHAPES.values(), ids=SHAPES)
@pytest.mark.parametrize(("ratio", "friction"), [(1.0, 0.0), (6.0, 0.0), (1.0, 0.4), (3.0, 0.4)])
def test_the_fused_loops_equal_the_plain_torch_form_to_rounding(shapes, ratio, friction):
    rng = np.random.default_rng(3)
    radius = np.where(rng.random(300) < 0.15, 0.06, 0.06 / ratio)
    ball = np.column_stack([rng.uniform(0.1, 0.9, (300, 3)), radius])
    walls = wall_table(shapes, np.array([[0.0] * 3, [1.0] * 3]), 0.06)
    fused_layer = FusedLayer(ball.copy(), 200, walls, rubs=friction > 0.0)
    layers = fused_layer, PlainLayer(ball.copy(), 200, walls, "torch")
    for number in range(12):
        if number % 5 == 0:
            for layer in layers:
                layer.rebuild(0.8)
        fall = DOWN * 0.06 * 0.02 if number < 6 else 0.0 * DOWN
        step = Step(0.8, 1.0, 0.2, max(0.0, 0.5 - 0.1 * number), friction=friction, grip=0.3)
        fused, plain = (layer.sweep(fall, step) for layer in layers)
        assert fused[0] == pytest.approx(plain[0], rel=1e-9)
        assert fused[1] == plain[1]
    for layer in layers:
        layer.rebuild(0.3)
    (fused, fused_blame), (plain, plain_blame) = (layer.overlaps(1.02, ASKEW) for layer in layers)
    assert fused == pytest.approx(plain, rel=1e-9)
    assert fused > 0.0
    in_order = [np.argsort(layer.identity) for layer in layers]
    assert np.allclose(fused_blame[in_order[0]], plain_blame[in_order[1]], rtol=1e-7, atol=1e-11)
    end = [layer.positions()[order] for layer, order in zip(layers, in_order, strict=True)]
    assert np.abs(end[0] - end[1]).max() < 1e-11
    assert np.abs(end[0] - ball[:200, :3]).max() > 0.01


def bounds_of(kind, radius_max):
    bounds = np.array([[0.0] * 3, [1.0] * 3])
    seams = Seams(np.zeros(3), np.array([1.0, 0.0, 1.0])) if kind == "periodic" else NO_SEAMS
    return wall_table(SHAPES["triangles" if kind == "mesh" else "box"], bounds, radius_max, seams)


def outcome(layer, tallies):
    """All that a run leaves, bit for bit."""
    pairs, seam = layer.lists[0].pairs, layer.lists[0].seam
    listed = pairs.owner, pairs.neighbor[: len(pairs.owner)], *seam
    return tallies, [each.tobytes() for each in (*spheres_of(layer), *listed)]


def spheres_of(layer):
    """The spheres of a layer as they are, fixed ones included."""
    return layer.ball, layer.previous, layer.identity, layer.state.weight[: layer.now.total]


@pytest.mark.parametrize("kind", ["box", "mesh", "periodic"])
@pytest.mark.parametrize("bodies", [False, True])
@pytest.mark.parametrize(
    ("first", "sink", "tolerance"),
    [(0, True, 1e-6), (0, True, None), (119, True, 1e-6), (224, True, None), (105, False, 1e-6)],
)
def test_a_run_of_sweeps_is_the_steps_one_by_one(kind, bodies, first, sink, tolerance):
    recipe = Recipe(tolerance=tolerance)
    rng = np.random.default_rng(first)
    ball = np.column_stack([rng.random((320, 3)), rng.uniform(0.06, 0.1, 320)])
    body = np.repeat(np.arange(150), 2) if bodies else np.empty(0, np.int64)
    outcomes = []
    for by_steps in (False, True):
        layer = FusedLayer(ball.copy(), 300, bounds_of(kind, 0.1), body)
        number, strays, tallies = first, 300, []
        for most in (7, 40, 500):
            schedule = recipe.schedule(number, sink=sink, most=most)
            if by_steps:
                tally = run_by_steps(layer, DOWN, schedule, strays, layer.state.reference, body)
            else:
                tally = layer.run(DOWN, schedule, strays)
            tallies.append(tally)
            number, strays = number + tally.sweeps, tally.strays
            if tally.done or number >= recipe.sink_sweeps:
                break
        outcomes.append(outcome(layer, tallies))
    assert outcomes[0] == outcomes[1]
    assert sum(tally.rebuilds for tally in outcomes[0][0]) > 0
    assert tolerance is None or sum(tally.thrown_back for tally in outcomes[0][0]) > 0


def run_of(ball, moving, walls, body, recipe, threads, turns=(7, 40, 500)):
    """What a layer is after some runs, and what was done in each."""
    layer = FusedLayer(ball.copy(), moving, walls, body, threads, rubs=recipe.friction > 0.0)
    number, strays, tallies = 0, moving, []
    for most in turns:
        tally = layer.run(DOWN, recipe.schedule(number, sink=True, most=most), strays)
        tallies.append(tally)
        number, strays = number + tally.sweeps, tally.strays
        if tally.done or number >= recipe.sink_sweeps:
            break
    return tallies, [each.tobytes() for each in spheres_of(layer)]


@pytest.mark.parametrize("kind", ["box", "mesh", "periodic"])
@pytest.mark.parametrize("bodies", [False, True])
@pytest.mark.parametrize(
    ("small", "friction"), [(1.0, 0.0), (0.25, 0.0), (0.04, 0.0), (1.0, 0.4), (0.25, 0.4)]
)
def test_any_number_of_threads_makes_the_same_layer(kind, bodies, small, friction):
    rng = np.random.default_rng(7)
    # Small spheres are of other levels than the fixed large ones, which own pairs then.
    radius = np.where(rng.random(420) < 0.6, small, 1.0) * rng.uniform(0.06, 0.1, 420)
    ball = np.column_stack([rng.random((420, 3)), radius])
    body = np.repeat(np.arange(195), 2) if bodies else np.empty(0, np.int64)
    walls, recipe = bounds_of(kind, 0.1), Recipe(friction=friction)
    alone = run_of(ball, 390, walls, body, recipe, 1)
    assert small < 1.0 or sum(tally.thrown_back for tally in alone[0]) > 0
    for threads in (2, 3, 7):
        assert run_of(ball, 390, walls, body, recipe, threads) == alone


@pytest.mark.parametrize("extent", [(1.0, 1.0, 1.0), (1.0, 9.0, 0.5), (9.0, 1.0, 0.5), (0.0, 0.0, 0.0)])
def test_the_threads_of_a_layer_share_its_spheres_and_list_what_each_needs(extent):
    rng = np.random.default_rng(3)
    ball = np.column_stack([rng.random((240, 3)) * extent, rng.uniform(0.02, 0.1, 240)])
    walls = box_walls(-1.0, 10.0, 0.1)
    whole, parts = (FusedLayer(ball.copy(), 200, walls, None, threads) for threads in (1, 4))
    for layer in (whole, parts):
        layer.rebuild(0.8)
    listed = np.column_stack(listed_pairs(whole))
    own = [lists.own for lists in parts.lists]
    assert np.array_equal(np.sort(np.concatenate(own)), np.arange(200))
    for lists in parts.lists:
        needed = np.isin(listed, lists.own).any(axis=1)
        owner, other = lists.pairs
        assert np.array_equal(np.column_stack([owner, other[: len(owner)]]), listed[needed])


def test_all_layers_run_on_one_compiled_loop():
    # A second kind of array would have all of it compiled once more.
    for kind in ("box", "mesh", "periodic"):
        for fixed in (0, 20):
            ball = np.random.default_rng(fixed).random((40, 4)) * 0.08 + np.array([0.4, 0.4, 0.4, 0.02])
            down = DOWN if fixed else np.broadcast_to(DOWN, (3, 3))[1]
            body = np.repeat(np.arange(20, dtype=np.int32), 2)[: 40 - fixed] if fixed else None
            settle(ball, 40 - fixed, bounds_of(kind, 0.1), down, Recipe(), body_index=body)
    assert len(run_sweeps.signatures) == 1


def test_layers_run_in_threads_as_one_after_the_other():
    walls = bounds_of("box", 0.1)
    balls = [
        np.column_stack([rng.random((150, 3)), rng.uniform(0.05, 0.1, 150)])
        for rng in map(np.random.default_rng, range(6))
    ]

    def arranged(ball):
        position, kept = settle(ball, 120, walls, DOWN, Recipe())
        return position.tobytes(), kept.tobytes()

    with ThreadPoolExecutor(3) as threads:
        assert list(threads.map(arranged, balls)) == [arranged(ball) for ball in balls]


def test_schedules_follow_the_recipe_sweep_by_sweep():
    recipe = Recipe()
    for first in (0, 1, SWEEPS_MAX - 1, SWEEPS_MAX, 130, 300):
        schedule = recipe.schedule(first, sink=True, most=200)
        assert schedule.first == first
        for place in range(len(schedule.fall)):
            number = first + place
            step = recipe.step(number, rough=True)
            assert schedule.fall[place] == recipe.fall(number)
            assert (schedule.momentum[place], schedule.roughness[place]) == (step.momentum, step.roughness)
            assert schedule.far[place] == step.far
            limit = recipe.too_much(number + 1)
            assert schedule.limit[place] == (np.inf if limit is None else limit)
            assert schedule.skin[place] == recipe.skin(number)
            assert schedule.sinking[place] == (number < recipe.sink_sweeps)
            assert schedule.strays[place] == recipe.strays_allowed(number)
    unjudged = Recipe(tolerance=None).schedule(224, sink=True)
    assert len(unjudged.fall) == 1  # it ends with the sinking


@pytest.mark.parametrize("layer_type", ["fused", "plain"])
def test_a_pair_is_parted_by_its_masses_and_a_fixed_sphere_stays(layer_type):
    ball = np.array([[0.0, 0, 0, 1.0], [2.9, 0, 0, 2.0], [0.0, 3.0, 0.0, 2.0], [9.0, 9.0, 9.0, 1.0]])
    walls = box_walls(-50.0, 50.0, 2.0)
    layer = (
        FusedLayer(ball.copy(), 2, walls) if layer_type == "fused" else PlainLayer(ball, 2, walls, "torch")
    )
    layer.rebuild(0.5)
    worst, _ = layer.sweep(0.0 * DOWN, Step(0.0, 1.0, 0.2))
    assert worst == pytest.approx(0.1)
    moved = layer.positions()[np.argsort(layer.identity)] - ball[:2, :3]
    assert moved == pytest.approx(np.array([[-0.1 * 8 / 9, 0, 0], [0.1 / 9, 0, 0]]))


@pytest.mark.parametrize("layer_type", ["fused", "plain"])
def test_spheres_that_outrun_the_list_are_counted_and_one_that_did_by_far_as_all(layer_type):
    ball = np.array([[3.0 * i, 0.0, 0.0, 1.0] for i in range(5)])
    walls = box_walls(-50.0, 50.0, 1.0)
    layer = (
        FusedLayer(ball.copy(), 5, walls) if layer_type == "fused" else PlainLayer(ball, 5, walls, "torch")
    )
    layer.rebuild(0.2)  # a margin of 0.1
    step = Step(0.0, 1.0, 0.2, 0.0, 2.0)
    strays = [layer.sweep(DOWN * 0.06, step)[1] for _ in range(4)]
    assert strays == [0, 5, 5, 5 + 5 * 5]


@pytest.mark.parametrize("layer_type", ["fused", "plain"])
def test_a_rough_wall_keeps_each_sphere_off_by_a_share_of_its_own_and_gently(layer_type):
    ball = np.array([[3.0 * i, 0.0, 1.0, 1.0] for i in range(12)])
    walls = box_walls(0.0, 50.0, 1.0)
    ball[:, :2] += 5.0
    layer = (
        FusedLayer(ball.copy(), 12, walls) if layer_type == "fused" else PlainLayer(ball, 12, walls, "torch")
    )
    layer.rebuild(2.0)
    step = Step(0.0, 1.0, 0.2, 0.5)
    layer.sweep(0.0 * DOWN, step)
    assert layer.positions()[:, 2].max() <= 1.1 + 1e-12
    for _ in range(20):
        layer.sweep(0.0 * DOWN, step)
    above = np.sort(layer.positions()[:, 2] - 1.0)
    assert 0.0 <= above[0] < 0.1
    assert 0.4 < above[-1] <= 0.5
    assert len(np.unique(above.round(6))) == 12


@pytest.mark.parametrize("layer_type", ["fused", "plain"])
def test_a_rough_wall_of_many_facets_keeps_off_as_gently_as_one_of_few(layer_type):
    bounds = np.array([[0.0] * 3, [12.0] * 3])
    fine = trimesh.creation.box(bounds=bounds).subdivide_to_size(0.4)
    walls = wall_table([Mesh(Surface(fine.vertices, fine.faces))], bounds, 1.0)
    ball = np.array([[2.1 + 2.5 * i, 6.0, 1.0, 1.0] for i in range(4)])
    layer = (
        FusedLayer(ball.copy(), 4, walls) if layer_type == "fused" else PlainLayer(ball, 4, walls, "torch")
    )
    layer.rebuild(2.0)
    layer.sweep(0.0 * DOWN, Step(0.0, 1.0, 0.2, 0.5))
    pushed = layer.positions()[:, 2] - 1.0
    assert 0.05 < pushed.max() <= 0.1 + 1e-12


@pytest.mark.parametrize("shapes", SHAPES.values(), ids=SHAPES)
def test_the_map_of_features_misses_none_in_reach(shapes):
    table = wall_table(shapes, np.array([[0.0] * 3, [1.0] * 3]), 0.05)
    grid, start, item, _ = table.near
    rng = np.random.default_rng(1)
    for point in rng.random((300, 3)):
        cell = np.minimum(((point - grid.origin) / grid.size).astype(int), grid.cells - 1)
        flat = (cell[2] * grid.cells[1] + cell[1]) * grid.cells[0] + cell[0]
        listed = set(item[start[flat] : start[flat + 1]].tolist())
        for feature, (kind, row) in enumerate(zip(*table.features, strict=True)):
            gap = wall_gap(kind, row, *point, 0.0)[0]
            assert gap >= 1.5 * 0.05 or feature in listed
