"""Eq. 5 from a list of pairs against the formula as printed, differentiated by torch."""

import dataclasses
import math

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from packgen.arrange.adam.objective import PlaneWalls, Weights, all_pairs_objective, list_pairs, objective

DOWN = torch.tensor([0.0, 0.0, -1.0], dtype=torch.float64)


def box_walls(low=0.0, high=1.0):
    eye = torch.eye(3, dtype=torch.float64)
    offset = torch.tensor([high] * 3 + [-low] * 3, dtype=torch.float64)
    return PlaneWalls(torch.cat((eye, -eye)), offset)


class RoundWalls:
    """A sphere about the origin, without a gradient of its own: torch has to find it."""

    def exterior(self, position, radius):
        return (torch.linalg.vector_norm(position, dim=1) + radius - 1.0)[:, None]


@dataclasses.dataclass
class Case:
    position: torch.Tensor
    radius: torch.Tensor
    fixed_position: torch.Tensor
    fixed_radius: torch.Tensor


def case(seed, count, fixed_count, spread=0.6):
    rng = torch.Generator().manual_seed(seed)
    uniform = lambda *shape: torch.rand(*shape, generator=rng, dtype=torch.float64)  # noqa: E731
    return Case(
        spread * (uniform(count, 3) - 0.2), 0.05 + 0.15 * uniform(count),
        spread * (uniform(fixed_count, 3) - 0.2), 0.05 + 0.15 * uniform(fixed_count),
    )  # fmt: skip


def both_ways(spheres, walls=None, down=DOWN, weights=None, skin=0.05):
    walls, weights = walls or box_walls(), weights or Weights()
    everything = dataclasses.astuple(spheres)
    pairs = list_pairs(*everything, skin)
    ours = objective(spheres.position, spheres.radius, spheres.fixed_position, pairs, walls, down, weights)
    return ours, all_pairs_objective(*everything, walls, down, weights)


def assert_equal_to_rounding(ours, oracle):
    torch.testing.assert_close(ours.value, oracle.value, rtol=1e-13, atol=1e-12)
    torch.testing.assert_close(ours.gradient, oracle.gradient, rtol=1e-12, atol=1e-11)


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    seed=st.integers(0, 2**32 - 1),
    count=st.integers(0, 40),
    fixed_count=st.integers(0, 40),
    spread=st.sampled_from([0.1, 0.6, 3.0]),
    skin=st.sampled_from([0.0, 0.1, 1.0]),
    weights=st.builds(Weights, *[st.sampled_from([0.0, 1.0, 10.0, 100.0])] * 3),
    round_walls=st.booleans(),
    down=st.tuples(*[st.integers(-3, 3)] * 3).filter(any),
)
def test_objective_and_gradient_equal_the_all_pairs_formula(
    seed, count, fixed_count, spread, skin, weights, round_walls, down
):
    down = torch.tensor(down, dtype=torch.float64) / math.hypot(*down)
    walls = RoundWalls() if round_walls else box_walls()
    ours, oracle = both_ways(case(seed, count, fixed_count, spread), walls, down, weights, skin)
    assert_equal_to_rounding(ours, oracle)


def test_gradient_equals_a_difference_of_values():
    spheres = case(1, 12, 20)
    ours, _ = both_ways(spheres)
    step = 1e-7
    for index in range(12):
        for axis in range(3):
            values = []
            for sign in (1.0, -1.0):
                position = spheres.position.clone()
                position[index, axis] += sign * step
                values.append(both_ways(dataclasses.replace(spheres, position=position))[0].value.item())
            assert (values[0] - values[1]) / (2 * step) == pytest.approx(
                ours.gradient[index, axis].item(), abs=1e-4
            )


def spheres_at(first, second, *, second_fixed):
    points = torch.tensor([first, second], dtype=torch.float64)
    radius = torch.tensor([0.1, 0.2], dtype=torch.float64)
    batch, fixed = (slice(0, 1), slice(1, 2)) if second_fixed else (slice(0, 2), slice(2, 2))
    return Case(points[batch], radius[batch], points[fixed], radius[fixed])


def test_overlap_counts_twice_within_the_batch_and_once_with_a_fixed_sphere():
    only_overlap = Weights(alpha=1.0, beta=0.0, gamma=0.0)
    for second_fixed, expected in ((False, 2 * 0.05), (True, 0.05)):
        spheres = spheres_at([0.5, 0.5, 0.5], [0.5, 0.5, 0.75], second_fixed=second_fixed)
        for form in both_ways(spheres, weights=only_overlap):
            assert form.value.item() == pytest.approx(expected, rel=1e-12)


def test_altitude_grows_against_down_whatever_its_direction():
    spheres = spheres_at([0.3, 0.5, 0.5], [0.7, 0.5, 0.5], second_fixed=False)
    down = torch.tensor([1.0, 0.0, 0.0], dtype=torch.float64)
    ours, _ = both_ways(spheres, down=down, weights=Weights(1.0, 10.0, 1.0))
    assert ours.value.item() == pytest.approx(-10.0 * (0.3 + 0.7), rel=1e-12)
    assert ours.gradient.tolist() == [[-10.0, 0.0, 0.0]] * 2


def test_sphere_in_a_corner_pays_for_each_wall_it_sticks_out_of():
    spheres = spheres_at([0.02, 0.06, 0.5], [0.5, 0.5, 0.5], second_fixed=True)
    ours, _ = both_ways(spheres, weights=Weights(0.0, 0.0, 1.0))
    assert ours.value.item() == pytest.approx(0.08 + 0.04, rel=1e-12)
    assert ours.gradient.tolist() == [[-1.0, -1.0, 0.0]]


@pytest.mark.parametrize("second_fixed", [True, False])
def test_coincident_centres_and_touching_spheres_give_no_pull(second_fixed):
    for distance in (0.0, 0.5):
        spheres = spheres_at([0.25, 0.5, 0.5], [0.25 + distance, 0.5, 0.5], second_fixed=second_fixed)
        spheres.radius, spheres.fixed_radius = spheres.radius * 0 + 0.25, spheres.fixed_radius * 0 + 0.25
        ours, oracle = both_ways(spheres, weights=Weights(100.0, 0.0, 100.0))
        assert_equal_to_rounding(ours, oracle)
        assert not ours.gradient.any()
