"""Claims on spheres whose sizes are those of the voids."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.distributions import Free, ParameterError


def test_what_is_drawn_stands_for_spheres_of_at_least_the_least_radius() -> None:
    law = Free(0.02, 0.5)
    assert law.radius_bounds == (0.02, 0.02)
    assert (law.radius_min, law.radius_max) == (0.02, 0.5)
    assert law.sample(np.random.default_rng(0), 3).tolist() == [0.02] * 3
    assert Free(0.02).radius_max is None


def test_a_largest_radius_below_the_least_one_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"radius_max: found 0.01, expected at least radius_min = 0.02"):
        Free(0.02, 0.01)
    assert Free(0.02, 0.02).radius_max == 0.02
