"""Claims on laws of sizes multiplied by a factor."""

import numpy as np
import pytest

from packgen.distributions import Constant, Listed, Lognormal, Sieve, Uniform, scaled

LAWS = [
    Constant(0.2),
    Uniform(0.1, 0.3),
    Lognormal(0.1, 0.3),
    Sieve((0.1, 0.2, 0.4), (0.0, 0.4, 1.0)),
    Listed(np.array([0.1, 0.2, 0.4])),
]


@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_all_that_a_law_says_is_said_of_larger_sizes(law):
    larger, radius, share = scaled(law, 1.5), np.array([0.11, 0.16, 0.21]), np.array([0.1, 0.5, 0.9])
    assert larger.radius_bounds == pytest.approx([1.5 * each for each in law.radius_bounds])
    assert larger.mean_volume() == pytest.approx(1.5**3 * law.mean_volume())
    assert np.allclose(larger.quantile(share), 1.5 * law.quantile(share))
    assert np.allclose(larger.cumulative_number(1.5 * radius), law.cumulative_number(radius))
    assert np.allclose(larger.cumulative_mass(1.5 * radius), law.cumulative_mass(radius))
    drawn = [np.sort(each.sample(np.random.default_rng(3), 9)) for each in (larger, law)]
    assert np.allclose(drawn[0], 1.5 * drawn[1])


def test_a_list_stays_a_list_and_a_factor_of_one_changes_nothing():
    assert isinstance(scaled(LAWS[-1], 2.0), Listed)
    assert scaled(LAWS[0], 1.0) is LAWS[0]
