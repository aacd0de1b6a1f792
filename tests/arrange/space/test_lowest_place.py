"""The lowest place of a sphere in a region, held against what geometry says."""

from __future__ import annotations

import math

import numpy as np
import pytest

from packgen.arrange.space.lowest_place import lowest_place
from packgen.arrange.space.region import make_region
from packgen.container import load_container
from packgen.geometry import Ball, Slice
from tests import container_meshes as meshes
from tests.scenes import box, constant, read_scene

DOWN = np.array([0.0, 0.0, -1.0])


def place_in(folder, container, radius, *locations, down=DOWN, others=()):
    """The lowest place in a container as a scene has it."""
    scene, _ = read_scene(folder, container, constant(0.01))
    region = make_region(load_container(scene), locations, np.asarray(down), radius, "zone")
    return region, lowest_place(region, radius, np.reshape(others, (-1, 4)))


def cone(top, height=10.0, **keys):
    return {"cone": {"radius_bottom": 0.0, "radius_top": top, "height": height, **keys}}


def altitude_in_tip(radius, top, height=10.0):
    """Where a sphere touches the side all around."""
    return radius / math.sin(math.atan(top / height))


@pytest.mark.parametrize(("top", "radius"), [(4.0, 0.0003), (0.1, 0.03), (0.4, 0.0003), (0.01, 0.0095)])
def test_a_sphere_goes_as_deep_into_a_tip_as_it_fits(tmp_path, top, radius):
    region, place = place_in(tmp_path, cone(top), radius)
    exact = altitude_in_tip(radius, top)
    assert place.altitude == pytest.approx(place.center[2])
    assert exact <= place.altitude <= exact + 2e-4 * radius + 1e-9 * exact
    assert region.clearance(place.center[None], radius)[0] >= 0.0


def test_a_tilted_tip_is_gone_into_along_gravity(tmp_path):
    axis = np.array([0.6, 0.0, 0.8])
    _, upright = place_in(tmp_path, cone(0.5), 0.02)
    _, tilted = place_in(tmp_path, cone(0.5, axis=axis.tolist()), 0.02, down=-axis)
    assert tilted.altitude == pytest.approx(upright.altitude, abs=1e-5)
    assert tilted.center @ axis == pytest.approx(upright.altitude, abs=1e-5)


def test_where_no_sphere_fits_there_is_none_at_all(tmp_path):
    for container, radius in ((cone(0.01, 1.0), 0.00996), (box([0, 0, 0], [0.2, 0.2, 0.1]), 0.052)):
        _, place = place_in(tmp_path, container, radius)
        assert place.center is None
        assert place.altitude == math.inf


def test_a_sphere_as_wide_as_its_vessel_may_have_a_place(tmp_path):
    _, place = place_in(tmp_path, box([0, 0, 0], [0.1, 0.1, 0.1]), 0.05)
    assert place.altitude <= 0.05 + 1e-12


def test_a_location_bounds_the_place_and_so_do_other_spheres(tmp_path):
    vessel, ball = box([0, 0, 0], [1, 1, 1]), Ball(np.array([0.5, 0.5, 0.5]), 0.101)
    _, alone = place_in(tmp_path, vessel, 0.1, ball)
    assert alone.altitude == pytest.approx(0.499, abs=2e-4)
    high = Slice(np.array([0.0, 0.0, 1.0]), 0.3, 0.9, centers_only=True)
    _, place = place_in(tmp_path, vessel, 0.1, high)
    assert place.altitude == pytest.approx(0.3, abs=2e-5)
    _, stacked = place_in(tmp_path, cone(0.1), 0.03, others=[0.0, 0.0, altitude_in_tip(0.03, 0.1), 0.03])
    assert stacked.altitude == pytest.approx(altitude_in_tip(0.03, 0.1) + 0.06, abs=1e-4)


@pytest.mark.parametrize("radius", [0.02, 0.1])
def test_a_mesh_that_is_not_convex_is_searched_inside_only(tmp_path, radius):
    meshes.saved(meshes.standing(meshes.torus()), tmp_path)
    region, place = place_in(tmp_path, {"path": "vessel.stl"}, radius)
    # The lowest point of the ring's facets, and one radius above it.
    assert place.altitude == pytest.approx(-1.4 + radius, abs=0.02)
    assert region.holds(place.center[None]).all()
    assert region.clearance(place.center[None], radius)[0] >= 0.0
