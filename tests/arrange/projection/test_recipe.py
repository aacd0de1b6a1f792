"""How the constants of the arrangement change from sweep to sweep."""

from __future__ import annotations

import itertools
import math

import pytest

from packgen.arrange.projection.recipe import (
    BREADTH_MAX,
    FARTHER_MAX,
    FRICTION_LEAST,
    FRICTION_USUAL,
    TUBE_GRAIN,
    TUBE_MOMENTUM,
    Recipe,
)

RECIPE = Recipe()


def test_steps_down_shrink_to_the_last_one_and_fade_after_the_sinking():
    steps = [RECIPE.fall(number) for number in range(RECIPE.sink_sweeps + 40)]
    assert steps[0] == pytest.approx(RECIPE.sink_first + RECIPE.sink_last)
    assert steps[RECIPE.sink_sweeps] == pytest.approx(RECIPE.sink_last)
    assert all(later < earlier for earlier, later in itertools.pairwise(steps))
    assert steps[-1] == pytest.approx(RECIPE.sink_last * RECIPE.sink_fade**39)


def test_walls_are_rough_at_first_and_smooth_before_the_last_spheres_settle():
    rough = [RECIPE.step(number, rough=True).roughness for number in range(RECIPE.sink_sweeps)]
    assert rough[0] == RECIPE.grain
    assert rough[RECIPE.grain_sweeps :] == [0.0] * (RECIPE.sink_sweeps - RECIPE.grain_sweeps)
    assert RECIPE.step(0, rough=False).roughness == 0.0


def test_momentum_grows_to_its_full_share():
    shares = [RECIPE.step(number, rough=True).momentum for number in (0, RECIPE.momentum_sweeps, 10_000)]
    assert shares == [0.0, RECIPE.momentum, RECIPE.momentum]


def test_spheres_are_given_up_at_ever_smaller_overlaps_and_in_the_end_at_any():
    times = {number: RECIPE.too_much(number) for number in range(400)}
    asked = {number: limit for number, limit in times.items() if limit is not None}
    assert list(asked)[:2] == [RECIPE.give_up_first, RECIPE.give_up_first + RECIPE.give_up_every]
    limits = list(asked.values())
    assert limits[: len(RECIPE.give_up)] == list(RECIPE.give_up) == sorted(RECIPE.give_up, reverse=True)
    assert set(limits[len(RECIPE.give_up) :]) == {0.0}


def test_neighbour_lists_look_less_far_and_forgive_less_as_the_layer_comes_to_rest():
    first, last = 0, RECIPE.sink_sweeps
    assert (RECIPE.skin(first), RECIPE.skin(last), RECIPE.skin(10 * last)) == pytest.approx(
        (RECIPE.skin_first, RECIPE.skin_last, RECIPE.skin_last)
    )
    assert RECIPE.strays_allowed(first) == RECIPE.strays > RECIPE.strays_allowed(last)
    assert RECIPE.step(first, rough=True).far == math.inf
    assert RECIPE.step(last, rough=True).far == RECIPE.far


def test_smoother_spheres_sink_more_slowly_between_rougher_walls():
    smooth = Recipe.of_friction(0.5 * FRICTION_USUAL, 1.0e-6)
    assert smooth.sink_sweeps == 2 * RECIPE.sink_sweeps
    assert smooth.fall(2 * 40) == pytest.approx(RECIPE.fall(40))
    assert smooth.skin(2 * 40) == pytest.approx(RECIPE.skin(40))
    assert smooth.too_much(2 * RECIPE.give_up_first) == RECIPE.too_much(RECIPE.give_up_first)
    rough, usual = smooth.step(2 * 30, rough=True), RECIPE.step(30, rough=True)
    assert rough.roughness == pytest.approx(2.0**0.25 * usual.roughness)
    assert smooth.step(2 * RECIPE.far_sweeps, rough=True).far == RECIPE.far


def test_a_tube_has_smoother_walls_and_more_momentum_less_so_for_smooth_spheres():
    tube = Recipe.of_friction(FRICTION_USUAL, 1.0e-6, 10.0)
    assert (tube.grain, tube.momentum) == pytest.approx((TUBE_GRAIN, TUBE_MOMENTUM))
    assert tube.sink_sweeps == RECIPE.sink_sweeps
    smooth, plain = (Recipe.of_friction(0.5 * FRICTION_USUAL, 1.0e-6, width) for width in (10.0, None))
    assert tube.grain < smooth.grain < plain.grain
    assert plain.momentum < smooth.momentum < tube.momentum
    assert Recipe.of_friction(FRICTION_LEAST, 1.0e-6, 10.0) == Recipe.of_friction(FRICTION_LEAST, 1.0e-6)


@pytest.mark.parametrize("width", [1.0, 4.5, 30.0, 1000.0])
def test_what_is_too_narrow_or_too_wide_is_no_tube(width):
    assert Recipe.of_friction(FRICTION_USUAL, 1.0e-6, width) == RECIPE


def test_beyond_the_usual_friction_and_below_the_least_one_nothing_changes():
    assert Recipe.of_friction(FRICTION_USUAL, 1.0e-6) == Recipe.of_friction(1.5, 1.0e-6) == RECIPE
    assert Recipe.of_friction(0.0, None) == Recipe.of_friction(FRICTION_LEAST, None)
    assert Recipe.of_friction(0.0, None).tolerance is None


def test_broad_sizes_sink_farther_and_are_given_up_later_equal_ones_as_ever():
    assert RECIPE.of_sizes(1.0) is RECIPE
    broad = RECIPE.of_sizes(2.0)
    assert 1.0 - broad.momentum == pytest.approx(0.5 * (1.0 - RECIPE.momentum))
    assert broad.give_up_first == round(1.5 * RECIPE.give_up_first)
    assert broad.skin_first == 1.5 * RECIPE.skin_first
    assert broad.fall(0) == RECIPE.fall(0)


def test_sizes_far_apart_fall_in_longer_steps_up_to_a_limit():
    broad, far_apart = RECIPE.of_sizes(BREADTH_MAX), RECIPE.of_sizes(1.5 * BREADTH_MAX)
    for number in (0, 100, 300):
        assert far_apart.fall(number) == pytest.approx(1.5 * broad.fall(number))
    assert far_apart.momentum == broad.momentum
    limit = RECIPE.of_sizes(FARTHER_MAX * BREADTH_MAX)
    assert RECIPE.of_sizes(10.0 * FARTHER_MAX * BREADTH_MAX) == limit
