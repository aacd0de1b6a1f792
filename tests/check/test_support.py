"""Which zones nothing holds up, in beds made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.check.support import hanging_zones
from packgen.geometry import Ball, Cone, Slice
from tests.beds import box_container, cubic_lattice, make_bed, make_container, revolved_surface

R = 0.1
TURNED = {"-z": np.eye(3), "+x": np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])}


def two_layers(lift):
    """A sheet of 5 x 5 spheres on the floor of a box and, ``lift`` above it, another one: zones 0 and 1."""
    sheet = cubic_lattice(5, R)
    sheet = sheet[sheet[:, 2] == sheet[:, 2].min()]
    position = np.concatenate([sheet, sheet + np.array([0.0, 0.0, 2.0 * R + lift])])
    return position, np.repeat(np.array([0, 1], np.int32), len(sheet))


@pytest.mark.parametrize("direction", TURNED)
@pytest.mark.parametrize(("lift", "expected"), [(0.0, []), (R, []), (5.0 * R, [1])])
def test_a_zone_above_a_gap_hangs_and_one_on_the_bed_does_not(lift, expected, direction):
    turn = TURNED[direction]
    position, zone = two_layers(lift)
    corners = np.array([[0, 0, 0], [1, 1, 2]]) @ turn.T
    container = box_container(corners.min(axis=0), corners.max(axis=0))
    bed = make_bed(position @ turn.T, R, container, zone_index=zone, gravity=turn @ [0.0, 0.0, -9.81])
    up = turn @ [0.0, 0.0, 1.0]
    floor = Slice(up, 3.0 * R + lift, 9.0, centers_only=True)
    found = hanging_zones(bed, [(), (floor,)])
    assert [each.zone for each in found] == expected
    if found:
        assert found[0].hanging == found[0].looked_at == 25
        assert found[0].fall == pytest.approx(lift)


def test_a_zone_on_the_containers_floor_does_not_hang():
    position, _ = two_layers(5.0 * R)
    bed = make_bed(position[:25], R, box_container([0, 0, 0], [1, 1, 2]))
    assert hanging_zones(bed, [(Slice(np.array([0.0, 0.0, 1.0]), R, 1.0, centers_only=True),)]) == ()


def test_a_zone_on_a_slope_of_the_container_does_not_hang():
    cone = Cone([0, 0, 0], [0, 0, 1], 2.0, 0.0, 1.0)
    container = make_container(cone, revolved_surface([(0.0, 0.0), (2.0, 1.0)], 48), 2.0)
    # touching the wall all round at one height, on the floor of their slice
    angle = 2.0 * np.pi * np.arange(8) / 8
    across = 0.5 - R * np.hypot(1.0, 0.5)
    ring = np.column_stack([across * np.cos(angle), across * np.sin(angle), np.full(8, 1.0)])
    bed = make_bed(ring, R, container)
    assert hanging_zones(bed, [(Slice(np.array([0.0, 0.0, 1.0]), 1.0, 2.0, centers_only=True),)]) == ()


def test_the_sides_of_a_location_are_no_floor():
    column = np.column_stack([np.full(5, 0.5), np.full(5, 0.5), R + 2.0 * R * np.arange(5)])
    bed = make_bed(column, R, box_container([0, 0, 0], [1, 1, 2]))
    assert hanging_zones(bed, [(Slice(np.array([1.0, 0.0, 0.0]), 0.4, 0.6, centers_only=False),)]) == ()


def test_without_gravity_nothing_hangs_and_a_ball_in_mid_air_does_with_it():
    ball = Ball([0.5, 0.5, 1.0], 0.3)
    bed = make_bed([[0.5, 0.5, 0.8]], R, box_container([0, 0, 0], [1, 1, 2]))
    (found,) = hanging_zones(bed, [(ball,)])
    assert found.fall == pytest.approx(0.7)
    bed = make_bed([[0.5, 0.5, 0.8]], R, box_container([0, 0, 0], [1, 1, 2]), gravity=np.zeros(3))
    assert hanging_zones(bed, [(ball,)]) == ()
