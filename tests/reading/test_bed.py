"""A bed of a file's spheres: what is not known is left open, or comes from a scene."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import exporters
from packgen import load_container, load_scene, pack, read_bed
from packgen.bedfile import save_bed
from packgen.check import check_bed
from packgen.errors import ExportError, ReadError
from packgen.reading import unknowns
from tests.beds import box_container, make_bed
from tests.reading.beds import dump_text, mixed_bed, text_file, write

SCENE = """
container: {box: {min: [0, 0, 0], max: [3, 3, 3]}}
gravity_axis: -x
particle_sets:
  - {name: a, radius_distribution: constant, radius: 0.1, density: 2500, material: coke}
  - {name: b, radius_distribution: constant, radius: 0.1, density: 3500, material: ore}
materials:
  ore: {friction: 0.25}
  coke: {friction: 0.75}
wall_material: ore
zones:
  - {n_particles: 5, set_proportions: [0.5, 0.5]}
params: {tolerance: 1.0e-3}
"""
ALL = ("density", "materials", "walls")


@pytest.fixture
def scene(tmp_path):
    (tmp_path / "scene.yaml").write_text(SCENE)
    return load_scene(tmp_path / "scene.yaml")


def test_what_a_file_does_not_say_is_left_open(tmp_path):
    said = []
    bed = read_bed(text_file(tmp_path, "0 0 0 1\n0 0 2 1\n"), warn=said.append)
    assert np.isnan(bed.density).all()
    assert bed.materials == ()
    assert bed.container.bounds.tolist() == [[-1, -1, -1], [1, 1, 3]]
    assert check_bed(bed).overlap_max == 0.0
    assert [line.partition(" ")[0] for line in unknowns(bed, ALL)] == ["density", "materials", "walls"]
    assert unknowns(bed, ()) == []
    assert ["walls are not in the file: figures are" in line for line in said] == [True, False]
    assert "gravity is not in the file: -z is taken for down" in said[1]


def test_densities_are_given_for_all_sets_or_by_name(tmp_path):
    path = text_file(tmp_path, "0 0 0 1 0\n0 0 2 1 3\n")
    assert read_bed(path, density=7.0).density.tolist() == [7.0, 7.0]
    assert read_bed(path, density={"set_3": 9.0, "": 8.0}).density.tolist() == [8.0, 9.0]
    assert unknowns(read_bed(path, density={"set_3": 9.0}), ALL)[0].startswith("density of set_0 is not")
    with pytest.raises(ReadError, match="--density: found the set 'ore', expected one of set_0, set_3"):
        read_bed(path, density={"ore": 9.0})
    known = write(mixed_bed(5), "csv", tmp_path)
    with pytest.raises(ReadError, match=r"the densities of all sets .* are known; say which set it is for"):
        read_bed(known, density=7.0)


def test_types_and_densities_make_the_sets_where_no_scene_does(tmp_path):
    rows = "1 1 1 2000 0 0 0\n2 1 1 3000 2 0 0\n3 4 1 3000 4 0 0\n4 1 1 2000 6 0 0\n"
    bed = read_bed(text_file(tmp_path, f"t\n\n4 atoms\n\nAtoms\n\n{rows}"))
    assert [each.name for each in bed.particle_sets] == ["type_1_2000", "type_1_3000", "type_4"]
    assert bed.set_index.tolist() == [0, 1, 2, 0]
    assert bed.density.tolist() == [2000, 3000, 3000, 2000]


def test_too_many_kinds_of_spheres_are_refused(tmp_path):
    rows = "".join(f"0 0 {2 * each} 1 {each}\n" for each in range(2000))
    with pytest.raises(ReadError, match=r"found 2,000 sets or types .* expected at most 1,000 kinds"):
        read_bed(text_file(tmp_path, rows))


@pytest.mark.parametrize("name", ["csv", "liggghts", "lammps", "yade", "vtk", "extxyz", "mfix"])
def test_a_bed_of_a_deck_and_its_scene_is_the_bed_again(tmp_path, scene, name):
    bed = mixed_bed(60)
    found = read_bed(write(bed, name, tmp_path), scene=scene)
    assert np.array_equal(found.set_index, bed.set_index)
    assert found.particle_sets == bed.particle_sets
    assert [each.friction for each in found.materials] == [0.25, 0.75]
    assert found.gravity.tolist() == [9.81, 0.0, 0.0]
    assert (found.wall_material, found.tolerance) == ("ore", 1e-3)
    assert found.container.bounds.tolist() == [[0, 0, 0], [3, 3, 3]]
    assert unknowns(found, ALL) == []
    assert found.provenance["scene"] == "scene.yaml"
    assert (
        found.provenance["read_from"] in {"bed.csv", "bed.data", "bed.txt", "bed.vtp", "bed.xyz"}
        or name == "mfix"
    )


def test_spheres_that_no_set_of_the_scene_is_are_refused(tmp_path, scene):
    with pytest.raises(ReadError, match="found spheres that may be a or b, expected what tells"):
        read_bed(text_file(tmp_path, "0 0 0 1\n"), scene=scene)
    with pytest.raises(ReadError, match=r"found spheres of set_2, expected one of the sets of .*: a, b"):
        read_bed(text_file(tmp_path, "0 0 0 1 2\n"), scene=scene)
    with pytest.raises(ReadError, match=r"found spheres of type_3, expected one of the sets"):
        read_bed(text_file(tmp_path, dump_text([(1, 3, 0.0, 0.0, 0.0, 1.0)])), scene=scene)


def test_sets_of_one_material_are_told_apart_by_their_densities(tmp_path):
    (tmp_path / "one.yaml").write_text(SCENE.replace("material: coke", "material: ore"))
    scene = load_scene(tmp_path / "one.yaml")
    rows = "1 1 1 3500 1 1 1\n2 1 1 2500 2 2 2\n"
    path = text_file(tmp_path, f"t\n\n2 atoms\n\nAtoms\n\n{rows}")
    assert read_bed(path, scene=scene).set_index.tolist() == [1, 0]
    dump = text_file(tmp_path, dump_text([(1, 1, 0.0, 0.0, 0.0, 1.0)]))
    with pytest.raises(
        ReadError, match="may be a or b, expected what tells them apart; add a column set or density"
    ):
        read_bed(dump, scene=scene)
    (tmp_path / "same.yaml").write_text(
        SCENE.replace("material: coke", "material: ore").replace("2500", "3500")
    )
    said = []
    assert read_bed(dump, scene=load_scene(tmp_path / "same.yaml"), warn=said.append).set_index.tolist() == [
        0
    ]
    assert "may be a or b, of equal density and material; they are taken for a" in said[0]


def test_another_density_than_the_scene_says_is_told(tmp_path, scene):
    path = text_file(tmp_path, "x,y,z,r,set,density\n1,1,1,1,0,2600\n")
    said = []
    assert read_bed(path, scene=scene, warn=said.append).density.tolist() == [2500]
    assert "2600 kg/m3: the scene scene.yaml gives a 2500 kg/m3, which is taken" in said[0]


def test_boxes_that_wrap_around_come_from_the_file(tmp_path):
    rows = [(1, 1, 0.1, 0.5, 0.5, 0.2), (2, 1, 1.9, 0.5, 0.5, 0.2)]
    for flags, walls in (("pp pp pp", True), ("pp ff ff", False)):
        bed = read_bed(text_file(tmp_path, dump_text(rows, flags=flags, box=((0, 2),) * 3)))
        assert check_bed(bed).overlap_max == pytest.approx(1.0)  # across the seam
        assert (unknowns(bed, ["walls"]) == []) is walls
    unwrapped = [(1, 1, -1.9, 0.5, 0.5, 0.2), (2, 1, 5.9, 0.5, 0.5, 0.2)]
    text = dump_text(unwrapped, "id type xu yu zu radius", flags="pp pp pp", box=((0, 2),) * 3)
    assert np.allclose(read_bed(text_file(tmp_path, text)).position[:, 0], [0.1, 1.9])


def test_a_container_that_is_given_counts(tmp_path):
    box = box_container((0, 0, 0), (1, 1, 1))
    bed = read_bed(text_file(tmp_path, "0.5 0.5 0.4 0.5\n"), box)
    assert bed.container is box
    assert check_bed(bed).wall_overlap_max == pytest.approx(0.2)


def test_a_bed_of_packgen_knows_its_scene_but_not_the_mesh_of_its_walls(tmp_path):
    (tmp_path / "tube.yaml").write_text(
        "container: {cylinder: {radius: 1, height: 2}}\n"
        "particle_sets: [{name: p, radius_distribution: constant, radius: 0.4, "
        "density: 900, material: wax}]\n"
        "materials: {wax: {friction: 0.3}}\ngravity: 1.62\nzones: [{n_particles: 3}]\n"
    )
    scene = load_scene(tmp_path / "tube.yaml")
    bed = pack(scene, load_container(scene)).bed
    save_bed(bed, tmp_path / "bed.npz")
    found = read_bed(tmp_path / "bed.npz")
    assert np.array_equal(found.position, bed.position)
    assert found.particle_sets == bed.particle_sets
    assert found.materials == bed.materials
    assert found.gravity.tolist() == bed.gravity.tolist()
    assert type(found.container.shape) is type(bed.container.shape)
    assert found.container.volume == bed.container.volume
    assert unknowns(found, ALL) == []
    settings = dict(bed.provenance["settings"])
    meshed = {**bed.provenance, "settings": settings | {"container": {"path": "tube.stl", "units": "m"}}}
    save_bed(replace(bed, provenance=meshed), tmp_path / "bed.npz")
    assert unknowns(read_bed(tmp_path / "bed.npz"), ALL) == [
        "walls are not in the file: give --scene, or --container"
    ]
    save_bed(replace(bed, provenance={"settings": {"particle_sets": 3}}), tmp_path / "bed.npz")
    assert np.isnan(read_bed(tmp_path / "bed.npz").density).all()


@pytest.mark.parametrize(
    ("name", "lacking"),
    [("liggghts", ALL), ("lammps", ALL), ("yade", ALL), ("csv", ALL[:1]), ("esys", ALL[2:]), ("extxyz", ())],
)
def test_exporters_refuse_a_bed_that_lacks_what_they_write(tmp_path, name, lacking):
    bed = read_bed(text_file(tmp_path, "0 0 0 1\n"))
    exporter = exporters.get(name)
    if not lacking:
        assert exporter.write(bed, tmp_path, exporter.Options())
        return
    with pytest.raises(ExportError) as caught:
        exporter.write(bed, tmp_path, exporter.Options())
    assert [word in str(caught.value) for word in ALL] == [word in lacking for word in ALL]


def test_walls_that_are_given_later_are_known(tmp_path):
    settings = {
        "particle_sets": [{"name": "p", "density": 900, "material": "wax"}], "materials": [{"name": "wax"}],
        "gravity_direction": [0, 0, -1], "gravity": 9.81, "wall_material": "wax", "params": {},
        "container": {"path": "tube.stl"},
    }  # fmt: skip
    bed = make_bed([[1, 1, 1]], 0.5, box_container((0, 0, 0), (2, 2, 2)), provenance={"settings": settings})
    save_bed(bed, tmp_path / "bed.npz")
    without = read_bed(tmp_path / "bed.npz")
    assert without.provenance["walls"] == "not known"
    save_bed(without, tmp_path / "again.npz")
    assert "walls" not in read_bed(tmp_path / "again.npz", bed.container).provenance


def test_sets_of_a_bed_of_packgen_are_found_by_their_names_in_a_scene_of_another_order(tmp_path):
    settings = {"settings": {"particle_sets": [{"name": "b"}, {"name": "a"}]}}
    bed = replace(mixed_bed(60), provenance=settings)
    save_bed(bed, tmp_path / "bed.npz")
    (tmp_path / "scene.yaml").write_text(SCENE)
    found = read_bed(tmp_path / "bed.npz", scene=load_scene(tmp_path / "scene.yaml"))
    assert np.array_equal(found.set_index, 1 - bed.set_index)
    assert [each.name for each in found.particle_sets] == ["a", "b"]
