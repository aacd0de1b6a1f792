"""Vessels and locations hardly wider than a sphere, or with tips: a sphere that fits is placed, at once."""

from __future__ import annotations

import math

import numpy as np
import pytest

from packgen.errors import PackingError
from packgen.filling.pack import pack
from tests.scenes import assert_sound, box, constant, read_scene, run_scene, uniform

TIGHT = {"location": {"sphere": {"radius": 0.041, "center": [0.1, 0.1, 0.1]}}}


def cone(top, height=1.0):
    return {"cone": {"radius_bottom": 0.0, "radius_top": top, "height": height}}


@pytest.mark.parametrize("axes", [[], ["y"], ["y", "z"], ["x", "y", "z"]], ids=str)
@pytest.mark.parametrize("amount", [{}, {"n_particles": 1}], ids=["full", "one"])
def test_a_location_that_a_sphere_hardly_fits_into_gets_it(tmp_path, axes, amount):
    vessel = {**box([0, 0, 0], [0.2, 0.2, 0.2]), "periodic": axes}
    result = run_scene(tmp_path, vessel, constant(0.04), zones=[{**TIGHT, **amount}])
    assert result.bed.count == 1
    assert np.linalg.norm(result.bed.position[0] - 0.1) <= 0.001 + 1e-9


def test_a_tight_location_far_smaller_than_its_endless_box_gets_its_sphere(tmp_path):
    vessel = {**box([0, 0, 0], [9, 9, 9]), "periodic": ["x", "y", "z"]}
    assert run_scene(tmp_path, vessel, constant(0.04), zones=[TIGHT]).bed.count == 1


def test_a_location_too_tight_for_its_sphere_stays_empty(tmp_path):
    zones = [{"location": {"sphere": {"radius": 0.039, "center": [0.1, 0.1, 0.1]}}}]
    for axes in ([], ["y", "z"]):
        vessel = {**box([0, 0, 0], [0.2, 0.2, 0.2]), "periodic": axes}
        with pytest.raises(PackingError, match="not one sphere"):
            run_scene(tmp_path, vessel, constant(0.04), zones=zones)


@pytest.mark.parametrize(("top", "radius"), [(0.01, 0.0095), (0.01, 0.003), (0.04, 0.0003)])
def test_a_sphere_in_a_steep_tip_lies_as_deep_as_it_fits_and_is_found_at_once(tmp_path, top, radius):
    told = []
    scene, vessel = read_scene(tmp_path, cone(top), constant(radius), zones=[{"n_particles": 1}])
    result = pack(scene, vessel, on_progress=told.append)
    assert_sound(result)
    assert result.bed.position[0, 2] == pytest.approx(radius / math.sin(math.atan(top)), rel=1e-3)
    assert len(told) == 1


def test_a_steep_tip_is_filled_up_to_where_it_is_wide_and_beyond(tmp_path):
    result = run_scene(tmp_path, cone(0.02), constant(0.003))
    altitude = np.sort(result.bed.position[:, 2])
    assert result.bed.count > 1500  # 2,780 of them have the volume of the cone
    assert altitude[0] < 0.16  # 20 seeds: 0.1501 to 0.1553. A sphere touches the wall all round at 0.1500.
    assert np.diff(altitude).max() < 0.012  # two diameters: nothing is left out in between
    assert altitude[-1] > 0.99


def test_spheres_of_several_sizes_find_places_in_a_steep_tip_too(tmp_path):
    result = run_scene(tmp_path, cone(0.02), uniform(0.004, 0.01), zones=[{"n_particles": 5}])
    assert result.bed.count == 5
