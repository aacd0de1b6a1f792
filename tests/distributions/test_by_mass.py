"""Claims on the laws by mass: what is asked by mass is reached by mass."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import integrate

from packgen.distributions import UNIT_VOLUME, ParameterError, RosinRammler, Sieve


def rosin_rammler_below(radius: float, radius_63: float, exponent: float) -> float:
    return float(1.0 - np.exp(-((radius / radius_63) ** exponent)))


def test_rosin_rammler_has_its_mass_where_the_formula_says() -> None:
    law = RosinRammler(0.05, 2.5, 0.01, 0.15)
    low, high = (rosin_rammler_below(each, 0.05, 2.5) for each in (0.01, 0.15))
    asked = [(rosin_rammler_below(each, 0.05, 2.5) - low) / (high - low) for each in (0.02, 0.05, 0.08)]
    assert law.cumulative_mass(np.array([0.02, 0.05, 0.08])) == pytest.approx(asked, rel=1e-12)
    radius = law.sample(np.random.default_rng(0), 100_000)
    reached = [(radius[radius <= each] ** 3).sum() / (radius**3).sum() for each in (0.02, 0.05, 0.08)]
    assert reached == pytest.approx(asked, abs=2e-3)


def test_rosin_rammlers_number_of_spheres_is_its_mass_over_their_volume() -> None:
    law = RosinRammler(0.05, 2.5, 0.01, 0.15)

    def per_mass(radius: float) -> float:
        reduced = (radius / 0.05) ** 2.5
        return float(2.5 / radius * reduced * np.exp(-reduced) / radius**3)

    total = integrate.quad(per_mass, 0.01, 0.15, epsabs=0.0, epsrel=1e-11, limit=200)[0]
    below = integrate.quad(per_mass, 0.01, 0.02, epsabs=0.0, epsrel=1e-11, limit=200)[0]
    mass = rosin_rammler_below(0.15, 0.05, 2.5) - rosin_rammler_below(0.01, 0.05, 2.5)
    assert law.mean_volume() == pytest.approx(UNIT_VOLUME * mass / total, rel=1e-10)
    assert float(law.cumulative_number(np.array([0.02]))[0]) == pytest.approx(below / total, rel=1e-6)


def test_a_decade_of_sieves_is_reached_to_a_fifth_of_a_percent_of_the_mass() -> None:
    diameter = np.geomspace(0.01, 0.1, 8)
    passing = np.array([0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0])
    radius = Sieve(diameter, passing).sample(np.random.default_rng(1), 100_000)
    volume = radius**3
    reached = [volume[2 * radius <= each].sum() / volume.sum() for each in diameter]
    np.testing.assert_allclose(reached, passing, atol=2e-3)


def test_sieves_are_linear_in_diameter_between_openings() -> None:
    law = Sieve([0.01, 0.03], [0.0, 1.0])
    assert law.cumulative_mass(np.array([0.0075, 0.01])) == pytest.approx([0.25, 0.5])
    # Mass spread evenly over d: spheres per mass go as d^-3, so their number below d as 1 - (d_min / d)^2.
    assert law.cumulative_number(np.array([0.01])) == pytest.approx([(1 - 1 / 4) / (1 - 1 / 9)])


def test_sieves_may_be_listed_from_coarse_to_fine() -> None:
    fine_first, coarse_first = Sieve([1, 2, 4], [0, 0.2, 1]), Sieve([4, 2, 1], [1, 0.2, 0])
    radius = np.linspace(0.4, 2.1, 18)
    np.testing.assert_array_equal(
        fine_first.cumulative_number(radius), coarse_first.cumulative_number(radius)
    )


def test_what_passes_the_finest_sieve_is_below_it() -> None:
    law = Sieve([0.02, 0.04], [0.1, 1.0])
    assert law.radius_bounds == pytest.approx((0.005, 0.02))
    assert law.cumulative_mass(np.array([0.01])) == pytest.approx([0.1])


def test_an_empty_class_holds_no_sphere() -> None:
    radius = Sieve([0.01, 0.02, 0.05, 0.1], [0.0, 0.3, 0.3, 1.0]).sample(np.random.default_rng(0), 20_000)
    assert not ((radius > 0.01 * (1 + 1e-12)) & (radius < 0.025 * (1 - 1e-12))).any()


@pytest.mark.parametrize("exponent", [200.0, 1000.0, 1000.1, 1.5e14])
def test_a_law_of_rosin_rammler_is_as_narrow_as_can_be_computed_or_refused(exponent: float) -> None:
    if exponent > 1000.0:
        with pytest.raises(ParameterError, match="at most 1000; for radii all alike use the law constant"):
            RosinRammler(0.05, exponent, 0.01, 0.15)
        return
    law = RosinRammler(0.05, exponent, 0.01, 0.15)
    np.testing.assert_allclose(law.quantile(np.array([0.1, 0.5, 0.9])), 0.05, rtol=3.0 / exponent)
    assert law.mean_volume() == pytest.approx(4 / 3 * np.pi * 0.05**3, rel=9.0 / exponent)
