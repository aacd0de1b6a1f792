"""Decks of rigid clumps: true mass, centre and inertia, whatever the spheres overlap."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import exporters
from exporters.shared.clumps import WAYS
from packgen.bed import Material
from packgen.bodies import SINGLE, Template
from packgen.errors import ExportError
from packgen.reading import read_bed
from tests.beds import box_container
from tests.clump_beds import bed_of, bodies_at, lattice_of_clumps, pair

DENSITY = 2500.0


def write(name, bed, folder, **options):
    exporter = exporters.get(name)
    return {path.name: path for path in exporter.write(bed, folder, exporter.Options(**options))}


def rows_of(path, title):
    lines = path.read_text(encoding="ascii").split(f"\n{title}\n\n")[1].splitlines()
    return np.array([[float(word) for word in line.split()] for line in lines])


@pytest.mark.parametrize("name", ["liggghts", "lammps"])
@pytest.mark.parametrize("periodic", [(False, False, False), (True, True, False)], ids=["box", "seam"])
def test_spheres_of_a_body_add_up_to_its_mass_and_centre(tmp_path, name, periodic):
    bed = lattice_of_clumps(singles=True, periodic=periodic)
    files = write(name, bed, tmp_path)
    rows = rows_of(files["bed.data"], "Atoms # hybrid")
    place, diameter, density, molecule = rows[:, 2:5], rows[:, 5], rows[:, 6], rows[:, 7]
    mass = density * np.pi / 6.0 * diameter**3
    length = bed.container.bounds[1] - bed.container.bounds[0]
    low, high = bed.container.bounds
    for axis in np.flatnonzero(periodic):
        assert (place[:, axis] >= low[axis]).all()
        assert (place[:, axis] < high[axis]).all()
    place = place + rows[:, 8:] * length
    infile = np.loadtxt(files["clumps.infile"], skiprows=1)
    assert infile.shape[1] == (11 if name == "liggghts" else 20)
    assert (bed.bodies.template_index[molecule.astype(int) - 1] != SINGLE)[molecule > 0].all()
    assert (bed.bodies.template_index[bed.body_index[molecule == 0]] == SINGLE).all()
    for row in infile:
        own, body = molecule == row[0], int(row[0]) - 1
        assert row[1] == pytest.approx(DENSITY * bed.bodies.volume[body], rel=1e-12)
        assert mass[own].sum() == pytest.approx(row[1], rel=1e-12)
        assert np.abs(mass[own] @ place[own] / row[1] - row[2:5]).max() < 1e-14
        xx, yy, zz, xy, xz, yz = row[5:11] / DENSITY
        assert (
            np.abs(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) - bed.bodies.inertia[body]).max()
            < 1e-20
        )


@pytest.mark.parametrize("name", ["liggghts", "lammps"])
def test_a_deck_without_clumps_says_nothing_of_them(tmp_path, name):
    alone = bed_of(bodies_at([[0.02] * 3], [SINGLE]), box_container([0, 0, 0], [0.04] * 3))
    files = write(name, alone, tmp_path)
    assert "clump" not in files["in.bed"].read_text(encoding="ascii")
    assert "clumps.infile" not in files


def test_a_small_mesh_container_scales_clumps_as_it_does_spheres(tmp_path):
    bed = lattice_of_clumps((1, 1, 1), spacing=0.026)
    small = bed_of(bed.bodies.scaled(1e-2), box_container([0, 0, 0], [2.6e-4] * 3))
    files = write("liggghts", small, tmp_path, walls="mesh")
    infile = np.loadtxt(files["clumps.infile"], skiprows=1, ndmin=2)
    assert infile[0, 2:5].tolist() == pytest.approx((small.bodies.position[0] / 1e-6).tolist())
    assert infile[0, 1] == pytest.approx(DENSITY * small.bodies.volume[0] * 1e18)


@pytest.mark.parametrize("name", ["liggghts", "lammps", "csv", "vtk"])
def test_what_is_written_is_read_back_with_its_bodies(tmp_path, name):
    bed = lattice_of_clumps(singles=True)
    files = write(name, bed, tmp_path)
    found = read_bed(next(path for file, path in files.items() if file in ("bed.data", "bed.csv", "bed.vtp")))
    assert found.count == bed.count
    together = found.body_index[:, None] == found.body_index[None, :]
    assert (together == (bed.body_index[:, None] == bed.body_index[None, :])).all()
    assert np.abs(found.position - bed.position).max() < 1e-15


TAKING = {"liggghts", "lammps", "yade", "vtk", "csv", "chrono"}


def test_messages_name_the_formats_that_say_that_they_have_clumps():
    assert {name for name in exporters.BUILTIN if exporters.get(name).CLUMPS} == TAKING
    assert set(re.findall(r"\w+", WAYS)) - {"and", "do"} == TAKING


@pytest.mark.parametrize("name", sorted(set(exporters.BUILTIN) - TAKING))
def test_formats_without_clumps_refuse_them_by_name(tmp_path, name):
    exporter = exporters.get(name)
    try:
        options = exporter.Options()
    except ValueError:
        options = None
    bed = lattice_of_clumps(materials=(Material("ore"),))
    with pytest.raises(ExportError, match=rf"^{name}: the bed has clumps, .*liggghts, lammps, yade"):
        exporter.write(bed, tmp_path, options)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["liggghts", "lammps", "yade"])
def test_a_template_that_no_masses_balance_is_refused_by_name(tmp_path, name):
    away = Template(
        "away", pair().spheres + np.array([0.02, 0, 0, 0]), pair().volume, pair().inertia, np.zeros(3)
    )
    bed = bed_of(bodies_at([[0.05] * 3], [0], (away,)), box_container([0, 0, 0], [0.1] * 3))
    with pytest.raises(ExportError, match=f"^{name}: template away: .*more spheres"):
        write(name, bed, tmp_path)


def test_chrono_gets_clumps_of_one_type_a_size_in_the_frame_of_their_principal_axes(tmp_path):
    bed = lattice_of_clumps(singles=True)
    write("chrono", bed, tmp_path)
    types = {
        line.split(",")[0]: line.split(",")[1:]
        for line in (tmp_path / "clump_types.csv").read_text().splitlines()[1:]
    }
    lines = (tmp_path / "bed.csv").read_text().splitlines()
    assert lines[0] == "X,Y,Z,Qw,Qx,Qy,Qz,clump_type"
    assert len(lines) == 1 + len(bed.bodies)
    for body, line in enumerate(lines[1:]):
        *numbers, kind = line.split(",")
        place, turn = np.array(numbers[:3], float), np.array(numbers[3:], float)
        spheres = np.loadtxt(tmp_path / "clumps" / f"{kind}.csv", delimiter=",", skiprows=1, ndmin=2)
        rotation = Rotation.from_quat(np.roll(turn, -1).copy()).as_matrix()
        own = bed.body_index == body
        assert np.abs(place + spheres[:, :3] @ rotation.T - bed.position[own]).max() < 1e-14
        assert spheres[:, 3].tolist() == pytest.approx(bed.radius[own].tolist())
        mass, *moments = (float(each) for each in types[kind])
        assert mass == pytest.approx(DENSITY * bed.bodies.volume[body])
        inertia = rotation @ np.diag(moments) @ rotation.T
        assert np.abs(inertia - DENSITY * bed.bodies.inertia[body]).max() < 1e-12 * max(moments)


def test_chrono_refuses_more_sizes_than_it_can_have_types(tmp_path, monkeypatch):
    monkeypatch.setattr(exporters.chrono, "TYPES_MAX", 1)
    with pytest.raises(ExportError, match=r"^chrono: found clumps of 2 sizes, expected at most 1"):
        write("chrono", lattice_of_clumps(), tmp_path)


def test_csv_has_a_line_a_body_with_its_true_mass(tmp_path):
    bed = lattice_of_clumps(singles=True)
    write("csv", bed, tmp_path)
    head, *lines = (tmp_path / "bodies.csv").read_text().splitlines()
    rows = [dict(zip(head.split(","), line.split(","), strict=True)) for line in lines]
    assert [row["template"] for row in rows[:3]] == ["pair", "bent", "sphere"]
    assert [int(row["spheres"]) for row in rows[:3]] == [2, 4, 1]
    assert sum(float(row["mass"]) for row in rows) == pytest.approx(DENSITY * bed.bodies.volume.sum())
    turn = np.array([[float(row[f"q{axis}"]) for axis in "wxyz"] for row in rows])
    assert (turn == bed.bodies.orientation).all()


def test_vtk_has_a_point_a_body_with_its_axes(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    bed = lattice_of_clumps(singles=True)
    write("vtk", bed, tmp_path)
    assert (pyvista.read(tmp_path / "bed.vtp")["body"] == bed.body_index).all()
    bodies = pyvista.read(tmp_path / "bodies.vtp")
    assert (bodies.points == bed.bodies.position).all()
    turn = Rotation.from_quat(np.roll(bed.bodies.orientation, -1, axis=1)).as_matrix()
    assert np.abs(bodies["axis_x"] - turn[:, :, 0]).max() < 1e-15
    assert bodies["mass"].tolist() == pytest.approx((DENSITY * bed.bodies.volume).tolist())


@pytest.mark.parametrize("periodic", [(False,) * 3, (True,) * 3], ids=["box", "seam"])
def test_yade_gets_the_members_of_a_body_in_consecutive_lines_and_its_true_mass_and_axes(tmp_path, periodic):
    bed = lattice_of_clumps(singles=True, periodic=periodic)
    files = write("yade", bed, tmp_path)
    rows, clumps = np.loadtxt(files["bed.txt"]), np.loadtxt(files["clumps.txt"])
    assert files["bed.txt"].read_text().startswith("#format x_y_z_r_clumpId\n")
    assert (rows[:, 4] == bed.body_index).all()
    for row in clumps:
        body, own = int(row[0]), rows[:, 4] == row[0]
        assert row[1] == pytest.approx(DENSITY * bed.bodies.volume[body])
        first, second = row[8:11], row[11:14]
        axes = np.column_stack([first, second, np.cross(first, second)])
        inertia = axes @ np.diag(row[5:8]) @ axes.T
        assert np.abs(inertia - DENSITY * bed.bodies.inertia[body]).max() < 1e-12 * row[7]
        # Side by side, on whichever side of a seam.
        away = np.linalg.norm(rows[own, :3] - row[2:5], axis=1)
        assert away.max() < 0.01
    text = files["bed.py"].read_text()
    assert "O.bodies[clump].state.inertia = moments" in text
    compile(text, "bed.py", "exec")
