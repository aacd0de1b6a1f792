"""Cells of any shape in files: CIF, tilted boxes of LAMMPS, extended XYZ; other formats refuse them."""

from __future__ import annotations

import shlex
import shutil
import subprocess

import numpy as np
import pytest

import exporters
from exporters import cif, extxyz, lammps
from packgen.bed import Bed
from packgen.bedfile import save_bed
from packgen.errors import ExportError
from packgen.reading import read_bed
from packgen.reshape.repeat import repeat_bed
from tests.beds import box_container, make_bed
from tests.cells import SKEWED, all_gaps, close_packing, random_spheres
from tests.exporters.beds import read_data_file


def read_cif(path):
    """Return a CIF's items and the rows of its last loop by name; after the format's own grammar."""
    items, rows, names = {}, [], []
    for line in path.read_text(encoding="ascii").splitlines():
        words = shlex.split(line, comments=True)
        if not words:
            continue
        if words == ["loop_"]:
            names, rows = [], []
        elif words[0].startswith("_") and len(words) == 1:
            names.append(words[0])
        elif words[0].startswith("_"):
            items[words[0]] = words[1]
        elif names:
            rows.append(words)
    return items, {name: [row[place] for row in rows] for place, name in enumerate(names)}


def test_a_cif_holds_cell_places_and_radii(tmp_path):
    bed = random_spheres(12)
    (path,) = cif.write(bed, tmp_path, cif.Options())
    items, columns = read_cif(path)
    unit = bed.radius.max()
    a, b, c = (float(items[f"_cell_length_{each}"]) * unit for each in "abc")
    assert (a, b, c) == pytest.approx(np.linalg.norm(SKEWED, axis=1).tolist())
    cosines = np.cos(np.radians([float(items[f"_cell_angle_{each}"]) for each in ("alpha", "beta", "gamma")]))
    assert cosines == pytest.approx(
        [SKEWED[1] @ SKEWED[2] / b / c, SKEWED[0] @ SKEWED[2] / a / c, SKEWED[0] @ SKEWED[1] / a / b]
    )
    place = np.array([columns[f"_atom_site_fract_{each}"] for each in "xyz"], float).T
    assert place @ SKEWED == pytest.approx(bed.position)
    assert np.array(columns["_packgen_atom_site_radius"], float) * unit == pytest.approx(bed.radius)
    assert columns["_atom_site_label"][:2] == ["Ar1", "Ar2"]
    assert float(items["_packgen_unit_of_length"]) == unit


def test_a_cif_takes_a_periodic_box_and_refuses_walls_and_too_few_elements(tmp_path):
    box = make_bed(np.full((1, 3), 1.5), 0.5, box_container([1, 1, 1], [3, 4, 5], periodic=(True,) * 3))
    (path,) = cif.write(box, tmp_path, cif.Options(elements="Na"))
    items, columns = read_cif(path)
    assert [float(items[f"_cell_length_{each}"]) for each in "abc"] == pytest.approx([4.0, 6.0, 8.0])
    assert [float(columns[f"_atom_site_fract_{each}"][0]) for each in "xyz"] == pytest.approx(
        [1 / 4, 1 / 6, 1 / 8]
    )
    assert columns["_atom_site_type_symbol"] == ["Na"]
    walled = make_bed(np.full((1, 3), 1.5), 0.5, box_container([1, 1, 1], [3, 4, 5]))
    with pytest.raises(ExportError, match=r"cif: found a container with walls.*periodic"):
        cif.write(walled, tmp_path, cif.Options())
    with pytest.raises(ValueError, match="symbols such as Na,Cl"):
        cif.Options(elements="Na;Cl")


@pytest.mark.parametrize("name", sorted(set(exporters.BUILTIN) - {"lammps", "cif", "extxyz", "csv", "vtk"}))
def test_formats_that_know_no_such_cell_refuse_it_by_name_in_a_line(name, tmp_path):
    exporter = exporters.get(name)
    with pytest.raises(ExportError) as refused:
        exporter.write(close_packing(), tmp_path, None)
    line = str(refused.value)
    assert line.startswith(f"{name}: found a periodic cell")
    assert line.endswith("lammps, vtk, csv, extxyz, cif")
    assert "\n" not in line
    assert not list(tmp_path.iterdir())


def test_a_data_file_has_the_tilts_and_a_reader_gets_the_spheres_back(tmp_path):
    bed = random_spheres(12)
    lammps.write(bed, tmp_path, lammps.Options())
    header, rows = read_data_file(tmp_path / "bed.data")
    assert header["xlo xhi"] == [0.0, 3.0]
    assert header["ylo yhi"] == [0.0, 2.8]
    assert header["zlo zhi"] == [0.0, 2.5]
    assert header["xy xz yz"] == [1.2, -1.4, 1.1]
    assert rows[:, 4:7] == pytest.approx(bed.position)
    assert "boundary p p p" in (tmp_path / "in.bed").read_text()


@pytest.mark.parametrize("form", ["npz", "xyz"])
def test_a_cell_comes_back_from_files(form, tmp_path):
    bed = random_spheres(12)
    path = tmp_path / f"bed.{form}"
    if form == "npz":
        save_bed(bed, path)
        with np.load(path) as stored:
            assert (stored["cell"] == SKEWED).all()
    else:
        extxyz.write(bed, tmp_path, extxyz.Options())
    found = Bed.load(path)
    assert (found.container.cell == SKEWED).all()
    assert (found.position == bed.position).all()
    assert found.container.walls_known


def test_a_repeated_cell_is_as_dense_and_touches_itself():
    repeated = repeat_bed(close_packing(0.5 * (1.0 - 1e-10)), (3, 2, 4))
    bed = repeated.bed
    assert bed.count == 24
    assert bed.container.volume == pytest.approx(24 / np.sqrt(2.0))
    assert repeated.contacts == 6
    assert repeated.seam_contacts == 6 * 24
    assert repeated.worst_overlap < 0.0


@pytest.mark.solver
def test_lammps_reads_a_tilted_box_and_counts_its_contacts(tmp_path):
    if shutil.which("lmp") is None:
        pytest.skip("lmp is not installed")
    bed = repeat_bed(close_packing(0.5 * (1.0 + 1e-6)), (3, 3, 3)).bed
    lammps.write(bed, tmp_path, lammps.Options())
    count = "compute touching all contact/atom\ncompute mean all reduce ave c_touching\n"
    deck = (
        (tmp_path / "in.bed").read_text().replace("thermo_style custom", count + "thermo_style custom c_mean")
    )
    (tmp_path / "in.bed").write_text(deck)
    run = subprocess.run(
        ["lmp", "-in", "in.bed", "-var", "steps", "1"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    row = run.stdout.split("\nStep")[1] if "\nStep" in run.stdout else run.stdout
    assert "triclinic box" in run.stdout
    assert " 12 " in row
    assert read_bed(tmp_path / "bed.data").container.cell == pytest.approx(bed.container.cell)
    # A step moves spheres by parts of a radius in a million: what LAMMPS leaves is the bed, tilts and all.
    (left,) = sorted((tmp_path / "post").glob("bed_*0.dump"))[:1]
    found = read_bed(left)
    assert found.container.cell == pytest.approx(bed.container.cell, abs=1e-5)
    assert all_gaps(found, 1).min() == pytest.approx(all_gaps(bed, 1).min(), abs=1e-4)
