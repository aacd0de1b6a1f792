"""Claims on dividing spheres among sets."""

from __future__ import annotations

import hypothesis
import numpy as np
import pytest
from hypothesis import strategies as st

from packgen.bed import ParticleSet
from packgen.scene import ZoneSpec
from packgen.scene.sets import ConstantSet
from packgen.supply.shares import expected_count, largest_remainder, number_shares, reached_shares
from tests.beds import box_container, make_bed

SETS = (
    ConstantSet(radius_distribution="constant", radius=1.0, density=1000.0),
    ConstantSet(radius_distribution="constant", radius=2.0, density=500.0),
)


def test_the_largest_remainders_get_what_rounding_down_leaves() -> None:
    assert largest_remainder(np.array([0.5, 0.3, 0.2]), 101).tolist() == [51, 30, 20]
    assert largest_remainder(np.array([0.0, 1.0]), 7).tolist() == [0, 7]
    assert largest_remainder(np.full(3, 1 / 3), 10).tolist() == [4, 3, 3]


@hypothesis.settings(max_examples=200, deadline=None, derandomize=True)
@hypothesis.given(st.lists(st.integers(0, 1000), min_size=1, max_size=8).filter(any), st.integers(0, 10**7))
def test_parts_add_up_and_are_within_one_of_their_quota(weights: list[int], count: int) -> None:
    share = np.array(weights) / sum(weights)
    parts = largest_remainder(share, count)
    assert parts.sum() == count
    assert (np.abs(parts - share * count) < 1.0 + 1e-9 * count).all()
    assert (parts[share == 0.0] == 0).all()


@pytest.mark.parametrize(
    ("by", "shares"), [("number", (0.5, 0.5)), ("volume", (8 / 9, 1 / 9)), ("mass", (4 / 5, 1 / 5))]
)
def test_shares_by_volume_and_mass_become_shares_by_number(by: str, shares: tuple[float, float]) -> None:
    zone = ZoneSpec.model_validate({"set_proportions": [0.5, 0.5], "proportions_by": by})
    assert number_shares(zone, SETS) == pytest.approx(shares)


def test_a_zone_expects_its_volume_or_mass_over_that_of_a_mean_sphere() -> None:
    sphere = 4 / 3 * np.pi

    def expected(**amount: float) -> float | None:
        return expected_count(ZoneSpec.model_validate({"set_proportions": [0.5, 0.5], **amount}), SETS)

    assert expected(n_particles=30) == 30
    assert expected(volume=9 * sphere) == pytest.approx(2)
    assert expected(mass=5000 * sphere) == pytest.approx(2)
    assert expected() is None


def test_reached_shares_count_what_lies_in_a_zone() -> None:
    bed = make_bed(
        [[each, 0.5, 0.5] for each in range(4)],
        [0.1, 0.1, 0.2, 0.4],
        box_container((0, 0, 0), (9, 1, 1)),
        set_index=np.array([0, 0, 1, 1], np.int32),
        zone_index=np.array([0, 0, 0, 1], np.int32),
        particle_sets=(ParticleSet("a", 1000.0, "ore"), ParticleSet("b", 3000.0, "ore")),
    )
    assert reached_shares(bed, 0, "number") == pytest.approx([2 / 3, 1 / 3])
    assert reached_shares(bed, 0, "volume") == pytest.approx([0.2, 0.8])
    assert reached_shares(bed, 0, "mass") == pytest.approx([1 / 13, 12 / 13])
    assert reached_shares(bed, 1, "volume") == [0.0, 1.0]
    assert reached_shares(bed, 2, "mass") == [0.0, 0.0]
