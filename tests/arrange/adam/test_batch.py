"""One batch of Algorithm 1: against torch's optimizer on the formula as printed, and its own promises."""

import dataclasses

import pytest
import torch

from packgen.arrange.adam import batch as adam
from packgen.arrange.adam.batch import (
    AdamSettings,
    BatchResult,
    NearPairs,
    arrange_batch,
    batch_accepted,
    measure_batch,
)
from packgen.arrange.adam.objective import PlaneWalls, all_pairs_objective, list_pairs

DOWN = torch.tensor([0.0, 0.0, -1.0], dtype=torch.float64)
SHORT = AdamSettings(n_epoch=120, patience=30, plateau_factor=0.5, plateau_patience=5)


def box(size=1.0):
    eye = torch.eye(3, dtype=torch.float64)
    return PlaneWalls(torch.cat((eye, -eye)), torch.tensor([size] * 3 + [0.0] * 3, dtype=torch.float64))


def uniform(seed, low, high, *shape):
    rng = torch.Generator().manual_seed(seed)
    return low + (high - low) * torch.rand(*shape, generator=rng, dtype=torch.float64)


def bed_and_batch(seed=0, count=40, fixed_count=40):
    """A fixed layer in the lower half of a box and a batch above it, both overlapping."""
    height = torch.tensor([1.0, 1.0, 0.5], dtype=torch.float64)
    start = uniform(seed, 0.0, 1.0, count, 3) * height - 0.5 * DOWN
    fixed = uniform(seed + 1, 0.0, 1.0, fixed_count, 3) * height
    return start, uniform(seed + 2, 0.06, 0.1, count), fixed, uniform(seed + 3, 0.06, 0.1, fixed_count)


def algorithm_1(start, radius, fixed_position, fixed_radius, walls, settings):
    """Lines 6 to 18 as printed, line 11 corrected, with torch's optimizer and scheduler."""
    center = torch.nn.Parameter(start.clone())
    optimizer = torch.optim.Adam([center], lr=settings.lr, amsgrad=True)
    scheduler = torch.optim.lr_scheduler.ReduceLROnPlateau(
        optimizer, factor=settings.plateau_factor, patience=settings.plateau_patience, threshold_mode="abs",
        threshold=settings.plateau_threshold * settings.weights.beta * radius.sum().item(), eps=0.0,
    )  # fmt: skip

    def value_and_gradient():
        return all_pairs_objective(
            center.detach(), radius, fixed_position, fixed_radius, walls, DOWN, settings.weights
        )

    now = value_and_gradient()
    best, best_center, unimproved, trace = now.value, start.clone(), 0, []
    while unimproved < settings.patience and len(trace) < settings.n_epoch:
        center.grad = now.gradient
        optimizer.step()
        now = value_and_gradient()
        unimproved += 1
        if now.value < best:
            best, best_center, unimproved = now.value, center.detach().clone(), 0
        scheduler.step(now.value)
        trace.append(now.value.item())
    return best.item(), best_center, trace


@pytest.mark.parametrize("all_pairs", [False, True])
def test_batch_takes_the_steps_of_the_printed_algorithm(all_pairs):
    # few steps: rounding differences grow exponentially in a packing that jams
    settings = dataclasses.replace(SHORT, n_epoch=40)
    spheres, trace = bed_and_batch(), []
    result = arrange_batch(
        *spheres, box(), DOWN, settings, lambda _, value, __: trace.append(value), all_pairs=all_pairs
    )
    best, position, expected = algorithm_1(*spheres, box(), settings)
    assert trace == pytest.approx(expected, rel=1e-9)
    assert result.objective == pytest.approx(best, rel=1e-9)
    torch.testing.assert_close(result.position, position, rtol=0.0, atol=1e-9)


def test_neighbor_lists_leave_the_objective_exact_at_every_step(monkeypatch):
    start, radius, fixed_position, fixed_radius = bed_and_batch(fixed_count=300)
    lists, errors = [], []
    listed, evaluated = adam.list_pairs, adam.objective

    def checked(position, radius, near, pairs, *rest):
        ours = evaluated(position, radius, near, pairs, *rest)
        oracle = all_pairs_objective(position, radius, fixed_position, fixed_radius, *rest)
        errors.append(abs(ours.value - oracle.value) / oracle.value.abs())
        errors.append((ours.gradient - oracle.gradient).abs().max() / oracle.gradient.abs().max())
        return ours

    monkeypatch.setattr(adam, "objective", checked)
    monkeypatch.setattr(adam, "list_pairs", lambda *args: (lists.append(1), listed(*args))[1])
    # a long fall: the batch leaves the fixed spheres that it started near
    result = arrange_batch(start - 2.0 * DOWN, radius, fixed_position, fixed_radius, box(), DOWN, SHORT)
    assert max(errors) < 1e-12
    assert 3 < len(lists) < result.steps / 2


