"""The space of a zone along gravity: as high as its shape, where that lies askew to its box."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.space.region import make_region
from packgen.geometry import Ball, Box, Cone, Container, Surface
from packgen.geometry.bounds import altitude_range, shape_bounds

ASKEW = np.array([0.36, 0.48, 0.8])
FLAT_CONE = Cone(np.array([0.1, -0.2, 0.3]), ASKEW, 0.1, 1.4, 0.0)
SURFACE = Surface(np.zeros((3, 3)), np.array([[0, 1, 2]]))


def container(shape):
    return Container("vessel", shape, SURFACE, np.array(shape_bounds(shape)), 1.0)


@pytest.mark.parametrize(
    "shape",
    [
        FLAT_CONE,
        Cone(np.zeros(3), np.array([0.0, 0.6, -0.8]), 2.0, 0.3, 0.5),
        Ball(np.array([1.0, 2.0, 3.0]), 0.7),
        Box(np.array([-1.0, 2.0, 0.0]), np.array([1.0, 3.0, 4.0])),
    ],
    ids=["flat cone", "cone", "ball", "box"],
)
def test_no_point_of_a_shape_is_outside_its_altitudes_and_some_are_near_both_ends(shape):
    rng = np.random.default_rng(1)
    low, high = np.array(shape_bounds(shape))
    points = low + rng.random((400_000, 3)) * (high - low)
    region = make_region(container(shape), [], -ASKEW, 0.05, "zone")
    altitude = (points[region.clearance(points) >= 0.0] * ASKEW).sum(axis=1)
    least, most = altitude_range(shape, ASKEW)
    assert least <= altitude.min()
    assert altitude.max() <= most
    assert altitude.min() - least < 0.1 * (most - least)
    assert most - altitude.max() < 0.1 * (most - least)


def test_a_flat_vessel_askew_to_its_box_begins_at_its_own_floor():
    region = make_region(container(FLAT_CONE), [], -ASKEW, 0.05, "zone")
    assert region.floor == pytest.approx(float((FLAT_CONE.base * ASKEW).sum()))
    assert region.ceiling == pytest.approx(region.floor + 0.1)
