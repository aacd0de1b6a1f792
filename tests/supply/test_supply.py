"""Claims on the spheres of a zone: counts, sums and proportions as asked, and no radius lost or changed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st
from pydantic import TypeAdapter

from packgen.distributions import UNIT_VOLUME
from packgen.errors import PackingError
from packgen.scene import ParticleSetSpec, SetKeys, ZoneSpec
from packgen.supply.close_packing import EQUAL_SPHERES, close_packing_fraction
from packgen.supply.shares import largest_remainder, mean_weights
from packgen.supply.supply import Draw, Supply

SPHERE = 4.0 / 3.0 * np.pi
READ: TypeAdapter[SetKeys] = TypeAdapter(ParticleSetSpec)
UNIFORM = {"radius_distribution": "uniform", "radius_min": 0.05, "radius_max": 0.08}
SMALL = {"radius_distribution": "lognormal", "radius_median": 0.02, "sigma": 0.3, "density": 4000}
CLASSES = {"radius_distribution": "discrete", "radii": [0.01, 0.1], "fractions": [0.9, 0.1]}


PINNED = (0.08263152320823239, -0.05572557164579586, 0.21574159989590747)
"""What three draws came to before sets kept their shares."""


def sets(*specs: dict[str, Any], folder: Path = Path()) -> tuple[SetKeys, ...]:
    return tuple(READ.validate_python(each, context={"folder": folder}) for each in specs)


def zone(**keys: Any) -> ZoneSpec:
    return ZoneSpec.model_validate({"set_proportions": [1.0], **keys})


def supply(spec: ZoneSpec, *specs: dict[str, Any], seed: int = 0, folder: Path = Path()) -> Supply:
    return Supply(spec, sets(*specs, folder=folder), np.random.default_rng(seed))


@pytest.mark.parametrize("seed", [3, 50, 127])
def test_a_wanted_sum_is_met_where_no_other_sphere_is_as_small_as_the_smallest(seed):
    # What is missing in the end is less than any sphere that could be added: one is exchanged.
    tail = {"radius_distribution": "normal", "radius_mean": 0.6, "radius_std_dev": 0.09}
    bounded = {**tail, "radius_min": 0.2, "radius_max": 1.0}
    classes = {"radius_distribution": "discrete", "radii": [1.6, 0.5], "fractions": [0.5, 0.5], "by": "mass"}
    draw = supply(zone(volume=20_000.0, set_proportions=[0.54, 0.46]), bounded, classes, seed=seed).take(
        10**6
    )
    volume = SPHERE * draw.radius**3
    assert abs(volume.sum() - 20_000.0) <= 0.5 * volume.min()


def test_a_counted_zone_divides_its_number_exactly_and_mixes_it() -> None:
    source = supply(zone(n_particles=1001, set_proportions=[0.7, 0.3]), UNIFORM, SMALL)
    assert (source.asked, source.remaining, source.drawn_count) == (1001, 1001, 1001)
    draw = source.take(10**6)
    assert np.bincount(draw.set_index).tolist() == [701, 300]
    assert source.finished
    assert len(source.take(5).radius) == 0
    # Well mixed: any tenth of the order has its share of the first set (binomial, four standard deviations).
    tenths = np.array([np.mean(part == 0) for part in np.array_split(draw.set_index, 10)])
    assert np.abs(tenths - 0.7).max() < 4 * np.sqrt(0.21 / 100)


@pytest.mark.parametrize("by", ["volume", "mass"])
def test_proportions_by_volume_or_mass_are_met_by_the_spheres_drawn(by: str) -> None:
    spec = zone(n_particles=20_000, set_proportions=[0.6, 0.4], proportions_by=by)
    draw = supply(spec, UNIFORM, SMALL).take(20_000)
    weight = draw.radius**3 * (np.array([2500.0, 4000.0])[draw.set_index] if by == "mass" else 1.0)
    assert weight[draw.set_index == 0].sum() / weight.sum() == pytest.approx(0.6, abs=0.01)


@hypothesis.settings(max_examples=60, deadline=None, derandomize=True)
@hypothesis.given(
    st.sampled_from([UNIFORM, SMALL, CLASSES]),
    st.sampled_from(["volume", "mass"]),
    st.floats(0.5, 3000.0),
    st.integers(0, 9),
)
def test_one_set_meets_a_wanted_sum_to_half_the_smallest_sphere(
    spec: dict[str, Any], by: str, spheres: float, seed: int
) -> None:
    made = sets(spec)
    wanted = spheres * made[0].distribution.mean_volume() * (3000.0 if by == "mass" else 1.0)
    draw = Supply(zone(**{by: wanted}), made, np.random.default_rng(seed)).take(10**6)
    weight = SPHERE * draw.radius**3 * (made[0].density if by == "mass" else 1.0)
    if len(weight):
        assert abs(weight.sum() - wanted) <= 0.5 * weight.min() * (1 + 1e-9)


def constants(*pairs: tuple[float, float]) -> list[dict[str, Any]]:
    return [
        {"radius_distribution": "constant", "radius": radius, "density": density} for radius, density in pairs
    ]


@pytest.mark.parametrize(
    ("specs", "mass", "counts"),
    [
        (constants((0.1, 3500), (0.03, 3500)), 580.0, [39, 38]),
        (constants((0.1, 3500), (0.03, 100)), 580.0, [40, 39]),
        (constants((0.1, 3500), (0.04, 1)), 300.0, [20, 20]),
        (constants((0.1, 3500), (0.03, 3500)), 4000.0, [266, 265]),
        (constants((0.1, 3500), (0.03, 3500)), 14.0, [1, 0]),
        (constants((0.1, 3500), (0.03, 3500), (0.05, 3500)), 58.7, [4, 3, 0]),
    ],
)
def test_a_mass_keeps_the_shares_by_number_and_comes_as_near_as_they_allow(specs, mass, counts) -> None:
    shares = [0.5, 0.5] + [0.0] * (len(specs) - 2)
    source = supply(zone(mass=mass, set_proportions=shares), *specs)
    assert np.bincount(source.take(10**6).set_index, minlength=len(specs)).tolist() == counts
    assert source.counts is not None
    assert source.counts.tolist() == counts
    each = np.array([spec["density"] * SPHERE * spec["radius"] ** 3 for spec in specs])
    totals = [largest_remainder(np.array(shares), total) @ each for total in range(sum(counts) + 200)]
    assert source.fit is not None
    assert source.fit.found == pytest.approx(counts @ each)
    assert abs(source.fit.found - mass) == pytest.approx(np.abs(np.array(totals) - mass).min())
    assert source.fit.missed == (abs(source.fit.found - mass) > 0.5 * each[:2].min())


MIXTURES = [[UNIFORM, SMALL], [CLASSES, SMALL], [UNIFORM, SMALL, {**CLASSES, "density": 700}]]
SHARES = [0.45, 0.35, 0.2]


@hypothesis.settings(max_examples=60, deadline=None, derandomize=True)
@hypothesis.given(
    st.sampled_from(MIXTURES),
    st.sampled_from(["volume", "mass"]),
    st.floats(1.0, 3000.0),
    st.integers(0, 9),
)
def test_counts_are_the_shares_by_number_of_their_total_whatever_the_sum(
    specs: list[dict[str, Any]], by: str, spheres: float, seed: int
) -> None:
    made = sets(*specs)
    shares = np.array(SHARES[: len(specs)])
    shares = shares / shares.sum()
    wanted = spheres * float(shares @ mean_weights(by, made))
    spec = zone(set_proportions=shares.tolist(), **{by: wanted})
    source = Supply(spec, made, np.random.default_rng(seed))
    counts = np.bincount(source.take(10**6).set_index, minlength=len(made))
    assert counts.tolist() == largest_remainder(shares, counts.sum()).tolist()
    assert source.fit is not None
    # One sphere more or less, of the largest size, is all that the counts leave open.
    largest = max(
        UNIT_VOLUME * each.distribution.radius_bounds[1] ** 3 * (each.density if by == "mass" else 1.0)
        for each in made
    )
    assert source.fit.found == pytest.approx(wanted, abs=largest)


@pytest.mark.parametrize("by", ["volume", "mass"])
@pytest.mark.parametrize("proportions_by", ["volume", "mass"])
@pytest.mark.parametrize("spheres", [2.0, 30.0, 300.0])
@pytest.mark.parametrize("specs", [*MIXTURES, constants((0.1, 3500), (0.03, 100), (0.06, 700))])
def test_each_set_meets_its_share_of_the_volume_or_mass_to_half_its_smallest_sphere(
    specs, spheres, proportions_by, by
) -> None:
    made = sets(*specs)
    shares = np.array(SHARES[: len(specs)])
    shares = shares / shares.sum()
    wanted = spheres * float(mean_weights(by, made).max()) / shares[0]
    keys = {"set_proportions": shares.tolist(), "proportions_by": proportions_by, by: wanted}
    draw = supply(zone(**keys), *specs).take(10**7)
    density = np.array([each.density for each in made])
    # What is asked: amounts in these proportions whose sum, by volume or mass, is the zone's.
    ratio = shares * (density if by == "mass" else 1.0) / (density if proportions_by == "mass" else 1.0)
    for index, asked in enumerate(wanted * ratio / ratio.sum()):
        weight = SPHERE * draw.radius[draw.set_index == index] ** 3
        weight = weight * (density[index] if by == "mass" else 1.0)
        smallest = SPHERE * made[index].distribution.quantile(np.array([1.0]))[0] ** 3
        limit = weight.min(initial=smallest * (density[index] if by == "mass" else 1.0))
        assert abs(weight.sum() - asked) <= 0.5 * limit * (1 + 1e-9)


def test_a_share_of_less_than_half_a_sphere_gets_none() -> None:
    specs = constants((0.1, 1000), (0.1, 1000))
    source = supply(zone(mass=40.0, set_proportions=[0.96, 0.04], proportions_by="mass"), *specs)
    assert source.counts is not None
    assert source.counts.tolist() == [9, 0]


def test_a_sum_is_met_by_few_exchanges_and_the_sizes_stay_those_of_the_law() -> None:
    # The spheres of the first set are so heavy that half of one is worth all of the second.
    fine = {"radius_distribution": "uniform", "radius_min": 0.02, "radius_max": 0.03}
    source = supply(zone(mass=407.0, set_proportions=[0.5, 0.5]), *constants((0.1, 3500)), fine)
    draw = source.take(10**6)
    assert source.fit is not None
    assert source.fit.missed
    radius = np.sort(draw.radius[draw.set_index == 1])
    rank = (np.arange(len(radius)) + 0.5) / len(radius)
    moved = 5 / len(radius)
    assert np.abs(sets(fine)[0].distribution.cumulative_number(radius) - rank).max() < moved


def test_spheres_of_files_are_used_once_in_zones_of_several_sets(tmp_path: Path) -> None:
    radii = 0.02 + 0.0004 * np.arange(100)
    (tmp_path / "radii.txt").write_text("\n".join(map(str, radii)))
    listed = {"radius_distribution": "file", "path": "radii.txt"}
    for by in ("number", "mass"):
        spec = zone(volume=0.02, set_proportions=[0.5, 0.5], proportions_by=by)
        draw = supply(spec, listed, UNIFORM, folder=tmp_path).take(10**6)
        own = draw.radius[draw.set_index == 0]
        assert len(own) == len(set(own.tolist())) > 5
        assert set(own.tolist()) <= set(radii.tolist())


def test_draws_of_one_set_and_of_counted_zones_are_those_of_earlier_versions() -> None:
    def digest(spec: ZoneSpec, *specs: dict[str, Any]) -> float:
        draw = supply(spec, *specs, seed=3).take(10**6)
        return float(draw.radius @ np.cos(np.arange(len(draw.radius))))

    assert digest(zone(volume=0.2), UNIFORM) == pytest.approx(PINNED[0], abs=1e-12)
    assert digest(zone(mass=300.0, set_proportions=[0.0, 1.0]), SMALL, UNIFORM) == pytest.approx(
        PINNED[1], abs=1e-12
    )
    counted = zone(n_particles=200, set_proportions=[0.3, 0.7], proportions_by="mass")
    assert digest(counted, UNIFORM, CLASSES) == pytest.approx(PINNED[2], abs=1e-12)


def test_meeting_a_sum_leaves_the_sizes_as_they_were() -> None:
    draw = supply(zone(volume=2.0), UNIFORM).take(10**6)
    law = sets(UNIFORM)[0].distribution
    rank = (np.arange(len(draw.radius)) + 0.5) / len(draw.radius)
    assert np.abs(law.cumulative_number(np.sort(draw.radius)) - rank).max() < 5 / len(draw.radius)


def test_an_endless_zone_keeps_its_proportions_at_every_moment() -> None:
    source = supply(zone(set_proportions=[0.75, 0.25]), UNIFORM, SMALL)
    assert source.remaining is None
    assert not source.finished
    counts = np.zeros(2)
    for count in [1, 7, 1, 50, 3, 1000, 1, 1]:
        counts += np.bincount(source.take(count).set_index, minlength=2)
        assert np.abs(counts - np.array([0.75, 0.25]) * counts.sum()).max() <= 1.0
    assert source.drawn_count == 1064


def test_an_endless_zone_follows_the_law_of_sizes() -> None:
    source = supply(zone(), UNIFORM)
    radius = np.sort(np.concatenate([source.take(64).radius for _ in range(48)]))
    rank = (np.arange(len(radius)) + 0.5) / len(radius)
    assert np.abs(sets(UNIFORM)[0].distribution.cumulative_number(radius) - rank).max() < 2 / 1024


@hypothesis.settings(max_examples=60, deadline=None, derandomize=True)
@hypothesis.given(
    st.lists(st.tuples(st.integers(0, 60), st.floats(0, 1)), min_size=1, max_size=12), st.booleans()
)
def test_what_is_put_back_comes_first_and_nothing_is_lost(
    steps: list[tuple[int, float]], endless: bool
) -> None:
    share = [0.5, 0.5]
    spec = zone(set_proportions=share) if endless else zone(n_particles=200, set_proportions=share)
    source = supply(spec, UNIFORM, SMALL)
    every = supply(spec, UNIFORM, SMALL).take(200) if not endless else None
    placed: list[float] = []
    for count, part in steps:
        draw = source.take(count)
        back = round(part * len(draw.radius))
        placed += draw.radius[back:].tolist()
        source.put_back(Draw(draw.radius[:back], draw.set_index[:back]))
        again = source.take(back)
        np.testing.assert_array_equal(again.radius, draw.radius[:back])
        np.testing.assert_array_equal(again.set_index, draw.set_index[:back])
        source.put_back(again)
        if not endless:
            assert source.remaining == 200 - len(placed)
    if every is not None:
        placed += source.take(200).radius.tolist()
        assert sorted(placed) == sorted(every.radius)
        assert source.finished


def test_a_file_is_placed_exactly_once(tmp_path: Path) -> None:
    (tmp_path / "radii.txt").write_text("0.1\n0.2\n0.3\n0.2\n")
    listed = {"radius_distribution": "file", "path": "radii.txt"}
    source = supply(zone(), listed, folder=tmp_path)
    assert source.asked == 4
    assert sorted(source.take(9).radius) == [0.1, 0.2, 0.2, 0.3]
    mixed = supply(zone(set_proportions=[0.4, 0.6]), listed, UNIFORM, folder=tmp_path).take(99)
    assert np.bincount(mixed.set_index).tolist() == [4, 6]
    by_volume = supply(zone(volume=SPHERE * (0.3**3 + 0.1**3)), listed, folder=tmp_path).take(9)
    assert sorted(by_volume.radius) == [0.1, 0.3]


def test_sizes_are_those_that_will_come() -> None:
    source = supply(zone(n_particles=50), UNIFORM)
    radius = supply(zone(n_particles=50), UNIFORM).take(50).radius
    assert (source.radius_min, source.radius_max) == (radius.min(), radius.max())
    assert source.mean_volume == pytest.approx(SPHERE * np.mean(radius**3))
    endless = supply(zone(set_proportions=[1.0, 0.0]), UNIFORM, SMALL)
    assert (endless.radius_min, endless.radius_max) == (0.05, 0.08)
    assert SPHERE * endless.radius_reference**3 == pytest.approx(endless.mean_volume)


def test_equal_spheres_are_taken_to_fill_exactly_what_they_fill_alone() -> None:
    equal = {"radius_distribution": "constant", "radius": 0.0737}
    for source in (supply(zone(), equal), supply(zone(n_particles=50), equal)):
        assert source.close_packing == EQUAL_SPHERES
        assert source.solid_fraction(0.6) == 0.6


def test_several_sizes_are_taken_to_fill_as_much_more_as_their_close_packing_does() -> None:
    drawn = supply(zone(n_particles=500), SMALL)
    radius = supply(zone(n_particles=500), SMALL).take(500).radius
    assert drawn.close_packing == close_packing_fraction(radius)
    assert drawn.solid_fraction(0.6) == pytest.approx(0.6 * drawn.close_packing / EQUAL_SPHERES)
    # A law of which spheres are drawn as they are needed packs as many of its spheres would.
    endless = supply(zone(), SMALL)
    many = supply(zone(n_particles=20_000), SMALL)
    assert endless.close_packing == pytest.approx(many.close_packing, abs=1e-3)
    assert endless.copy().close_packing == endless.close_packing


def test_the_same_seed_gives_the_same_spheres() -> None:
    first, second, other = (
        supply(zone(volume=0.1), UNIFORM, seed=seed).take(500).radius for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, second)
    assert len(first) != len(other) or (first != other).any()


def test_more_spheres_than_can_be_counted_are_refused_before_any_is_drawn() -> None:
    with pytest.raises(PackingError, match="check the unit"):
        supply(zone(volume=1e9), {"radius_distribution": "constant", "radius": 1e-5})
