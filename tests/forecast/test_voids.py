"""Claims on what filling voids is expected to come to."""

from __future__ import annotations

import pytest

from packgen.distributions import Free
from packgen.forecast.voids import expected_voids


def test_number_and_share_are_those_of_a_cube_that_was_filled() -> None:
    for number, share in ((33, 0.686), (500, 0.792), (5000, 0.869)):
        count, found = expected_voids(Free(1e-6), number, None, 1.0)
        assert count == number
        assert found == pytest.approx(share, abs=0.07)


def test_what_ends_first_ends_it() -> None:
    by_size, _ = expected_voids(Free(0.05), None, None, 1.0)
    assert 30 < by_size < 150
    assert expected_voids(Free(0.05), 20, None, 1.0)[0] == 20
    assert expected_voids(Free(1e-6), None, 0.8, 1.0)[0] < 2000
    count, share = expected_voids(Free(0.01, 0.02), 100, None, 1.0)
    assert share <= count * 4.19 * 0.02**3
