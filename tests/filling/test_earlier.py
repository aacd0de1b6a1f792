"""Going on from a bed that is there: its spheres stay, come first, and new ones overlap nothing."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.check import check_bed
from packgen.errors import PackingError, ReadError, SceneError
from packgen.filling.earlier import earlier_bed
from packgen.filling.pack import pack
from packgen.filling.softness import softness
from packgen.forecast import forecast
from packgen.reading import read_bed
from tests.scenes import box, constant, read_scene, run_scene, uniform
from tests.seeds import raised

VESSEL = box([0, 0, 0], [0.5, 0.5, 1.5])
BALLS = {"name": "balls", **constant(0.05)}
STEEL = {"name": "steel", "density": 7800.0, "material": "steel", **uniform(0.04, 0.05)}


def begun(folder, sets=BALLS, count=60, **keys):
    """A first bed, and its file."""
    bed = run_scene(folder, VESSEL, sets, zones=[{"n_particles": count}], seed=raised(1), **keys).bed
    bed.save(folder / "old.npz")
    return bed


def gone_on(folder, start="old.npz", sets=BALLS, count=60, vessel=VESSEL, warn=lambda _: None, **keys):
    scene, container = read_scene(
        folder, vessel, sets, start_from=start, seed=raised(2), **{"zones": [{"n_particles": count}]} | keys
    )
    return pack(scene, container, warn=warn)


def table(folder, position, radius):
    rows = np.column_stack([np.asarray(position, float).reshape(-1, 3), np.atleast_1d(radius)])
    np.savetxt(folder / "old.csv", rows, delimiter=",", header="x,y,z,r", comments="", fmt="%.17g")


def refused(folder, kind, **keys):
    with pytest.raises(kind) as caught:
        gone_on(folder, **keys)
    return str(caught.value).replace(str(folder) + "/", "")


def test_fixed_spheres_come_first_to_the_bit_and_new_ones_overlap_nothing(tmp_path):
    old = begun(tmp_path, uniform(0.04, 0.06))
    result = gone_on(tmp_path, {"path": "old.npz", "hold": "fixed"}, uniform(0.03, 0.05))
    bed = result.bed
    assert bed.count == 120
    for name in ("position", "radius", "set_index"):
        assert np.array_equal(getattr(bed, name)[:60], getattr(old, name))
    assert check_bed(bed).within_tolerance
    assert bed.is_earlier.tolist() == [True] * 60 + [False] * 60
    assert [each.placed for each in result.zones] == [60]
    assert bed.batch_index[60:].min() > bed.batch_index[:60].max()


def test_a_reopened_surface_moves_and_loses_no_sphere(tmp_path):
    old = begun(tmp_path, uniform(0.04, 0.06))
    bed = gone_on(tmp_path).bed
    moved = (bed.position[:60] != old.position).any(axis=1)
    assert np.array_equal(bed.radius[:60], old.radius)
    assert moved.any()
    assert not moved[old.position[:, 2] < 0.1].any()
    assert bed.count == 120
    assert check_bed(bed).within_tolerance


def test_in_a_full_vessel_the_reopened_spheres_keep_a_place_when_new_ones_find_none(tmp_path):
    low = box([0, 0, 0], [0.5, 0.5, 0.6])
    old = begun(tmp_path, uniform(0.04, 0.06), count=120)
    bed = gone_on(tmp_path, sets={**uniform(0.03, 0.05), "name": "new"}, count=130, vessel=low).bed
    assert np.array_equal(bed.radius[:120], old.radius)
    assert 120 < bed.count < 250
    assert check_bed(bed).within_tolerance


def test_only_a_surface_that_lies_in_the_zone_is_reopened(tmp_path):
    old = begun(tmp_path)
    top = float(old.position[:, 2].max())
    above = {"location": {"slice": {"axis": "z", "min_bound": top + 0.01, "max_bound": 1.4}}}
    bed = gone_on(tmp_path, zones=[above]).bed
    assert np.array_equal(bed.position[:60], old.position)


def test_spheres_fill_around_and_under_what_is_there(tmp_path):
    table(tmp_path, [[0.25, 0.25, 0.12], [0.25, 0.25, 0.9]], [0.12, 0.12])
    bed = gone_on(tmp_path, {"path": "old.csv", "hold": "fixed"}, count=150).bed
    assert bed.count == 152
    assert check_bed(bed).within_tolerance
    assert (bed.position[2:, 2] < 0.1).any()


def test_dispersed_spheres_go_between_those_that_are_there(tmp_path):
    table(tmp_path, [[0.25, 0.25, 0.3]], [0.2])
    bed = gone_on(tmp_path, "old.csv", algorithm="DISPERSED", count=80).bed
    assert bed.position[0].tolist() == [0.25, 0.25, 0.3]
    assert check_bed(bed).within_tolerance


@pytest.mark.slow
def test_adam_goes_on_from_a_bed(tmp_path):
    old = begun(tmp_path, count=30)
    params = {"optimizer": "adam", "n_epoch": 100, "batch_size": 10}
    bed = gone_on(tmp_path, params=params, count=10).bed
    assert np.array_equal(bed.position[:30], old.position)
    assert check_bed(bed).within_tolerance


def test_sets_of_the_old_bed_come_first_and_those_of_one_name_are_one(tmp_path):
    steel = {"steel": {"friction": 0.2}}
    begun(tmp_path, STEEL, materials=steel)
    glass = {"name": "glass", "material": "glass", **constant(0.04)}
    materials = {"glass": {"friction": 0.3}, "steel": {"friction": 0.2}}
    zones = [{"n_particles": 40, "set_proportions": [0.75, 0.25]}]
    bed = gone_on(tmp_path, sets=[glass, STEEL], materials=materials, zones=zones).bed
    assert [each.name for each in bed.particle_sets] == ["steel", "glass"]
    assert np.bincount(bed.set_index).tolist() == [70, 30]
    assert [each.density for each in bed.particle_sets] == [7800.0, 2500.0]
    alone = gone_on(tmp_path, sets=[{**glass, "material": "glass"}], materials={"glass": {}}).bed
    found = {each.name: each.friction for each in alone.materials}
    assert found == {"steel": 0.2, "glass": 0.5}


def test_a_set_of_the_same_name_with_another_density_is_a_fault(tmp_path):
    begun(tmp_path)
    line = refused(tmp_path, SceneError, sets={**BALLS, "density": 3000.0})
    assert "particle_sets[0]: found balls with 3000 kg/m3, expected 2500 as in start_from" in line


def test_a_material_that_the_scene_states_otherwise_counts_and_is_told(tmp_path):
    begun(tmp_path, STEEL, materials={"steel": {"friction": 0.2}})
    said = []
    bed = gone_on(tmp_path, sets=STEEL, materials={"steel": {"friction": 0.4}}, warn=said.append).bed
    assert [each.friction for each in bed.materials] == [0.4]
    assert any("found friction 0.4, 0.2 in start_from" in each for each in said)


def test_spheres_of_a_density_that_no_set_has_are_refused(tmp_path):
    (tmp_path / "old.csv").write_text("x,y,z,radius,density\n0.2,0.2,0.2,0.05,7800\n")
    line = refused(tmp_path, ReadError, start="old.csv")
    assert "7800 kg/m3, expected one of balls (2500); add a set of that density" in line


def test_the_bed_that_is_written_tells_of_the_old_one_and_is_judged_alike_when_read_again(tmp_path):
    table(tmp_path, [[0.2, 0.2, 0.05], [0.2, 0.298, 0.05]], [0.05, 0.05])
    said = []
    bed = gone_on(tmp_path, {"path": "old.csv", "hold": "fixed"}, warn=said.append).bed
    told = bed.provenance["start_from"]
    assert (told["path"], told["sphere_count"], told["hold"]) == ("old.csv", 2, "fixed")
    assert any("1 pair of its spheres with overlaps of up to 0.04 of" in each for each in said)
    assert any(
        "sets are not in the file: its spheres are taken for balls of the scene" in each for each in said
    )
    bed.save(tmp_path / "new.npz")
    for each in (bed, read_bed(tmp_path / "new.npz")):
        check = check_bed(each)
        assert check.within_tolerance
        assert check.overlap_max == pytest.approx(0.04)
        assert check.new.overlap_max < 1e-6


def test_a_bed_gone_on_from_twice_has_all_its_spheres_first(tmp_path):
    first = begun(tmp_path, count=30)
    gone_on(tmp_path, {"path": "old.npz", "hold": "fixed"}, count=20).bed.save(tmp_path / "again.npz")
    bed = gone_on(tmp_path, {"path": "again.npz", "hold": "fixed"}, count=10).bed
    assert np.array_equal(bed.position[:30], first.position)
    assert bed.is_earlier.sum() == 50
    assert check_bed(bed).within_tolerance


@pytest.mark.parametrize(
    ("rows", "radius", "expected"),
    [
        ([[0.2, 0.2, 0.2], [0.2, 0.2, 9.0]], 0.05, "found 1 of 2 spheres outside the container, sphere 1 at"),
        ([[0.2, 0.2, 0.2], [0.2, 0.2, 0.26]], 0.05, "found 1 pair of its spheres with overlaps of up to 0.8"),
        ([[0.02, 0.2, 0.2]], 0.05, "found 1 of 1 spheres in walls by up to 0.6 of the radius"),
    ],
)
def test_spheres_that_no_solver_leaves_so_are_refused(tmp_path, rows, radius, expected):
    table(tmp_path, rows, [radius] * len(rows))
    assert expected in refused(tmp_path, PackingError, start="old.csv")


def test_a_file_in_millimetres_is_refused_with_the_unit_and_read_when_the_scene_says_it(tmp_path):
    old = begun(tmp_path, count=40)
    table(tmp_path, 1000.0 * old.position, 1000.0 * old.radius)
    line = refused(tmp_path, ReadError, start="old.csv")
    assert line.endswith("if the file is in mm, give `units: mm` beside the path")
    bed = gone_on(tmp_path, {"path": "old.csv", "units": "mm", "hold": "fixed"}).bed
    assert np.allclose(bed.position[:40], old.position, rtol=1e-15)


def test_spheres_of_quite_another_size_than_the_scene_has_are_told(tmp_path):
    begun(tmp_path, count=30)
    said = []
    gone_on(tmp_path, sets={"name": "dust", **constant(0.0014)}, count=5, warn=said.append)
    assert any("those of the scene are 0.0014 to 0.0014 m; check `units`" in each for each in said)


@pytest.mark.parametrize(
    ("name", "content", "expected"),
    [
        ("cut.npz", b"PK\x03\x04 cut", "no archive of numpy"),
        ("empty.csv", b"", "empty"),
        ("wrong.csv", b"x,y,z,radius\n0,0,0,-1\n", "-1"),
        ("nan.csv", b"x,y,z,radius\n0,nan,0,1\n", "nan"),
    ],
)
def test_a_file_that_is_no_bed_is_refused_with_its_place_in_the_scene(tmp_path, name, content, expected):
    (tmp_path / name).write_bytes(content)
    line = refused(tmp_path, ReadError, start=name)
    assert line.startswith("scene.yaml:")
    assert ": start_from: " in line
    assert expected in line
    assert "\n" not in line


def test_tiles_jammed_and_a_wanted_fraction_under_gravity_refuse_a_bed_that_is_there(tmp_path):
    begun(tmp_path, count=30)
    assert "start_from: found a bed to go on from, expected none" in refused(
        tmp_path, PackingError, params={"tile": 20}
    )
    assert "zones[0].solid_fraction: found start_from, expected none" in refused(
        tmp_path, PackingError, zones=[{"solid_fraction": 0.58}]
    )
    assert "not supported yet by JAMMED" in refused(tmp_path, SceneError, algorithm="JAMMED")


def test_a_surface_is_refused_where_none_can_be_reopened(tmp_path):
    table(tmp_path, [[0.2, 0.2, 0.2]], [0.05])
    start = {"path": "old.csv", "hold": "surface"}
    line = refused(tmp_path, SceneError, start=start, algorithm="DISPERSED")
    assert "start_from.hold: found 'surface', expected fixed: DISPERSED moves no sphere" in line
    endless = {**VESSEL, "periodic": ["z"]}
    assert "wraps around along gravity, expected fixed" in refused(
        tmp_path, PackingError, start=start, vessel=endless
    )
    bed = gone_on(tmp_path, "old.csv", vessel=endless).bed
    assert bed.position[0].tolist() == [0.2, 0.2, 0.2]
    assert check_bed(bed).within_tolerance


def test_more_spheres_than_fit_beside_those_that_are_there_are_refused_before_the_run(tmp_path):
    begun(tmp_path)
    line = refused(tmp_path, PackingError, count=440)
    assert "zones: found 0.2304 m3 of spheres beside 0.03142 m3 of start_from, expected at most" in line
    scene, container = read_scene(tmp_path, VESSEL, BALLS, start_from="old.npz", zones=[{"n_particles": 440}])
    with pytest.raises(PackingError, match=r"beside 0\.03142 m3 of start_from"):
        forecast(scene, container)


def test_the_weight_of_the_old_bed_presses_on_its_foot(tmp_path):
    rows = np.stack(np.meshgrid(*[np.arange(0.05, 0.5, 0.1)] * 3), axis=-1).reshape(-1, 3)
    table(tmp_path, rows, np.full(len(rows), 0.05))
    soft = {"materials": {"default": {"youngs_modulus": 2.0e6}}, "zones": [{"n_particles": 125}]}
    scene, container = read_scene(tmp_path, VESSEL, BALLS, start_from="old.csv", **soft)
    earlier = earlier_bed(scene, container, lambda _: None)
    alone, both = softness(scene, container), softness(scene, container, earlier)
    assert both.height == pytest.approx(2 * alone.height, rel=1e-3)
    assert both.overlap > 1.2 * alone.overlap
