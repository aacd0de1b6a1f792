"""Claims on the laws by number, against scipy's and closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from packgen.distributions import UNIT_VOLUME, Lognormal, Normal, Uniform


def test_the_normal_law_is_scipys_truncated_one() -> None:
    law = Normal(0.04, 0.01, 0.03, 0.07)
    peer = stats.truncnorm(-1.0, 3.0, loc=0.04, scale=0.01)
    radius = np.linspace(0.02, 0.08, 61)
    np.testing.assert_allclose(law.cumulative_number(radius), peer.cdf(radius), atol=1e-14)
    assert law.mean_volume() == pytest.approx(UNIT_VOLUME * peer.moment(3), rel=1e-10)


def test_the_lognormal_law_is_scipys_truncated_one() -> None:
    law = Lognormal(0.04, 0.3, 0.02, 0.09)
    peer = stats.truncate(stats.make_distribution(stats.lognorm)(s=0.3), 0.5, 2.25)
    radius = np.linspace(0.021, 0.089, 30)
    np.testing.assert_allclose(law.cumulative_number(radius), peer.cdf(radius / 0.04), atol=1e-10)
    assert law.mean_volume() == pytest.approx(UNIT_VOLUME * 0.04**3 * float(peer.moment(3)), rel=1e-6)


def test_a_wide_lognormal_law_has_the_closed_mean_volume() -> None:
    # Hatch and Choate: the mean cube of an untruncated law is median^3 exp(4.5 sigma^2).
    law = Lognormal(0.04, 0.2, 0.04 * math.exp(-3.0), 0.04 * math.exp(3.0))
    assert law.mean_volume() == pytest.approx(UNIT_VOLUME * 0.04**3 * math.exp(4.5 * 0.04), rel=1e-12)


def test_the_uniform_law_has_the_closed_mean_volume() -> None:
    assert Uniform(1.0, 3.0).mean_volume() == pytest.approx(UNIT_VOLUME * (81 - 1) / (4 * 2))


def test_without_bounds_four_standard_deviations_are_kept() -> None:
    assert Normal(0.04, 0.005).radius_bounds == pytest.approx((0.02, 0.06))
    assert Normal(0.04, 0.02).radius_bounds == pytest.approx((0.004, 0.12))
    assert Lognormal(1.0, 0.5).radius_bounds == pytest.approx((math.exp(-2), math.exp(2)))
