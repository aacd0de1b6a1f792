from __future__ import annotations

import os
import shutil
import subprocess

import numpy as np
import pytest

from exporters import liggghts
from packgen.bed import Material, ParticleSet
from packgen.errors import ExportError
from tests.beds import box_container, make_bed
from tests.exporters.beds import RADIUS, lattice, read_data_file
from tests.scenes import constant, run_scene

needs_liggghts = pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")


def write(bed, folder, **options):
    liggghts.write(bed, folder, liggghts.Options(**options))
    return (folder / "in.bed").read_text(encoding="ascii")


def run(folder, *arguments):
    command = ["stdbuf", "-oL", "liggghts", "-in", "in.bed", "-log", "none", *arguments]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, errors="replace", timeout=60, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:]
    return done.stdout


def test_data_file_survives_a_round_trip_to_the_last_bit(tmp_path):
    rng = np.random.default_rng(5)
    position = rng.uniform(-1, 1, (9000, 3)) * np.array([1e-3, 1.0, 40.0])
    radius = rng.uniform(1e-5, 1e-3, 9000)
    sets = (ParticleSet("a", 2500.0, "ore"), ParticleSet("b", 1234.5678901234567, "coke"))
    set_index = rng.integers(0, 2, 9000)
    bed = make_bed(
        position, radius, box_container((0, 0, 0), (1, 1, 40)), set_index=set_index, particle_sets=sets,
        materials=(Material("ore"), Material("coke", friction=0.2)),
    )  # fmt: skip
    write(bed, tmp_path)
    header, rows = read_data_file(tmp_path / "bed.data")
    assert header["atoms"] == [9000]
    assert header["atom types"] == [2]
    assert np.array_equal(rows[:, 0], np.arange(9000) + 1)
    assert np.array_equal(rows[:, 1], set_index + 1)
    assert np.array_equal(rows[:, 2], 2 * radius)
    assert np.array_equal(rows[:, 3], np.array([2500.0, 1234.5678901234567])[set_index])
    assert np.array_equal(rows[:, 4:], position)
    for axis, name in enumerate("xyz"):
        low, high = header[f"{name}lo {name}hi"]
        assert low < position[:, axis].min()
        assert position[:, axis].max() < high


def test_an_empty_bed_is_refused(tmp_path):
    with pytest.raises(ExportError, match="no spheres"):
        write(make_bed(np.zeros((0, 3)), 1.0, box_container((0, 0, 0), (1, 1, 1))), tmp_path)


def test_materials_out_of_range_are_refused_all_at_once(tmp_path):
    wrong = Material("ore", restitution=0.05, poissons_ratio=0.6, friction=-1)
    with pytest.raises(ExportError) as caught:
        write(lattice(materials=(wrong,)), tmp_path)
    for part in ("ore.restitution: found 0.05", "ore.poissons_ratio: found 0.6", "ore.friction: found -1"):
        assert part in str(caught.value)


def test_text_of_the_scene_cannot_leave_the_comments(tmp_path):
    nasty = 'a\nquit &\n${x} "y" # ü.yaml'
    bed = lattice(
        materials=(Material(nasty),), wall_material=nasty, particle_sets=(ParticleSet("p", 2500.0, nasty),),
        provenance={"scene": nasty, "seed": nasty, "packgen": nasty},
    )  # fmt: skip
    text = write(bed, tmp_path)
    assert [line for line in text.splitlines() if "quit" in line and not line.startswith("#")] == []
    assert "${x}" not in text
    assert not any(line.endswith("&") for line in text.splitlines())


def test_unused_materials_get_no_type_and_unlike_ones_the_harmonic_mean(tmp_path):
    materials = (Material("spare"), Material("ore", friction=0.5), Material("steel", friction=0.25))
    text = write(lattice(materials=materials, wall_material="steel"), tmp_path)
    assert "coefficientFriction peratomtypepair 2 0.5 0.3333333333333333 0.3333333333333333 0.25" in text
    assert "primitive type 2 zplane" in text
    assert "spare" not in text


def test_users_template_is_taken_before_ours(tmp_path):
    (tmp_path / "mine" / "liggghts").mkdir(parents=True)
    (tmp_path / "mine" / "liggghts" / "in.bed.j2").write_text("# mine {{ sphere_count }}\n")
    assert write(lattice(), tmp_path, templates=tmp_path / "mine") == "# mine 80\n"
    (tmp_path / "mine" / "liggghts" / "in.bed.j2").write_text("\n{{ no_such_value }}\n")
    with pytest.raises(ExportError, match="no_such_value"):
        write(lattice(), tmp_path, templates=tmp_path / "mine")


