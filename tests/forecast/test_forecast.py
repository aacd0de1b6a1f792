"""What a scene's bed will be like, against geometry, and against beds that were packed."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.container import load_container
from packgen.errors import PackingError
from packgen.filling.pack import pack
from packgen.forecast import forecast, remedies
from packgen.forecast.telling import as_data, rows
from packgen.measure import solid_fraction
from packgen.scene import load_scene

SPHERE = 4.0 / 3.0 * np.pi


def scene_of(container, zones, *, radius=0.004, **keys):
    sets = [{"radius_distribution": "constant", "radius": radius}]
    return load_scene({"container": container, "particle_sets": sets, "zones": zones, **keys})


def told(scene):
    return forecast(scene, load_container(scene))


BOX = {"box": {"min": [0, 0, 0], "max": [0.2, 0.2, 0.3]}}


def test_numbers_masses_and_heights_follow_from_the_solid_fraction():
    found = told(scene_of(BOX, [{"n_particles": 5000}]))
    solid = 5000 * SPHERE * 0.004**3
    assert found.sphere_count == 5000
    assert found.mass == pytest.approx(2500 * solid)
    assert 0.55 < found.solid_fraction < 0.615
    assert found.height == pytest.approx(solid / found.solid_fraction / 0.04, rel=0.01)
    assert found.zones[0].height_needed == pytest.approx(found.height)
    assert found.missed == found.warnings == ()


def test_a_zone_without_an_amount_is_full():
    found = told(scene_of(BOX, [{}]))
    assert found.height == pytest.approx(0.3)
    assert found.sphere_count * SPHERE * 0.004**3 == pytest.approx(found.solid_fraction * 0.012, rel=0.001)


@pytest.mark.parametrize("axis", ["x", "-z", [0.0, 0.6, -0.8]])
def test_heights_stand_along_gravity(axis):
    found = told(scene_of(BOX, [{"n_particles": 3000}], gravity_axis=axis))
    up = found.up
    high = {"x": 0.2, "-z": 0.3}.get(str(axis))
    assert np.linalg.norm(up) == pytest.approx(1.0)
    if high is not None:
        area = 0.012 / high
        filled = 3000 * SPHERE * 0.004**3 / found.solid_fraction
        assert found.height == pytest.approx(filled / area, rel=0.01)


def test_a_later_zone_lies_on_the_earlier_one():
    cut = {"slice": {"axis": "z", "min_bound": 0.0, "max_bound": 0.1}}
    found = told(scene_of(BOX, [{"location": cut}, {"n_particles": 3000}]))
    lower, upper = found.zones
    assert lower.top == pytest.approx(0.104)
    assert upper.bottom == pytest.approx(lower.top)
    assert found.height == upper.top


def test_an_amount_that_will_not_fit_is_told_with_the_height_that_it_needs():
    found = told(scene_of(BOX, [{"n_particles": 28000}]))
    assert len(found.missed) == 1
    assert found.missed[0].startswith("scene: zones[0].n_particles: about ")
    assert "of 28,000 spheres will fit; ask for fewer, or make it 0." in found.missed[0]
    zone = found.zones[0]
    assert zone.sphere_count < 28000
    assert zone.height_needed == pytest.approx(0.3 * 28000 / zone.sphere_count, rel=0.01)


def test_of_a_few_spheres_no_miss_is_foretold():
    found = told(scene_of(BOX, [{"n_particles": 2}], radius=0.09))
    assert found.missed == ()
    box = {"box": {"min": [0, 0, 0], "max": [0.2, 0.2, 0.35]}}
    few = told(scene_of(box, [{"n_particles": 2}], radius=0.09))
    assert few.missed == ()


def test_an_amount_that_is_refused_has_a_remedy():
    scene = scene_of(BOX, [{"n_particles": 90000}])
    container = load_container(scene)
    with pytest.raises(PackingError, match="expected at most"):
        forecast(scene, container)
    assert remedies(scene, container) == [remedies(scene, container)[0]]
    assert "90,000 spheres need a height of" in remedies(scene, container)[0]
    assert remedies(scene_of(BOX, [{"n_particles": 100}]), container) == []


def test_the_cube_that_an_amount_needs_holds_it():
    found = told(scene_of(BOX, [{"n_particles": 5000}]))
    edge = found.cube_needed
    again = told(scene_of({"box": {"min": [0, 0, 0], "max": [edge] * 3}}, [{"n_particles": 5000}]))
    assert again.height == pytest.approx(edge, rel=0.03)


def test_a_zone_above_free_space_is_not_held_up():
    cut = {"slice": {"axis": "z", "min_bound": 0.15, "max_bound": 0.3}}
    found = told(scene_of(BOX, [{"location": cut, "n_particles": 1000}]))
    assert ["nothing will hold it up" in line for line in found.warnings] == [True]
    assert "fall by about 0.15 m" in found.warnings[0]
    lower = {"slice": {"axis": "z", "min_bound": 0.0, "max_bound": 0.15}}
    assert told(scene_of(BOX, [{"location": lower}, {"location": cut}])).warnings == ()


def test_a_zone_beside_free_space_is_not_held_at_its_side():
    column = {"box": {"min": [0, 0, 0], "max": [0.08, 0.2, 0.2]}}
    found = told(scene_of(BOX, [{"location": column}]))
    assert ["of its side, which will fall" in line for line in found.warnings] == [True]
    beside = {"box": {"min": [0.08, 0, 0], "max": [0.2, 0.2, 0.2]}}
    assert told(scene_of(BOX, [{"location": column}, {"location": beside}])).warnings == ()


def test_a_jammed_cell_takes_the_size_that_the_spheres_need():
    cell = {"box": {"min": [0, 0, 0], "max": [0.2, 0.2, 0.2]}, "periodic": ["x", "y", "z"]}
    found = told(scene_of(cell, [{"n_particles": 1000}], radius=0.01, algorithm="JAMMED"))
    solid = 1000 * SPHERE * 0.01**3
    assert found.factor == pytest.approx((solid / found.close_packing / 0.008) ** (1 / 3))
    assert found.cube_needed == pytest.approx(0.2 * found.factor)
    assert found.height is None
    assert found.missed == found.warnings == ()


def test_dispersed_spheres_have_the_fraction_asked_for():
    found = told(scene_of(BOX, [{"solid_fraction": 0.3}], algorithm="DISPERSED"))
    assert found.solid_fraction == pytest.approx(0.3)
    assert found.sphere_count == pytest.approx(0.3 * 0.012 / (SPHERE * 0.004**3), rel=0.001)
    assert found.height is None


def test_warnings_are_those_that_a_run_gives_before_it_starts():
    materials = {"mud": {"youngs_modulus": 2.0e4}}
    scene = scene_of(BOX, [{"n_particles": 5000}], materials=materials)
    said = []
    forecast(scene, load_container(scene), said.append)
    assert len(said) == 1
    assert "expected at least" in said[0]


def test_plain_data_and_rows_say_the_same():
    scene = scene_of(BOX, [{"n_particles": 5000}])
    found = told(scene)
    data = as_data(found, scene)
    assert data["zones"][0]["sphere_count"] == data["sphere_count"] == 5000
    assert data["height"] == found.height
    assert dict(rows(found))["spheres"] == "5,000 of 5,000"


@pytest.mark.slow
@pytest.mark.parametrize(
    "container", [BOX, {"cylinder": {"radius": 0.06, "height": 0.6}}, {"sphere": {"radius": 0.1}}]
)
def test_beds_are_as_high_and_as_dense_as_told(container):
    scene = scene_of(container, [{"n_particles": 5000}])
    vessel = load_container(scene)
    found, bed = forecast(scene, vessel), pack(scene, vessel).bed
    reached = solid_fraction(bed).filled
    highest = float((bed.position[:, 2] + bed.radius).max() - vessel.bounds[0, 2])
    assert found.solid_fraction == pytest.approx(reached, abs=0.02)
    assert found.highest == pytest.approx(highest, abs=0.006)  # three quarters of a diameter
