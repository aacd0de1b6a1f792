"""What can never fit is said before a run: zones outside, spheres too wide or too many, wrong units."""

from __future__ import annotations

from importlib.metadata import EntryPoint

import pytest
import trimesh

from packgen.errors import PackingError
from packgen.filling.fit import checked_locations
from tests import container_meshes as meshes
from tests.scenes import box, constant, read_scene, uniform

CUBE = box([0, 0, 0], [1, 1, 1])
R = 0.05


def faults(folder, container=CUBE, sets=None, **keys):
    """The lines of a refused scene."""
    scene, vessel = read_scene(folder, container, sets or constant(R), **keys)
    with pytest.raises(PackingError) as refused:
        checked_locations(scene, vessel)
    return str(refused.value).splitlines()


def warnings(folder, container=CUBE, sets=None, **keys):
    """The lines that an accepted scene is warned with."""
    scene, vessel = read_scene(folder, container, sets or constant(R), **keys)
    lines = []
    checked_locations(scene, vessel, lines.append)
    return lines


def slice_of(axis, low, high):
    return {"location": {"slice": {"axis": axis, "min_bound": low, "max_bound": high}}}


def test_every_wrong_zone_is_named_with_what_is_wrong_at_once(tmp_path):
    meshes.saved(trimesh.Trimesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]), tmp_path, "flat.stl")
    zones = [
        slice_of("z", 0.0, 0.5),
        slice_of("z", 1.5, 2.0),
        {"location": {"sphere": {"radius": 0.3, "center": [-2, 0, 0]}}},
        {"location": {"path": "flat.stl"}},
        slice_of("x", 0.5, 0.51),
        {"location": {"cylinder": {"radius": 0.4, "height": 1, "base": [0.5, 0.5, 0]}}, "n_particles": 900},
    ]
    lines = faults(tmp_path, zones=zones)
    assert len(lines) == 5
    for line, path, words in zip(
        lines,
        [
            "zones[1].location",
            "zones[2].location",
            "scene.yaml:",
            "zones[4].location",
            "zones[5].n_particles",
        ],
        [
            "lies outside the container: found 1.5 to 2 m along z, the container goes from 0 to 1 m",
            "lies outside the container: found -2.3 to -1.7 m along x",
            "the mesh is flat",
            "found 0.01 m along x within the container, but not one sphere of it fits",
            "found 900, expected at most",
        ],
        strict=True,
    ):
        assert "scene.yaml:" in line
        assert path in line
        assert words in line


def test_a_zone_in_the_corner_outside_a_round_container_is_outside_it(tmp_path):
    zones = [{"location": box([0.8, 0.8, 0.2], [1, 1, 0.6])}]
    (line,) = faults(tmp_path, {"cylinder": {"radius": 1.0, "height": 1.0}}, zones=zones)
    assert "zones[0].location: lies outside the container, although" in line


def test_a_zone_in_the_hole_of_a_torus_is_outside_it(tmp_path):
    torus = {"path": meshes.saved(meshes.torus(), tmp_path)}
    zones = [{"location": {"sphere": {"radius": 0.3}}}, {"location": {"sphere": {"radius": 1.0}}}]
    (line,) = faults(tmp_path, torus, zones=zones)
    assert "zones[0].location: lies outside" in line


@pytest.mark.parametrize(
    ("amount", "found", "most"),
    [
        ({"n_particles": 1300}, "n_particles: found 1,300,", "at most 1,255:"),
        ({"volume": 0.68}, "volume: found 0.68 m3,", "at most 0.6573 m3:"),
        ({"mass": 1700.0}, "mass: found 1,700 kg,", "at most 1643 kg:"),
    ],
)
def test_more_spheres_than_a_random_packing_holds_are_refused_before_the_run(tmp_path, amount, found, most):
    (line,) = faults(tmp_path, zones=[amount])
    assert found in line
    assert most in line
    assert "no random packing of such spheres fills more than 0.66, and a poured bed about 0.55" in line
    assert "scene.yaml:" in line


def test_random_close_packing_is_not_refused(tmp_path):
    assert warnings(tmp_path, zones=[{"volume": 0.645}]) == []


