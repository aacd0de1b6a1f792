"""Claims on the spheres of a zone: counts, sums and proportions as asked, and no radius lost or changed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st
from pydantic import TypeAdapter

from packgen.errors import PackingError
from packgen.radii import Draw, Supply
from packgen.scene import ParticleSetSpec, SetKeys, ZoneSpec

SPHERE = 4.0 / 3.0 * np.pi
READ: TypeAdapter[SetKeys] = TypeAdapter(ParticleSetSpec)
UNIFORM = {"radius_distribution": "uniform", "radius_min": 0.05, "radius_max": 0.08}
SMALL = {"radius_distribution": "lognormal", "radius_median": 0.02, "sigma": 0.3, "density": 4000}
CLASSES = {"radius_distribution": "discrete", "radii": [0.01, 0.1], "fractions": [0.9, 0.1]}


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
    st.sampled_from([[UNIFORM], [SMALL], [CLASSES], [UNIFORM, SMALL], [CLASSES, SMALL]]),
    st.sampled_from(["volume", "mass"]),
    st.floats(0.5, 3000.0),
    st.integers(0, 9),
)
def test_a_wanted_sum_is_met_to_half_the_smallest_sphere(
    specs: list[dict[str, Any]], by: str, spheres: float, seed: int
) -> None:
    made = sets(*specs)
    mean = float(np.mean([each.distribution.mean_volume() for each in made]))
    wanted = spheres * mean * (3000.0 if by == "mass" else 1.0)
    share = [1.0 / len(made)] * len(made)
    draw = Supply(zone(set_proportions=share, **{by: wanted}), made, np.random.default_rng(seed)).take(10**6)
    density = np.array([each.density for each in made])[draw.set_index] if by == "mass" else 1.0
    weight = SPHERE * draw.radius**3 * density
    if len(weight):
        assert abs(weight.sum() - wanted) <= 0.5 * weight.min() * (1 + 1e-9)


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


def test_the_same_seed_gives_the_same_spheres() -> None:
    first, second, other = (
        supply(zone(volume=0.1), UNIFORM, seed=seed).take(500).radius for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(first, second)
    assert len(first) != len(other) or (first != other).any()


def test_more_spheres_than_can_be_counted_are_refused_before_any_is_drawn() -> None:
    with pytest.raises(PackingError, match="check the unit"):
        supply(zone(volume=1e9), {"radius_distribution": "constant", "radius": 1e-5})
