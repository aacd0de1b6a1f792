"""Random close packing by rods on a line: published and independent values, limits, what must not matter."""

from __future__ import annotations

from types import SimpleNamespace

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from packgen.distributions import Constant, Lognormal, RosinRammler, Uniform
from packgen.supply import close_packing
from packgen.supply.close_packing import EQUAL_SPHERES, close_packing_fraction
from packgen.supply.shares import size_weights

LEVELS = (np.arange(4000) + 0.5) / 4000


def two(ratio, fine):
    """Radii and numbers of two sizes, the small ones with a share of the volume."""
    return np.array([1.0, 1.0 / ratio]), np.array([1.0 - fine, fine * ratio**3])


def lognormal(sigma):
    score = np.linspace(-6.0, 6.0 + 3.0 * sigma, 4000)
    return np.exp(sigma * score), np.exp(-0.5 * score**2)


def fuller(ratio):
    edge = np.exp(np.log(ratio) * np.linspace(0.0, 1.0, 4001))
    radius = np.sqrt(edge[1:] * edge[:-1])
    return radius, np.diff(np.sqrt(edge)) / radius**3


# Each by another implementation: chords drawn at random, ten times as many.
MIXTURES = {
    "equal": ((np.ones(1), np.ones(1)), 0.6435),
    "1:1.4 by number": ((np.array([1.0, 1.4]), np.ones(2)), 0.6524),
    "1:2 by number": ((np.array([1.0, 2.0]), np.ones(2)), 0.6676),
    "1:2": (two(2.0, 0.30), 0.6819),
    "1:3": (two(3.0, 0.25), 0.7290),
    "1:5": (two(5.0, 0.20), 0.7873),
    "1:10": (two(10.0, 0.25), 0.8267),
    "uniform 1:3": ((1.0 + 2.0 * LEVELS, np.ones(4000)), 0.6634),
    "uniform 1:10": ((1.0 + 9.0 * LEVELS, np.ones(4000)), 0.6686),
    "uniform 5.2 to 7.5": ((5.2 + 2.3 * LEVELS, np.ones(4000)), 0.6472),
    "lognormal 0.1": (lognormal(0.1), 0.6470),
    "lognormal 0.2": (lognormal(0.2), 0.6569),
    "lognormal 0.3": (lognormal(0.3), 0.6714),
    "lognormal 0.5": (lognormal(0.5), 0.7073),
    "lognormal 0.8": (lognormal(0.8), 0.7655),
    "lognormal 1": (lognormal(1.0), 0.8016),
    "Fuller 1:10": (fuller(10.0), 0.7476),
    "Fuller 1:30": (fuller(30.0), 0.8164),
}


@pytest.mark.parametrize("name", MIXTURES)
def test_mixtures_pack_as_the_rods_of_another_implementation_to_three_ten_thousandths(name):
    mixture, fraction = MIXTURES[name]
    assert close_packing_fraction(*mixture) == pytest.approx(fraction, abs=2.5e-4)


def test_equal_spheres_have_the_published_fraction_and_sizes_that_hardly_differ_nearly_it():
    assert round(EQUAL_SPHERES, 4) == 0.6435
    assert close_packing_fraction(np.full(9, 0.1)) == EQUAL_SPHERES
    rods = close_packing._rods(np.ones(1), np.ones(1))
    assert close_packing._filled_share(rods) == EQUAL_SPHERES
    assert close_packing_fraction(np.array([1.0, 1.0 + 1e-9])) == pytest.approx(EQUAL_SPHERES, abs=1e-6)


@pytest.mark.parametrize("sigma", [0.2, 0.5, 0.8])
def test_lognormal_sizes_pack_as_farr_fitted_them(sigma):
    # Farr, Powder Technology 245 (2013) 28, without the ripple, whose amplitude is 0.0038.
    fit = 1.0 - 0.57 * np.exp(-sigma) + 0.2135 * np.exp(-0.57 * sigma / 0.2135)
    assert -0.004 < close_packing_fraction(*lognormal(sigma)) - fit < 0.0002


