"""What formats refuse before a run, and how a plug-in does."""

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path
from types import SimpleNamespace

import meshio
import numpy as np
import pytest

import exporters
from exporters import Outlook
from packgen.bed import Material, ParticleSet
from packgen.cli import main
from packgen.errors import ExportError
from packgen.geometry import Cone, Mesh, Surface
from tests.beds import box_container, box_surface, make_bed, make_container, revolved_surface

DECKS = ("liggghts", "lammps", "yade", "cfdem", "bpm")
CELLS_ONLY = ("cif",)  # formats of what repeats all round


def outlook(container=None, **changes):
    known = {
        "container": box_container((0, 0, 0), (1, 1, 1)) if container is None else container,
        "gravity": np.array([0.0, 0.0, -9.81]),
        "particle_sets": (ParticleSet("pellets", 2500.0, "ore"),),
        "materials": (Material("ore"),),
        "radius_min": 0.05,
        "radius_max": 0.05,
        "place": lambda location: f"a.yaml:1:1({'.'.join(map(str, location))})",
    }
    return Outlook(**{**known, **changes})


def refused(name, seen, **options):
    exporter = exporters.get(name)
    with pytest.raises(ExportError) as caught:
        exporter.check_outlook(seen, exporter.Options(**options))
    return str(caught.value)


def cone(axis, bottom=0.4, top=0.4):
    shape = Cone(np.zeros(3), np.asarray(axis, float), 0.5, bottom, top)
    return make_container(shape, revolved_surface([(0, 0.4), (1, 0.4)], 24), 0.5)


@pytest.mark.parametrize("name", exporters.BUILTIN)
def test_every_format_takes_a_usual_scene(name):
    exporter = exporters.get(name)
    container = box_container((0, 0, 0), (1, 1, 1), periodic=(name in CELLS_ONLY,) * 3)
    exporter.check_outlook(outlook(container), exporter.Options())


def test_the_formats_with_materials_are_decks_and_no_other():
    assert {name for name in exporters.BUILTIN if exporters.get(name).IS_DECK} == set(DECKS)


@pytest.mark.parametrize("name", DECKS)
def test_materials_are_refused_at_their_place_a_line_each(name):
    wrong = Material("ore", restitution=1.5, friction=-1.0)
    first, second = refused(name, outlook(materials=(wrong,))).splitlines()
    assert "a.yaml:1:1(materials.ore.restitution): " in first
    assert "materials.ore.restitution: found 1.5" in first
    assert "a.yaml:1:1(materials.ore.friction): " in second


def test_yade_refuses_boxes_that_wrap_around_partly_or_too_soon():
    partly = box_container((0, 0, 0), (1, 1, 1), (True, True, False))
    line = refused("yade", outlook(partly))
    assert line.startswith("a.yaml:1:1(container.periodic): yade: the box wraps around along some axes only")
    small = box_container((0, 0, 0), (1, 1, 1), (True, True, True))
    line = refused("yade", outlook(small, radius_min=0.21, radius_max=0.21))
    assert "want more than 1.008 m; enlarge the box" in line


def test_what_depends_on_the_spheres_is_left_to_the_bed():
    small = box_container((0, 0, 0), (1, 1, 1), (True, True, True))
    yade = exporters.get("yade")
    yade.check_outlook(outlook(small, radius_min=0.1, radius_max=0.24), yade.Options())


@pytest.mark.parametrize(
    ("container", "why"),
    [
        (cone([0.6, 0.0, 0.8]), "has to stand along x, y or z"),
        (cone([0.0, 0.0, 1.0], 0.0, 2.0), "expected less than 60"),
        (
            make_container(Mesh(box_surface((0, 0, 0), (1, 1, 1))), box_surface((0, 0, 0), (1, 1, 1)), 1.0),
            "the container is not convex",
        ),
    ],
)
def test_lammps_refuses_walls_that_it_has_no_region_for(container, why):
    assert refused("lammps", outlook(container)).startswith("a.yaml:1:1(container): lammps: ")
    assert why in refused("lammps", outlook(container))


def test_liggghts_refuses_a_mesh_in_which_too_many_facets_meet():
    corners = np.array([[0, 0, 0], [0, 0, 1], *[[np.cos(a), np.sin(a), 0.5] for a in np.arange(9.0)]])
    fan = replace(
        box_surface((0, 0, 0), (1, 1, 1)),
        vertices=corners,
        faces=np.array([[0, 1, index] for index in range(2, 11)]),
    )
    container = make_container(Mesh(fan), fan, 1.0)
    line = refused("liggghts", outlook(container))
    assert line.startswith("a.yaml:1:1(container): walls: 9 facets share their edges")


def test_cfdem_refuses_a_mesh_that_is_not_in_metres():
    surface = box_surface((0, 0, 0), (1e-4, 1e-4, 1e-4))
    container = make_container(Mesh(surface), surface, 1e-12)
    line = refused("cfdem", outlook(container, radius_min=1e-6, radius_max=1e-6))
    assert line.startswith("a.yaml:1:1(container): cfdem: found a container of 0.0001 m")


def test_a_folder_of_templates_that_is_none_is_refused(tmp_path):
    for name in (*DECKS, "openmc"):
        assert "is not a folder" in refused(name, outlook(), templates=tmp_path / "none")


