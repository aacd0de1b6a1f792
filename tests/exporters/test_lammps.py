from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

from exporters import lammps, liggghts
from exporters.walls import lammps_regions as lammps_walls
from packgen.bed import Material
from packgen.errors import ExportError
from packgen.geometry import Cone, Polyhedron
from tests.beds import box_container, make_bed, make_container
from tests.exporters.beds import RADIUS, lattice, open_at_the_top
from tests.validation.beds import bed_in, drum_surface, mixed, planes

needs_lammps = pytest.mark.skipif(shutil.which("lmp") is None, reason="lammps (lmp) is not installed")


def write(bed, folder, **options):
    lammps.write(bed, folder, lammps.Options(**options))
    return (folder / "in.bed").read_text(encoding="ascii")


def test_the_data_file_is_that_of_liggghts(tmp_path):
    (tmp_path / "other").mkdir()
    write(lattice(), tmp_path)
    liggghts.write(lattice(), tmp_path / "other", liggghts.Options())
    assert (tmp_path / "bed.data").read_bytes() == (tmp_path / "other" / "bed.data").read_bytes()


def test_a_container_that_is_not_convex_is_refused_with_the_alternative(tmp_path):
    with pytest.raises(ExportError, match=r"not convex.*export it for liggghts or yade.*convex_hull"):
        write(bed_in("mesh"), tmp_path)


def test_what_has_no_exact_region_is_refused_with_the_alternative(tmp_path):
    surface = drum_surface()
    tilted = Cone(np.zeros(3), np.array([0.0, 0.6, 0.8]), 4.0, 4.0, 4.0)
    flat = Cone(np.zeros(3), np.array([0.0, 0.0, 1.0]), 1.0, 0.0, 4.0)
    for shape, words in ((tilted, "stand along x, y or z"), (flat, "76 degrees from its axis")):
        with pytest.raises(ExportError, match=words):
            write(make_bed([[0, 0, 2]], 1.0, make_container(shape, surface, 1.0)), tmp_path)


def test_planes_that_are_the_same_but_for_rounding_are_one_wall():
    surface = drum_surface()
    normal, offset = planes(surface)
    # Two facets a side and 64 an end, their numbers as single precision leaves them.
    shape = Polyhedron(normal.astype(np.float32), offset * (1 + 3e-8), surface)
    assert len(lammps_walls.convex_planes(shape)[1]) == 64 + 2


def test_an_open_top_has_no_plane_and_room_above(tmp_path):
    bed = bed_in("hopper")
    text = write(make_bed(bed.position, bed.radius, open_at_the_top(bed.container)), tmp_path)
    assert text.count(" plane ") == 24 + 1
    assert "region wall intersect 25 " in text
    assert "0.0 0.0 -1.0 side in" not in text


def test_a_cone_upside_down_keeps_its_ends():
    cone = Cone(np.array([1.0, 2.0, 3.0]), np.array([0.0, -1.0, 0.0]), 4.0, 0.5, 2.0)
    regions, _ = lammps_walls.wall_regions(make_container(cone, drum_surface(), 1.0))
    assert regions == ("region wall cone y 1.0 3.0 2.0 0.5 -2.0 2.0 side in",)


@needs_lammps
@pytest.mark.solver
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"materials": (Material("ore", youngs_modulus=7e10, rolling_friction=0.1, restitution=1.0),)},
        {
            "materials": (Material("ore", youngs_modulus=1e6), Material("steel", 2e11)),
            "wall_material": "steel",
        },
        {"gravity": np.zeros(3)},
    ],
    ids=["default", "hard_and_rolling", "soft_and_hard", "weightless"],
)
def test_lammps_runs_the_deck_unedited(tmp_path, changes):
    write(lattice(overlap=1e-4, **changes), tmp_path, steps=20)
    run(tmp_path)
    assert (tmp_path / "post" / "bed.restart").stat().st_size > 0
    assert (tmp_path / "post" / "bed_20.dump").exists()


@needs_lammps
@pytest.mark.solver
def test_lammps_runs_unlike_sizes_and_types_in_planes(tmp_path):
    bed = bed_in("hopper")
    small = np.array([[0.05, 0.0, 0.07], [0.1, 0.0, 0.2]])
    bed = mixed(np.concatenate((bed.position, small)), [*bed.radius, 0.06, 0.05], bed.container)
    text = write(bed, tmp_path, steps=20)
    assert "collection/interval" in text
    assert text.count("wall/gran/region") == 3
    run(tmp_path)


@needs_lammps
@pytest.mark.solver
@pytest.mark.parametrize("periodic", [(True, True, False), (True, True, True)])
def test_lammps_runs_a_periodic_box(tmp_path, periodic):
    bed = make_bed(
        np.array([[0.1, 0.5, 0.5], [1.9, 0.5, 0.5]]) * RADIUS * 4, RADIUS,
        box_container((0, 0, 0), np.array([2, 1, 1]) * RADIUS * 4, periodic=periodic),
    )  # fmt: skip
    text = write(bed, tmp_path, steps=20)
    assert ("region wall block INF INF INF INF 0.0" in text) is not all(periodic)
    run(tmp_path)


def run(folder):
    done = subprocess.run(
        ["lmp", "-in", "in.bed", "-log", "none"], cwd=folder, capture_output=True, text=True, timeout=60,
        check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:]
    assert "WARNING" not in done.stdout, done.stdout


@pytest.mark.parametrize("restitution", [0.12, 0.3, 0.6, 0.95, 1.0])
def test_the_damping_is_that_of_the_restitution(restitution):
    given = lammps.tsuji_argument(restitution)
    alpha = (
        1.2728 - 4.2783 * given + 11.087 * given**2 - 22.348 * given**3 + 27.467 * given**4
        - 18.022 * given**5 + 4.8218 * given**6
    )  # fmt: skip
    logarithm = np.log(restitution)
    assert alpha == pytest.approx(-np.sqrt(5) * logarithm / np.hypot(logarithm, np.pi), abs=1e-9)
