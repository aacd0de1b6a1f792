from __future__ import annotations

import numpy as np
import pytest

from packgen.measure import sizes


class Uniform:
    """Radii between 1 and 2: F = r - 1 by number, (r^4 - 1) / 15 by mass."""

    radius_bounds = (1.0, 2.0)

    def cumulative_number(self, radius):
        return np.clip(radius - 1.0, 0.0, 1.0)

    def cumulative_mass(self, radius):
        return np.clip((radius**4 - 1.0) / 15.0, 0.0, 1.0)


class Constant:
    radius_bounds = (1.5, 1.5)

    def cumulative_number(self, radius):
        return (radius >= 1.5).astype(float)

    cumulative_mass = cumulative_number


def test_evenly_spread_radii_follow_a_uniform_law():
    radius = 1.0 + (np.arange(1000) + 0.5) / 1000
    found = sizes("s", np.random.default_rng(0).permutation(radius), Uniform())
    assert found.by_number.distance_max == pytest.approx(0.0005)
    assert found.by_mass.distance_max < 0.002
    np.testing.assert_allclose(found.by_number.reached, found.by_number.asked, atol=0.001)
    np.testing.assert_allclose(found.by_mass.reached, found.by_mass.asked, atol=0.001)
    assert found.by_mass.asked[3] == pytest.approx(8.5**0.25)


def test_equal_radii_meet_a_constant_law_exactly():
    found = sizes("s", np.full(7, 1.5), Constant())
    assert found.by_number.distance_max == 0.0
    assert found.by_mass.distance_max == 0.0


def test_radii_that_miss_the_law_are_told_by_how_much():
    assert sizes("s", np.full(7, 1.5), Uniform()).by_number.distance_max == pytest.approx(0.5)
    assert sizes("s", np.full(7, 2.5), Uniform()).by_number.distance_max == pytest.approx(1.0)


def test_without_a_law_the_reached_curve_remains():
    found = sizes("s", np.array([1.0, 2.0, 3.0]), None)
    assert found.by_number.reached[3] == 2.0
    assert found.by_mass.reached[3] == 3.0
    assert found.by_number.distance_max is None
    assert sizes("s", np.empty(0), None) is None


def test_a_law_is_asked_for_all_shares_at_once():
    asked = []

    class Counted(Uniform):
        def cumulative_number(self, radius):
            asked.append(len(radius))
            return super().cumulative_number(radius)

    found = sizes("s", np.array([1.5]), Counted())
    assert found.by_number.asked == pytest.approx([1.05, 1.1, 1.25, 1.5, 1.75, 1.9, 1.95])
    assert len(asked) < 70
