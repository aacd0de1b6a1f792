"""How long a run will take."""

from __future__ import annotations

import pytest

from packgen.arrange.collective.params import Params
from packgen.arrange.dispersed.params import Params as Dispersed
from packgen.forecast.costs import AIMED, FINISH, PROJECTION, START, cost_of


def test_a_solid_fraction_under_gravity_takes_several_beds_and_without_it_one():
    plain, aimed = (
        cost_of("COLLECTIVE_ARRANGEMENT", Params(), 1e5, 1.0, aimed=aimed).seconds for aimed in (False, True)
    )
    assert plain == pytest.approx(START + 1e5 * (PROJECTION + FINISH))
    assert aimed == pytest.approx(plain + 1e5 * (AIMED - 1.0) * PROJECTION)
    both = {cost_of("DISPERSED", Dispersed(), 1e5, 1.0, aimed=aimed).seconds for aimed in (False, True)}
    assert len(both) == 1
