"""The shares of a push: by mass between moving spheres, by the ratio of radii on small fixed ones."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.projection.pair_rules import push_weights


def weights_of(radius, moving, reference):
    """Weights of spheres of some radii, wherever they are."""
    return push_weights(np.column_stack([np.zeros((len(radius), 3)), radius]), moving, reference)


def share(weight, one, other):
    return weight[one] / (weight[one] + weight[other])


def test_two_moving_spheres_give_way_in_inverse_proportion_to_mass():
    weights = weights_of(np.array([0.1, 0.2]), 2, 0.15)
    assert share(weights, 0, 1) == pytest.approx(8.0 / 9.0)
    assert share(weights, 0, 1) + share(weights, 1, 0) == pytest.approx(1.0)


@pytest.mark.parametrize("reference", [0.1, 1.0])
def test_a_fixed_equal_sphere_gives_all_the_push_and_a_small_one_the_ratio_of_radii(reference):
    weights = weights_of(np.array([0.1, 0.1, 0.02]), 1, reference)
    assert share(weights, 0, 1) == 1.0
    assert share(weights, 0, 2) == pytest.approx(0.2)


def test_a_small_sphere_gives_way_to_what_is_fixed_nearly_in_full():
    weight = weights_of(np.array([0.02, 0.1, 0.02]), 1, 0.02)
    assert share(weight, 0, 1) == 1.0
    assert share(weight, 0, 2) > 0.95


def test_nothing_fixed_and_nothing_at_all_have_their_shares_too():
    assert weights_of(np.array([0.1, 0.1]), 2, 0.1).tolist() == [1.0, 1.0]
    assert weights_of(np.empty(0), 0, 0.1).tolist() == []
