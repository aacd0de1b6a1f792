from __future__ import annotations

import ast
import re
import shutil
import subprocess

import numpy as np
import pytest

from exporters import yade
from packgen.bed import Material, ParticleSet
from packgen.errors import ExportError
from packgen.geometry import Mesh, Surface
from tests.beds import box_container, box_surface, make_bed, make_container, revolved_surface
from tests.exporters.beds import RADIUS, lattice
from tests.validation.beds import bed_in

needs_yade = pytest.mark.skipif(shutil.which("yade") is None, reason="yade is not installed")


def write(bed, folder, **options):
    yade.write(bed, folder, yade.Options(**options))
    return (folder / "bed.py").read_text(encoding="ascii")


def test_spheres_survive_a_round_trip_to_the_last_bit(tmp_path):
    rng = np.random.default_rng(7)
    bed = make_bed(
        rng.uniform(-1, 1, (9000, 3)) * np.array([1e-3, 1.0, 40.0]), rng.uniform(1e-5, 1e-3, 9000),
        box_container((-1, -1, -40), (1, 1, 40)),
    )  # fmt: skip
    write(bed, tmp_path)
    rows = np.loadtxt(tmp_path / "bed.txt")
    assert np.array_equal(rows[:, :3], bed.position)
    assert np.array_equal(rows[:, 3], bed.radius)
    assert (tmp_path / "bed.txt").read_text().startswith("#format x_y_z_r_matId\n")  # as ymport.text reads it


def test_the_deck_needs_nothing_but_numpy_and_yade(tmp_path):
    tree = ast.parse(write(lattice(), tmp_path))
    names = {each.name for node in ast.walk(tree) if isinstance(node, ast.Import) for each in node.names}
    names |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert names == {"os", "sys", "numpy", "yade"}


def test_text_of_the_scene_cannot_leave_the_comments(tmp_path):
    nasty = 'a\nimport nothing\n"""'
    materials = (Material(nasty),)
    bed = lattice(provenance={"scene": nasty, "seed": nasty, "packgen": nasty}, materials=materials,
                  wall_material=nasty, particle_sets=(ParticleSet(nasty, 1.0, nasty),))  # fmt: skip
    text = write(bed, tmp_path)
    ast.parse(text)
    assert not re.search(r"^import nothing", text, re.MULTILINE)


def test_a_box_that_wraps_around_on_some_sides_only_is_refused(tmp_path):
    bed = make_bed([[1, 1, 1]], 0.5, box_container((0, 0, 0), (2, 2, 2), periodic=(True, False, False)))
    with pytest.raises(ExportError, match="along all or none; export it for liggghts or lammps"):
        write(bed, tmp_path)
    bed = make_bed([[1, 1, 1]], 0.5, box_container((0, 0, 0), (2, 2, 2), periodic=(True, True, True)))
    with pytest.raises(ExportError, match=r"want more than 2\.4 m"):
        write(bed, tmp_path)


def test_flat_closed_walls_are_planes_and_an_open_rim_is_none():
    box = box_surface((0, 1, 2), (3, 4, 5))
    corners = box.vertices[box.faces]
    assert yade.flat_walls(corners) == [(0, 0.0), (0, 3.0), (1, 1.0), (1, 4.0), (2, 2.0), (2, 5.0)]
    lid = (corners[:, :, 2] == 5).all(axis=1)
    assert (2, 5.0) not in yade.flat_walls(corners[~lid])
    rim = Surface(np.array([[0, 1, 5], [3, 1, 5], [1.5, 1.5, 5]]), np.array([[0, 1, 2]]))
    with_rim = np.concatenate((corners[~lid], rim.vertices[rim.faces]))
    assert (2, 5.0) not in yade.flat_walls(with_rim)
    assert (2, 2.0) in yade.flat_walls(with_rim)


