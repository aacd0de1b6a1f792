"""Claims that hold for every law of sizes, against numerical integration and drawn spheres."""

from __future__ import annotations

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from packgen.distributions import (
    UNIT_VOLUME,
    Constant,
    Discrete,
    Distribution,
    Listed,
    Lognormal,
    Normal,
    ParameterError,
    RosinRammler,
    Sieve,
    Uniform,
)

SMOOTH: list[Distribution] = [
    Uniform(0.05, 0.08),
    Normal(0.04, 0.005),
    Normal(0.04, 0.05),
    Normal(0.04, 0.005, 0.03, 0.042),
    Lognormal(0.04, 0.5),
    Lognormal(0.04, 0.3, 0.03, 0.1),
    Lognormal(0.01, 3.0, 0.01, 0.1),
    RosinRammler(0.05, 3.0, 0.01, 0.1),
    RosinRammler(0.05, 0.8, 0.02, 0.2),
    RosinRammler(0.05, 40.0, 0.01, 0.1),
    Sieve([0.01, 0.02, 0.05, 0.1], [0.0, 0.3, 0.3, 1.0]),
    Sieve([0.1, 0.05, 0.02, 0.01], [1.0, 0.6, 0.4, 0.1]),
]
STEPS: list[Distribution] = [
    Constant(0.05),
    Uniform(0.05, 0.05),
    Discrete([0.1, 0.02, 0.05], [0.3, 0.6, 0.1], by="mass"),
    Discrete([0.1, 0.02, 0.05], [0.0, 0.9, 0.1]),
    Listed(np.array([0.03, 0.01, 0.02, 0.02])),
]


def name(law: Distribution) -> str:
    return f"{type(law).__name__}-{law.radius_bounds[0]:.3g}"


@pytest.mark.parametrize("law", SMOOTH, ids=name)
def test_quantile_inverts_the_cumulative_number(law: Distribution) -> None:
    share = np.linspace(0.0, 1.0, 2001)
    np.testing.assert_allclose(law.cumulative_number(law.quantile(share)), share, atol=1e-12)


@pytest.mark.parametrize("law", SMOOTH, ids=name)
def test_mass_below_a_radius_is_the_volume_of_the_spheres_below_it(law: Distribution) -> None:
    # Stieltjes sum over a fine grid of the cumulative number: an oracle apart from the closed forms.
    low, high = law.radius_bounds
    edge = np.geomspace(low, high, 200_001)
    volume = np.diff(law.cumulative_number(edge)) * 0.5 * (edge[1:] ** 3 + edge[:-1] ** 3)
    assert UNIT_VOLUME * volume.sum() == pytest.approx(law.mean_volume(), rel=1e-6)
    np.testing.assert_allclose(law.cumulative_mass(edge[1:]), np.cumsum(volume) / volume.sum(), atol=2e-6)


@pytest.mark.parametrize("law", [*SMOOTH, *STEPS], ids=name)
def test_drawn_spheres_are_within_bounds_and_have_the_mean_volume(law: Distribution) -> None:
    low, high = law.radius_bounds
    radius = law.sample(np.random.default_rng(5), 20_000)
    assert radius.shape == (20_000,)
    assert low * (1 - 1e-12) <= radius.min() <= radius.max() <= high * (1 + 1e-12)
    assert UNIT_VOLUME * np.mean(radius**3) == pytest.approx(law.mean_volume(), rel=5e-3)


@pytest.mark.parametrize("law", SMOOTH, ids=name)
def test_drawn_spheres_follow_the_law_to_one_sphere(law: Distribution) -> None:
    radius = np.sort(law.sample(np.random.default_rng(6), 5000))
    rank = (np.arange(5000) + 0.5) / 5000
    assert np.abs(law.cumulative_number(radius) - rank).max() < 1.01 / 5000


@pytest.mark.parametrize("law", STEPS, ids=name)
def test_steps_count_spheres_of_exactly_that_radius(law: Distribution) -> None:
    radius = np.unique(law.sample(np.random.default_rng(7), 5000))
    drawn = law.sample(np.random.default_rng(8), 5000)
    by_number = np.array([(drawn <= each).mean() for each in radius])
    by_mass = np.array([(drawn[drawn <= each] ** 3).sum() for each in radius]) / (drawn**3).sum()
    np.testing.assert_allclose(law.cumulative_number(radius), by_number, atol=1.01 / 5000)
    np.testing.assert_allclose(law.cumulative_mass(radius), by_mass, atol=5e-3)
    below = law.cumulative_number(np.nextafter(radius, 0.0))
    np.testing.assert_allclose(below, np.concatenate([[0.0], by_number[:-1]]), atol=1.01 / 5000)


@pytest.mark.parametrize("law", [*SMOOTH, *STEPS], ids=name)
def test_all_is_between_the_bounds(law: Distribution) -> None:
    low, high = law.radius_bounds
    outside = np.array([0.5 * low, high, 2.0 * high])
    assert law.cumulative_number(outside).tolist() == [0.0, 1.0, 1.0]
    assert law.cumulative_mass(outside).tolist() == pytest.approx([0.0, 1.0, 1.0], abs=1e-15)


@pytest.mark.parametrize("law", [SMOOTH[0], SMOOTH[6], STEPS[2], STEPS[4]], ids=name)
def test_the_same_seed_gives_the_same_radii(law: Distribution) -> None:
    first = law.sample(np.random.default_rng(3), 100)
    np.testing.assert_array_equal(first, law.sample(np.random.default_rng(3), 100))
    assert (first != law.sample(np.random.default_rng(4), 100)).any()
    assert law.sample(np.random.default_rng(3), 0).shape == (0,)


@hypothesis.settings(max_examples=200, deadline=None, derandomize=True)
@hypothesis.given(
    st.sampled_from([Normal, Lognormal, RosinRammler]),
    st.floats(1e-9, 1e3),
    st.floats(-4.0, 6.0),
    st.floats(-6.0, 3.0),
    st.floats(1e-6, 6.0),
)
def test_any_parameters_give_a_law_or_are_refused(
    kind: type[Distribution], size: float, log_second: float, log_low: float, log_ratio: float
) -> None:
    second = 10.0**log_second * (size if kind is Normal else 1.0)
    low, high = size * 10.0**log_low, size * 10.0 ** (log_low + log_ratio)
    with np.errstate(all="raise", under="ignore"):
        try:
            law = kind(size, second, low, high)  # type: ignore[call-arg]
        except ParameterError:
            return
        radius = law.sample(np.random.default_rng(0), 100)
        assert ((radius >= low) & (radius <= high)).all()
        assert 0.0 < law.mean_volume() < np.inf
        mass = law.cumulative_mass(np.sort(radius))
        assert (np.diff(mass) >= -1e-9).all()
        assert ((mass >= 0.0) & (mass <= 1.0)).all()