def test_fraction_refuses_too_fine_a_grid_and_meshes_that_are_none_or_elsewhere(tmp_path):
    assert "fraction: a grid of 1e+09 cells" in refused("fraction", outlook(), cell_size=1e-3)
    strange = tmp_path / "mesh.unknown"
    strange.write_text("")
    assert "mesh.unknown cannot be read" in refused("fraction", outlook(), mesh=strange)
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    far = tmp_path / "far.vtk"
    meshio.Mesh(corners + np.array([5, 0, 0]), [("tetra", np.array([[0, 1, 2, 3]]))]).write(far)
    assert "is fraction.scale right?" in refused("fraction", outlook(), mesh=far)


def test_a_bed_passes_the_write_that_its_scene_has_passed_before(tmp_path):
    for name in exporters.BUILTIN:
        container = box_container((0, 0, 0), (1, 1, 1), periodic=(name in CELLS_ONLY,) * 3)
        bed = make_bed([[0.5, 0.5, 0.5]], 0.05, container)
        exporter = exporters.get(name)
        exporter.check_outlook(outlook(container), exporter.Options())
        (tmp_path / name).mkdir()
        assert exporter.write(bed, tmp_path / name, exporter.Options())


# Plug-ins.

SCENE = """\
container: {box: {min: [0, 0, 0], max: [1, 1, 1]}, periodic: [x]}
materials: {ore: {restitution: 0.01}, unused: {restitution: 0.02}}
particle_sets: [{radius_distribution: constant, radius: 0.1, material: ore}]
zones: [{n_particles: 3}]
"""


def plain(**more):
    def write(bed, folder, _options):
        (folder / "count").write_text(str(bed.count))
        return [folder / "count"]

    return SimpleNamespace(NAME="plain", Options=dict, write=write, **more)


@pytest.fixture
def plug_in(monkeypatch, tmp_path):
    """Return what makes an object the exporter ``plain``, and gives the code of a run that writes it."""
    monkeypatch.chdir(tmp_path)
    Path("seam.yaml").write_text(SCENE)

    def run(exporter, *arguments):
        point = SimpleNamespace(name="plain", value="plain", load=lambda: exporter)
        monkeypatch.setattr(exporters, "entry_points", lambda group: [point])
        return main(["seam.yaml", "--quiet", "--no-report", *arguments])

    return run


def test_a_plug_in_without_an_early_check_works(plug_in):
    assert plug_in(plain(), "--export", "plain") == 0
    assert Path("seam/plain/count").read_text() == "3"
    assert exporters.get("plain").IS_DECK is False


def refuse(seen, _options):
    with seen.placed("container", "periodic"):
        if any(seen.container.periodic):
            raise ExportError("plain: the box wraps around")


def test_early_checks_of_plug_ins_and_formats_refuse_all_at_once_before_the_run(plug_in, capsys):
    plugin = plain(check_outlook=refuse)
    assert plug_in(plugin, "--export", "plain,liggghts,yade") == 2
    lines = [line.removeprefix("packgen: ") for line in capsys.readouterr().err.splitlines()]
    assert [line.split(": ", 1)[1][:30] for line in lines] == [
        "plain: the box wraps around",
        "liggghts: materials.ore.restit",
        "yade: the box wraps around alo",
    ]
    assert lines[0].startswith("seam.yaml:1:")
    assert lines[1].startswith("seam.yaml:2:32: ")
    assert not Path("seam").exists()


def test_an_early_check_that_breaks_is_the_plug_ins_fault(plug_in, capsys):
    def check_outlook(_seen, _options):
        raise KeyError("periodic")

    assert plug_in(plain(check_outlook=check_outlook), "--export", "plain") == 2
    assert "plain: its check before the run failed, KeyError" in capsys.readouterr().err


def test_a_plug_in_that_is_a_module_is_completed(monkeypatch):
    monkeypatch.setattr(
        exporters, "entry_points", lambda group: [EntryPoint("other", "exporters.csv", group)]
    )
    other = exporters.get("other")
    other.check_outlook(outlook(), other.Options())


@pytest.mark.parametrize(("name", "options"), [("bonds", {}), ("bpm", {}), ("esys", {"gap": 0.0})])
def test_boxes_too_narrow_for_bonds_are_refused_before_the_run(name, options):
    box = box_container((0, 0, 0), (0.2, 1, 1), (True, False, False))
    least = "0.2" if name == "esys" else "0.201"
    assert refused(name, outlook(box), **options) == (
        f"a.yaml:1:1(container): {name}: the bed wraps around along x after 0.2 m, expected over {least} m, "
        "two of the longest bonds; repeat the bed first, by packgen repeat"
    )
    exporters.get("esys").check_outlook(outlook(box), exporters.get("esys").Options())


def test_lengths_of_what_is_no_tube_and_open_walls_are_refused_before_the_run():
    line = refused("surface", outlook(cone([0.0, 0.0, 1.0], 0.4, 0.2)), inlet_length=0.1)
    assert line.startswith("a.yaml:1:1(container): surface: inlet_length and outlet_length are of a cylinder")
    upright = box_container((0, 0, 0), (1, 1, 1), (False, False, True))
    assert "vessel is meshed as it is" in refused("surface", outlook(upright), outlet_length=0.1)
    assert "wraps around along z; choose another" in refused("surface", outlook(upright), axis="z")
    cup = box_surface((0, 0, 0), (1, 1, 1))
    cup = Surface(cup.vertices, cup.faces[2:])
    assert "have 4 open edges, expected a closed" in refused(
        "surface", outlook(make_container(Mesh(cup), cup, 1.0))
    )
    narrow = box_container((0, 0, 0), (0.2, 1, 1), (True, False, False))
    assert "two of the longest bonds" in refused("surface", outlook(narrow))


def test_voxels_that_are_too_many_are_refused_before_the_run():
    assert "voxels.size to " in refused("voxels", outlook(), size=1e-4)