def test_near_pairs_equal_those_of_all_fixed_spheres_wherever_the_batch_goes():
    start, radius, fixed_position, fixed_radius = bed_and_batch(fixed_count=500)
    fixed_position = 6.0 * fixed_position
    near = NearPairs(radius, fixed_position, fixed_radius)
    for seed in range(30):
        position = start + uniform(seed, -0.3, 5.0, 3)
        pairs = near.at(position, rate=0.01)
        gap = (
            torch.linalg.vector_norm(
                position[pairs.first] - torch.cat((position, near.fixed_position))[pairs.second], dim=1
            )
            - pairs.touch
        )
        everything = list_pairs(position, radius, fixed_position, fixed_radius, 0.0)
        assert int((gap < 0.0).sum()) == len(everything.touch)
        assert len(near.fixed_position) < len(fixed_position)


def test_best_position_is_the_one_whose_objective_is_reported():
    spheres = bed_and_batch(3)
    result = arrange_batch(*spheres, box(), DOWN, SHORT)
    again = all_pairs_objective(result.position, *spheres[1:], box(), DOWN, SHORT.weights)
    before = all_pairs_objective(*spheres, box(), DOWN, SHORT.weights)
    assert result.objective == pytest.approx(again.value.item(), rel=1e-12)
    assert result.objective < before.value


def test_patience_and_step_limit_end_a_batch():
    spheres = bed_and_batch(4)
    assert arrange_batch(*spheres, box(), DOWN, dataclasses.replace(SHORT, n_epoch=17)).steps == 17
    assert arrange_batch(*spheres, box(), DOWN, dataclasses.replace(SHORT, n_epoch=0)).steps == 0
    values = []
    settings = dataclasses.replace(SHORT, patience=3, n_epoch=2000)
    arrange_batch(*spheres, box(), DOWN, settings, lambda _, value, __: values.append(value))
    assert min(values[-3:]) >= min(values[:-3])


def test_same_start_gives_the_same_bits_and_is_left_as_it_was():
    spheres = bed_and_batch(5)
    start = spheres[0].clone()
    first, second = (arrange_batch(*spheres, box(), DOWN, SHORT) for _ in range(2))
    assert torch.equal(first.position, second.position)
    assert torch.equal(spheres[0], start)
    assert first.position.dtype == torch.float64


def test_moving_the_scene_as_a_whole_moves_the_bed_with_it():
    start, radius, fixed_position, fixed_radius = bed_and_batch(6)
    settings = dataclasses.replace(SHORT, n_epoch=40)
    shift = torch.tensor([8.0, -4.0, -16.0], dtype=torch.float64)
    here = arrange_batch(start, radius, fixed_position, fixed_radius, box(), DOWN, settings)
    walls = PlaneWalls(box().normal, box().offset + box().normal @ shift)
    there = arrange_batch(start + shift, radius, fixed_position + shift, fixed_radius, walls, DOWN, settings)
    assert there.steps == here.steps
    torch.testing.assert_close(there.position - shift, here.position, rtol=0.0, atol=1e-7)


def test_one_sphere_falls_to_the_floor_along_any_direction():
    nothing = torch.empty((0, 3), dtype=torch.float64)
    radius = torch.tensor([0.1], dtype=torch.float64)
    start = torch.full((1, 3), 0.4, dtype=torch.float64)
    for axis, end in ((0, 0.9), (1, 0.1), (2, 0.1)):
        down = torch.zeros(3, dtype=torch.float64)
        down[axis] = 1.0 if end > 0.5 else -1.0
        result = arrange_batch(start, radius, nothing, nothing[:, 0], box(), down, AdamSettings())
        expected = torch.full((1, 3), 0.4, dtype=torch.float64)
        expected[0, axis] = end
        torch.testing.assert_close(result.position, expected, rtol=0.0, atol=1e-4)
        assert batch_accepted(result, AdamSettings())


def test_averages_are_over_contacts_and_in_terms_of_the_smaller_radius():
    position = torch.tensor([[0.5, 0.5, 0.5], [0.5, 0.5, 0.75], [0.05, 0.2, 0.2]], dtype=torch.float64)
    radius = torch.tensor([0.1, 0.2, 0.1], dtype=torch.float64)
    # overlaps of 0.5 and of 0.2 small radii, one pair that just touches, one too far away to be a contact
    fixed = torch.tensor([[0.5, 0.5, 0.32], [0.7, 0.5, 0.5], [0.298, 0.5, 0.5]], dtype=torch.float64)
    fixed_radius = torch.tensor([0.1, 0.1, 0.1], dtype=torch.float64)
    overlap_mean, overlap_max, exterior_mean, exterior_max = measure_batch(
        position, radius, fixed, fixed_radius, box()
    )
    assert overlap_max == pytest.approx(0.5, rel=1e-9)
    assert overlap_mean == pytest.approx((0.5 + 0.2 + 0.0) / 3, rel=1e-9)
    assert (exterior_mean, exterior_max) == pytest.approx((0.5, 0.5), rel=1e-9)


@pytest.mark.parametrize(("overlap", "exterior", "accepted"), [
    (0.0, 0.0, True), (0.011, 0.011, True), (0.0111, 0.0, False), (0.0, 0.0111, False),
])  # fmt: skip
def test_batch_is_accepted_by_both_averages(overlap, exterior, accepted):
    result = BatchResult(torch.empty((0, 3)), 0.0, 1, overlap, 9.0, exterior, 9.0)
    assert batch_accepted(result, AdamSettings()) is accepted
