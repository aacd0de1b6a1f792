"""Claims on the front itself: places by closed forms, the heap's order, radii that wait."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.advancing_front.front_kernels import PLACES
from packgen.arrange.advancing_front.growth import Growth
from packgen.arrange.advancing_front.place_kernels import ALTITUDE, Aim
from packgen.arrange.space.region import make_region
from packgen.geometry import Box, Container, Surface

UP = Aim(ALTITUDE, np.array([0.0, 0.0, 1.0]), 0.0)


def region_of(size, radius):
    """A cube about the origin."""
    cube = Box(np.full(3, -0.5 * size), np.full(3, 0.5 * size))
    surface = Surface(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    container = Container("cube", cube, surface, np.stack([cube.min, cube.max]), size**3)
    return make_region(container, (), np.array([0.0, 0, -1]), 1.65 * radius, "zones[0]", radius)


def triangle(side):
    """Corners of an equilateral triangle about the origin, (3, 3)."""
    angle = 2.0 * np.pi * np.arange(3) / 3
    return side / np.sqrt(3.0) * np.column_stack([np.cos(angle), np.sin(angle), np.zeros(3)])


def growth_of(ball, radius, *, borne, size=20.0):
    radius = np.asarray(radius, float)
    region = region_of(size, radius.max())
    return Growth(region, np.asarray(ball, float), radius, UP, borne, np.random.default_rng(0))


def places_of(growth):
    rows = growth.front.row[: growth.front.counter[PLACES]]
    return growth.front.place[rows]


@pytest.mark.parametrize("radius", [1.0, 0.3, 2.5])
def test_three_spheres_that_touch_have_a_place_on_either_side(radius):
    growth = growth_of(np.column_stack([triangle(2.0), np.ones(3)]), [radius], borne=False)
    growth.provide(np.array([0]))
    height = np.sqrt((1.0 + radius) ** 2 - 4.0 / 3.0)
    found = places_of(growth)
    found = found[np.argsort(found[:, 2])]
    assert np.abs(found[:, :3] - [[0, 0, -height], [0, 0, height]]).max() < 1e-14


def test_only_the_upper_place_bears_a_weight():
    growth = growth_of(np.column_stack([triangle(2.0), np.ones(3)]), [1.0], borne=True)
    growth.provide(np.array([0]))
    assert places_of(growth)[:, 2] == pytest.approx([np.sqrt(8.0 / 3.0)], abs=1e-14)


def test_a_sphere_in_a_corner_has_places_at_two_walls():
    growth = growth_of([[-9.0, -9.0, -9.0, 1.0]], [1.0], borne=False)
    growth.provide(np.array([0]))
    # On two of three walls, and against the sphere: one diameter along the third.
    expected = [[-7.0, -9, -9], [-9, -7, -9], [-9, -9, -7]]
    found = places_of(growth)[:, :3]
    assert (
        np.abs(found[np.lexsort(found.T)] - np.array(expected)[np.lexsort(np.array(expected).T)]).max()
        < 1e-14
    )


def test_the_front_places_one_sphere_after_the_other_until_draws_end():
    radius = np.random.default_rng(1).uniform(0.5, 1.0, 400)
    growth = growth_of([[-9.0, -9.0, -9.0, 1.0]], radius, borne=True)
    growth.provide(np.array([0]))
    counts = []
    assert not growth.advance(counts.append, 0)
    placed = growth.front.draw_of[1 : growth.count]
    assert len(set(placed.tolist())) == len(placed)
    assert np.array_equal(growth.bed.ball[1 : growth.count, 3], radius[placed])
    assert counts[-1] == growth.count > 350  # 20 seeds: 400 or 401
    held = growth.front.held[: growth.count]
    waiting = set(growth.waiting.tolist()) | set(held[held >= 0].tolist())
    assert set(placed.tolist()) | waiting == set(range(len(radius) - growth.draws_left))


def test_few_draws_wait_however_many_spheres_are_placed():
    radius = np.random.default_rng(2).uniform(0.5, 1.0, 1600)
    growth = growth_of([[-9.0, -9.0, -9.0, 1.0]], radius, borne=True)
    growth.provide(np.array([0]))
    assert growth.advance(lambda _: None, 300)
    # 20 seeds: 1144 +- 8 spheres, 0 to 11 wait.
    assert growth.count > 1100
    assert len(growth.waiting) <= 40
