"""A supply goes on elsewhere: copies of it, its parts, and bodies that are taken and put back as a whole."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from packgen.supply.shares import largest_remainder
from packgen.supply.supply import Draw, Supply
from tests.supply.test_supply import SMALL, UNIFORM, sets, supply, zone


@pytest.mark.parametrize("amount", [{"n_particles": 1001}, {}])
def test_a_copy_goes_on_as_the_supply_would_and_leaves_it_as_it_is(amount: dict[str, Any]) -> None:
    source = Supply(zone(set_proportions=[1.0], **amount), sets(UNIFORM), np.random.default_rng(3))
    other = source.copy()
    first = other.take(300)
    other.put_back(Draw(first.radius[:10], first.set_index[:10]))
    assert np.array_equal(source.copy().take(300).radius, first.radius)
    source.go_on_from(other)
    assert np.array_equal(source.take(10).radius, first.radius[:10])
    assert source.drawn_count == (1001 if amount else 300)


@pytest.mark.parametrize("shares", [[1.0], [0.5, 0.5], [0.2, 0.5, 0.3]])
def test_the_parts_of_a_supply_hold_together_what_it_held_each_with_its_share(shares: list[float]) -> None:
    spec = zone(set_proportions=[0.4, 0.6], n_particles=503)
    source = Supply(spec, sets(UNIFORM, SMALL), np.random.default_rng(3))
    source.take(3)
    parts = source.split(shares)
    assert [part.remaining for part in parts] == largest_remainder(np.array(shares), 500).tolist()
    drawn = [part.take(10**6) for part in parts]
    assert np.array_equal(np.concatenate([each.radius for each in drawn]), source.copy().take(500).radius)
    assert all(part.finished for part in parts)
    for draw in drawn:  # the sizes are mixed in each part
        assert abs((draw.set_index == 0).sum() - 0.4 * len(draw.radius)) < 2.0


def test_the_parts_of_an_endless_supply_draw_by_its_laws_and_apart() -> None:
    source = Supply(zone(set_proportions=[1.0]), sets(UNIFORM), np.random.default_rng(3))
    first, second = (part.take(2000).radius for part in source.split([0.5, 0.5]))
    assert not np.array_equal(first, second)
    assert np.mean(first) == pytest.approx(np.mean(second), rel=2e-3)


def clumps(*sizes: int, first: int = 0) -> Draw:
    """Bodies of so many spheres each; the radii tell which sphere is which."""
    body = np.repeat(np.arange(first, first + len(sizes), dtype=np.int32), sizes)
    radius = first + np.arange(1.0, len(body) + 1.0)
    return Draw(radius, np.zeros(len(body), np.int32), body)


def bodies_only(draw: Draw) -> Supply:
    source = supply(zone(n_particles=1), UNIFORM)
    source.take(1)
    source.put_back(draw)
    return source


def test_bodies_are_counted_taken_and_put_back_as_a_whole() -> None:
    source = bodies_only(clumps(2, 3, 1, 2))
    assert source.remaining == 4
    draw = source.take(2)
    assert draw.body_index is not None
    assert draw.body_index.tolist() == [0, 0, 1, 1, 1]
    assert draw.body_count == 2
    assert source.remaining == 2
    source.put_back(draw.split(1)[1])
    assert source.remaining == 3
    again = source.take(9)
    assert again.radius.tolist() == [3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
    assert again.body_index is not None
    assert again.body_index.tolist() == [1, 1, 1, 2, 3, 3]
    assert source.finished


def test_a_part_of_a_body_is_not_taken_back() -> None:
    source = bodies_only(clumps(2, 3))
    draw = source.take(2)
    assert draw.body_index is not None
    with pytest.raises(ValueError, match="found 2 spheres of body 1, expected all 3"):
        source.put_back(Draw(draw.radius[:4], draw.set_index[:4], draw.body_index[:4]))
    assert source.finished
    source.put_back(draw)
    assert source.remaining == 2


def test_bodies_put_back_with_lone_spheres_stay_bodies() -> None:
    source = bodies_only(clumps(2, 2))
    source.put_back(Draw(np.array([7.0]), np.array([0], np.int32)))
    draw = source.take(9)
    assert draw.radius.tolist() == [7.0, 1.0, 2.0, 3.0, 4.0]
    assert draw.body_index is not None
    assert draw.body_index.tolist() == [2, 0, 0, 1, 1]


def test_without_bodies_each_sphere_is_one() -> None:
    source = supply(zone(n_particles=9), UNIFORM)
    draw = source.take(4)
    assert draw.body_index is None
    assert draw.body_count == 4
    assert source.remaining == 5


@pytest.mark.parametrize("body", [[0, 1, 0], [0, 1]])
def test_a_draw_of_bodies_in_two_places_or_of_another_length_is_refused(body: list[int]) -> None:
    with pytest.raises(ValueError, match=r"draw\.body_index"):
        Draw(np.ones(3), np.zeros(3, np.int32), np.array(body, np.int32))