@needs_yade
@pytest.mark.solver
def test_yade_runs_the_deck_unedited_and_ends_with_its_spheres(tmp_path):
    materials = (Material("ore", 1e8, 0.25, 1.0, 0.4), Material("steel", 2e11, friction=0.0))
    write(lattice(overlap=1e-4, materials=materials, wall_material="steel"), tmp_path)
    done = subprocess.run(
        ["yade", "-n", "-x", "-j1", "bed.py", "20"], cwd=tmp_path, capture_output=True, text=True, timeout=60,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    assert "ran 20 steps" in done.stdout
    rows = np.loadtxt(tmp_path / "post" / "bed_end.txt")
    assert np.abs(rows[:, :3] - lattice(overlap=1e-4).position).max() < 0.01 * RADIUS
    assert (tmp_path / "post" / "bed.yade.gz").stat().st_size > 0


def test_facets_are_written_once_and_only_where_no_plane_is(tmp_path):
    box = box_surface((0, 0, 0), (3, 3, 3))
    roof = np.array([[0, 0, 3], [3, 0, 3], [3, 3, 3], [0, 3, 3], [1.5, 1.5, 4.5]])
    faces = box.faces[~(box.vertices[box.faces][:, :, 2] == 3).all(axis=1)]
    sides = np.array([[4, 5, 8], [5, 6, 8], [6, 7, 8], [7, 4, 8]])
    doubled = Surface(np.concatenate((box.vertices, roof[4:])), np.concatenate((faces, sides, sides[:2])))
    bed = make_bed([[1.5, 1.5, 1.0]], 0.9, make_container(Mesh(doubled), doubled, 1.0))
    text = write(bed, tmp_path)
    assert "[(0, 0.0), (0, 3.0), (1, 0.0), (1, 3.0), (2, 0.0)]" in text
    rows = [line.split()[1:] for line in (tmp_path / "wall.stl").read_text().splitlines() if "vertex" in line]
    facets = np.array(rows, dtype=float).reshape(-1, 3, 3)
    assert len(facets) == 4
    assert {tuple(each) for each in facets[:, :, :].reshape(-1, 3).tolist()} == {
        tuple(r) for r in roof.tolist()
    }


def test_the_time_step_is_shorter_where_a_sphere_touches_many_facets_at_once(tmp_path):
    of = {}
    for name in ("box", "mesh"):
        (tmp_path / name).mkdir()
        of[name] = write(bed_in(name), tmp_path / name)
        assert "# 0.1 of the smallest Rayleigh time" in of[name]
    assert not (tmp_path / "box" / "wall.stl").exists()
    assert "# 0.2 of the smallest" in write(bed_in("mesh"), tmp_path, timestep_fraction=0.2)
    surface = revolved_surface([(0, 0.02), (1.8, 0.812)], 96)
    slope = 0.44 * np.cos(np.pi / 96)
    # Its distance from all the sides of the cone is its radius.
    distance = (0.02 * np.cos(np.pi / 96) + slope * 0.05) / np.hypot(1, slope)
    cone = make_container(Mesh(surface), surface, 1.0)
    bed = make_bed([[0, 0, 0.05], [0, 0, 0.5]], [distance, 0.1], cone)
    triangles = surface.vertices[surface.faces]
    assert yade.facets_at_once(bed, triangles) == 2 * 96
    assert "# 0.013 of the smallest" in write(bed, tmp_path)


@needs_yade
@pytest.mark.solver
def test_yade_wraps_a_periodic_box_around(tmp_path):
    bed = make_bed(
        np.array([[0.05, 0.5, 0.5], [1.75, 0.5, 0.5]]) * RADIUS * 6, RADIUS,
        box_container((0, 0, 0), np.array([2, 1, 1]) * RADIUS * 6, periodic=(True, True, True)),
    )  # fmt: skip
    from packgen.validation import Limits, validate

    write(bed, tmp_path)
    assert not (tmp_path / "wall.stl").exists()
    zero = validate(bed, tmp_path, solver="yade", limits=Limits(free_fall_times=0.01)).step_zero
    assert zero.pair_count == 1  # across the seam
    assert zero.law_error < 1e-9