@pytest.mark.parametrize("fine", [0.05, 0.2])
def test_dust_lies_in_the_voids_of_large_spheres(fine):
    for ratio in (1e3, 1e6, 1e30):
        limit = EQUAL_SPHERES / (1.0 - fine)
        assert close_packing_fraction(*two(ratio, fine)) == pytest.approx(limit, abs=1e-3)


@pytest.mark.parametrize("fine", [0.5, 0.9])
def test_large_spheres_stand_in_much_dust_as_solid_lumps(fine):
    for ratio in (1e3, 1e6, 1e30):
        limit = 1.0 / (1.0 - fine + fine / EQUAL_SPHERES)
        assert close_packing_fraction(*two(ratio, fine)) == pytest.approx(limit, abs=1e-3)


def test_a_single_boulder_does_not_make_dust_of_all_the_others():
    radius, weight = lognormal(0.5)
    boulder = radius.max() * 1e4, 1e-3 * (weight * radius**3).sum() / (radius.max() * 1e4) ** 3
    with_it = close_packing_fraction(np.append(radius, boulder[0]), np.append(weight, boulder[1]))
    assert with_it == pytest.approx(close_packing_fraction(radius, weight), abs=2e-3)


@hypothesis.settings(max_examples=4, deadline=None, derandomize=True)
@hypothesis.given(
    sizes=st.lists(st.tuples(st.floats(1.0, 1e3), st.floats(1e-3, 1.0)), min_size=2, max_size=6),
    unit=st.floats(1e-6, 1e6),
)
def test_neither_unit_nor_order_nor_division_into_sets_matters(sizes, unit):
    radius, volume = np.array(sizes).T
    weight = volume / radius**3
    fraction = close_packing_fraction(radius, weight)
    assert EQUAL_SPHERES - 1e-4 < fraction < 1.0
    assert close_packing_fraction(unit * radius, 3.0 * weight) == pytest.approx(fraction, abs=1e-6)
    assert close_packing_fraction(radius[::-1], weight[::-1]) == pytest.approx(fraction, abs=1e-6)
    twice = np.concatenate([radius, radius]), np.concatenate([0.4 * weight, 0.6 * weight])
    assert close_packing_fraction(*twice) == pytest.approx(fraction, abs=1e-6)
    unused = np.append(radius, 1e9), np.append(weight, 0.0)
    assert close_packing_fraction(*unused) == fraction


def test_no_sphere_has_no_fraction():
    with pytest.raises(ValueError, match="at least one"):
        close_packing_fraction(np.ones(2), np.zeros(2))


def sets_of(*laws):
    return [SimpleNamespace(distribution=law, density=1.0) for law in laws]


def test_the_sizes_of_laws_pack_as_spheres_drawn_from_them():
    laws = [Lognormal(0.01, 0.5), Uniform(0.02, 0.05)]
    sizes = size_weights(np.array([0.8, 0.2]), sets_of(*laws))
    drawn = [laws[0].quantile(each) for each in np.array_split((np.arange(400_000) + 0.5) / 400_000, 4)]
    drawn.append(laws[1].quantile((np.arange(100_000) + 0.5) / 100_000))
    assert close_packing_fraction(*sizes) == pytest.approx(
        close_packing_fraction(np.concatenate(drawn)), abs=3e-4
    )


@pytest.mark.parametrize("law", [Lognormal(0.01, 1.2), RosinRammler(0.04, 1.5, 0.0004, 0.1)])
def test_the_sizes_of_a_broad_law_hold_its_volume(law):
    radius, weight = size_weights(np.ones(1), sets_of(law))
    assert weight.sum() == pytest.approx(1.0)
    volume = 4.0 / 3.0 * np.pi * weight * radius**3
    assert volume.sum() == pytest.approx(law.mean_volume(), rel=0.01)
    order = np.argsort(radius)
    reached = (np.cumsum(volume[order]) - 0.5 * volume[order]) / volume.sum()
    assert np.abs(reached - law.cumulative_mass(radius[order])).max() < 0.01


def test_the_sizes_of_laws_in_steps_are_their_steps():
    laws = [Constant(each) for each in (0.1, 0.2, 0.3)]
    radius, weight = size_weights(np.array([0.3, 0.7, 0.0]), sets_of(*laws))
    assert radius.tolist() == [0.1, 0.2]
    assert weight.tolist() == [0.3, 0.7]