@needs_liggghts
@pytest.mark.solver
@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"materials": (Material("ore", youngs_modulus=1e6),)},
        {"materials": (Material("ore", youngs_modulus=7e10, rolling_friction=0.1),)},
        {
            "materials": (Material("ore", youngs_modulus=1e6), Material("steel", 2e11)),
            "wall_material": "steel",
        },
        {"gravity": np.array([0.0, 9.81, 0.0])},
        {"gravity": np.zeros(3)},
    ],
    ids=["default", "soft", "hard", "soft_and_hard", "along_y", "weightless"],
)
@pytest.mark.parametrize("walls", ["auto", "mesh"])
def test_liggghts_runs_the_deck_unedited(tmp_path, changes, walls):
    write(lattice(overlap=1e-4, **changes), tmp_path, walls=walls, steps=20)
    output = run(tmp_path)
    assert "time-step" not in output
    assert "Not all nodes" not in output
    assert (tmp_path / "post" / "bed.restart").stat().st_size > 0
    assert (tmp_path / "post" / "bed_20.dump").exists()


@needs_liggghts
@pytest.mark.solver
@pytest.mark.parametrize("walls", ["auto", "mesh"])
def test_liggghts_runs_a_wide_range_of_sizes(tmp_path, walls):
    bed = lattice()
    radius = bed.radius.copy()
    radius[::2] /= 5
    write(make_bed(bed.position, radius, bed.container), tmp_path, walls=walls, steps=20)
    run(tmp_path)


@needs_liggghts
@pytest.mark.solver
def test_liggghts_runs_a_periodic_box_without_walls_on_the_wrapped_sides(tmp_path):
    bed = make_bed(
        np.array([[0.1, 0.5, 0.5], [1.9, 0.5, 0.5]]) * RADIUS * 4, RADIUS,
        box_container((0, 0, 0), np.array([2, 1, 1]) * RADIUS * 4, periodic=(True, True, False)),
    )  # fmt: skip
    text = write(bed, tmp_path, steps=20, dumps="vtk")
    assert "boundary p p f" in text
    assert "xplane" not in text
    run(tmp_path)
    assert list((tmp_path / "post").glob("bed_*.vtk"))


@needs_liggghts
@pytest.mark.solver
@pytest.mark.skipif(shutil.which("mpirun") is None, reason="mpirun is not installed")
@pytest.mark.parametrize("walls", ["auto", "mesh"])
def test_two_processes_make_the_same_bed_as_one(tmp_path, walls):
    rng = np.random.default_rng(6)
    loose = lattice((4, 4, 4))
    shaken = 1.1 * loose.position + rng.uniform(-0.05, 0.05, (64, 3)) * RADIUS
    bed = make_bed(shaken, RADIUS, box_container((0, 0, 0), [8.8 * RADIUS] * 3))
    ends = {}
    for count in (1, 2):
        folder = tmp_path / str(count)
        folder.mkdir()
        write(bed, folder, walls=walls)
        (folder / "in.test").write_text(
            "include in.bed\ndump end all custom 2000 end_*.dump id x y z\n"
            'dump_modify end format "%d %.17g %.17g %.17g"\nrun 2000\n'
        )
        parallel = ["mpirun", "--oversubscribe", "-np", "2"] if count == 2 else []
        command = [*parallel, "liggghts", "-in", "in.test", "-log", "none", "-var", "setup_only", "1"]
        root = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
        done = subprocess.run(
            command, cwd=folder, env={**os.environ, **root}, capture_output=True, text=True, timeout=60,
            errors="replace", check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
        assert f"{count} by 1 by 1 MPI processor grid" in done.stdout or count == 2
        assert "64 atoms" in done.stdout
        rows = np.loadtxt(folder / "end_2000.dump", skiprows=9)
        ends[count] = rows[np.argsort(rows[:, 0]), 1:]
    assert np.abs(ends[1] - bed.position).max() > 0.01 * RADIUS  # spheres have met and moved
    assert np.abs(ends[1] - ends[2]).max() < 1e-9 * RADIUS


@pytest.mark.solver
@needs_liggghts
def test_a_sphere_near_5120_facets_at_once_runs(tmp_path):
    bed = run_scene(
        tmp_path, {"sphere": {"radius": 0.0258}}, constant(0.0254), zones=[{"n_particles": 1}]
    ).bed
    text = write(bed, tmp_path)
    assert "neigh_modify delay 0 one 5120" in text
    run(tmp_path)
