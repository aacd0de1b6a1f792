"""The space of a zone: as high as its shape along gravity, and what is in it."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.space.region import make_region
from packgen.geometry import Ball, Box, Cone, Container, Slice, Surface
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


def test_a_sphere_is_in_a_region_by_its_centre_and_in_a_slice_that_bounds_centres_by_any_part():
    vessel = Box(np.zeros(3), np.ones(3))
    layer = Slice(np.array([0.0, 0.0, 1.0]), 0.4, 0.6, centers_only=True)
    side = Slice(np.array([0.0, 1.0, 0.0]), 0.3, 0.7, centers_only=False)
    ball = Ball(np.array([0.5, 0.5, 0.5]), 0.4)
    region = make_region(container(vessel), [layer, side, ball], np.array([0.0, 0.0, -1.0]), 0.2, "zone")
    spheres = np.array([
        [0.5, 0.5, 0.5, 0.20], [0.5, 0.31, 0.5, 0.20], [0.5, 0.29, 0.5, 0.20], [0.5, 0.71, 0.5, 0.20],
        [0.11, 0.5, 0.5, 0.20], [0.09, 0.5, 0.5, 0.20], [0.5, 0.5, 0.79, 0.20], [0.5, 0.5, 0.79, 0.18],
        [0.5, 0.5, 0.21, 0.20], [0.5, 0.5, 0.21, 0.18], [0.5, 2.0, 0.5, 0.20],
    ])  # fmt: skip
    expected = [True, True, False, False, True, False, True, False, True, False, False]
    assert region.contains(spheres[:, :3], spheres[:, 3]).tolist() == expected