def test_small_spheres_between_large_ones_may_fill_more_than_equal_ones_but_not_all(tmp_path):
    sets = [constant(0.1), constant(0.005)]
    zone = {"set_proportions": [0.7, 0.3], "proportions_by": "volume"}
    assert warnings(tmp_path, sets=sets, zones=[zone | {"volume": 0.8}]) == []
    (line,) = faults(tmp_path, sets=sets, zones=[zone | {"volume": 0.92}])
    assert "volume: found 0.92 m3, expected at most 0.8" in line
    alone = zone | {"set_proportions": [0.0, 1.0], "volume": 0.8}
    assert "no random packing" in faults(tmp_path, sets=sets, zones=[alone])[0]


def test_an_algorithm_of_others_may_build_crystals(tmp_path, monkeypatch):
    lattice = EntryPoint("LATTICE", "tests.filling.test_fit:faults", "packgen.algorithms")
    monkeypatch.setattr("packgen.arrange.registry.entry_points", lambda group: [lattice])
    assert warnings(tmp_path, zones=[{"volume": 0.72}], algorithm="LATTICE") == []
    (line,) = faults(tmp_path, zones=[{"volume": 0.75}], algorithm="LATTICE")
    assert "no packing of such spheres fills more than 0.74" in line


def test_a_tube_as_wide_as_its_spheres_holds_a_string_of_them(tmp_path):
    tube = {"cylinder": {"radius": R, "height": 100 * 2 * R}}
    assert warnings(tmp_path, tube, zones=[{"n_particles": 100}]) == []


def test_a_cell_of_few_spheres_may_be_denser_than_a_large_one(tmp_path):
    cell = {**box([0] * 3, [8 * R] * 3), "periodic": ["x", "y", "z"]}
    assert warnings(tmp_path, cell, zones=[{"n_particles": 80}]) == []


def test_one_sphere_in_a_vessel_of_its_own_size_is_not_too_many(tmp_path):
    assert warnings(tmp_path, {"sphere": {"radius": R}}, zones=[{"n_particles": 1}]) == []


def test_zones_that_fit_one_by_one_but_not_together_are_refused(tmp_path):
    (line,) = faults(tmp_path, zones=[{"volume": 0.4}, {"volume": 0.4}])
    assert "zones: found 0.8 m3 of spheres in all of them together, expected at most 0.6573 m3" in line


def test_a_slice_holds_what_reaches_beyond_it(tmp_path):
    # 0.1 m of centres are 0.2 m of spheres; more than those is too many
    zone = slice_of("z", 0.4, 0.5)
    assert warnings(tmp_path, zones=[zone | {"volume": 0.14}]) == []
    (line,) = faults(tmp_path, zones=[zone | {"volume": 0.16}])
    assert "the zone has 0.2 m3" in line


@pytest.mark.parametrize(("units", "size"), [("mm", "0.002 x 0.002 x 0.002 m"), ("um", "2e-06 x")])
def test_a_mesh_in_too_small_a_unit_is_told_with_the_likely_one(tmp_path, units, size):
    name = meshes.saved(trimesh.creation.box((2.0, 2.0, 2.0)), tmp_path, "vessel.stl")
    (line,) = faults(tmp_path, {"path": name, "units": units})
    assert f"container: found {size}" in line
    assert "not one sphere fits (smallest radius 0.05 m)" in line
    assert f"vessel.stl is read in `units: {units}`: did you mean m (2 x 2 x 2 m)" in line


def test_a_mesh_in_too_large_a_unit_is_told_with_the_likely_one(tmp_path):
    name = meshes.saved(trimesh.creation.box((2000.0, 2000.0, 2000.0)), tmp_path, "vessel.stl")
    (line,) = faults(tmp_path, {"path": name})
    assert "found 8e+09 m3 to fill, about 9.17e+12 spheres" in line
    assert "did you mean mm (2 x 2 x 2 m)" in line
    (line,) = warnings(tmp_path, {"path": name}, zones=[{"n_particles": 500}])
    assert "container: 2000 x 2000 x 2000 m, 20,000 times as wide as the largest sphere" in line
    assert "did you mean mm" in line


def test_a_very_long_run_is_told_before_it_starts(tmp_path):
    (line,) = warnings(tmp_path, box([0] * 3, [50] * 3))
    assert "zones[0]: about 1.43e+08 spheres will fill its 1.25e+05 m3" in line
    assert "check the units" in line


def test_a_set_wider_than_the_container_is_named(tmp_path):
    sets = [constant(R), uniform(0.3, 0.7)]
    (line,) = faults(tmp_path, sets=sets, zones=[{"set_proportions": [0.9, 0.1]}])
    assert "particle_sets[1]: found spheres up to 1.4 m wide" in line
    assert "% of the mass in spheres wider than the container, 1 m along x" in line
