"""Bonds: the pairs that the check finds, as CSV, for ESyS-Particle and for LAMMPS' bonded particles."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from pydantic import ValidationError

from exporters import bonds, bpm, esys
from exporters.shared.bonds import find_bonds
from packgen.check import near_pairs
from packgen.errors import ExportError
from tests.beds import box_container, make_bed
from tests.exporters.beds import RADIUS, lattice
from tests.validation.beds import bed_in

COEFFICIENTS = "1e6 1e5 1e3 1e3 1e4 1e4 1e3 1e3 0 0 0 0"


def expected(bed, gap):
    found = near_pairs(
        bed.position, bed.radius, gap_fraction=gap, period=bed.container.period, body_index=bed.body_index
    )
    pairs = np.concatenate([np.stack([each.first, each.second], axis=1) for each in found])
    return set(map(tuple, np.sort(pairs, axis=1).tolist()))


def cloud(periodic=(False, False, False), **changes):
    """Spheres of many sizes anywhere in a box of which a corner is not the origin."""
    rng = np.random.default_rng(5)
    box = box_container((-1, 2, 3), (2, 5, 6), periodic)
    position = rng.uniform(box.bounds[0], box.bounds[1], (400, 3))
    return make_bed(position, rng.uniform(0.02, 0.3, 400), box, **changes)


@pytest.mark.parametrize("periodic", [(False,) * 3, (True, False, True), (True,) * 3])
@pytest.mark.parametrize("gap", [0.0, 0.01, 0.8])
def test_bonds_are_the_pairs_that_the_check_finds(periodic, gap):
    bed = cloud(periodic)
    found = find_bonds(bed, gap, "test")
    pairs = list(zip(found.first.tolist(), found.second.tolist(), strict=True))
    assert pairs == sorted(expected(bed, gap))
    assert (found.first < found.second).all()
    assert np.allclose(found.distance - bed.radius[found.first] - bed.radius[found.second], found.gap)


def test_spheres_of_a_clump_are_not_bonded():
    bed = cloud(body_index=np.arange(400) // 3)
    found = find_bonds(bed, 0.1, "test")
    assert set(zip(found.first.tolist(), found.second.tolist(), strict=True)) == expected(bed, 0.1)


def test_a_box_too_narrow_for_bonds_is_refused_with_the_remedy(tmp_path):
    box = box_container((0, 0, 0), (1, 9, 9), (True, False, False))
    bed = make_bed([[0.5, 4, 4]], 0.3, box)
    with pytest.raises(
        ExportError, match=r"bonds: the bed wraps around along x after 1 m, .* packgen repeat"
    ):
        bonds.write(bed, tmp_path, bonds.Options())


def test_the_csv_has_ids_distances_and_gaps(tmp_path):
    bed = lattice((3, 1, 1), overlap=0.002)
    (path,) = bonds.write(bed, tmp_path, bonds.Options())
    head, *lines = path.read_text().splitlines()
    assert head == "id_1,id_2,distance,gap"
    rows = np.array([line.split(",") for line in lines], dtype=float)
    assert rows[:, :2].tolist() == [[1, 2], [2, 3]]
    assert np.allclose(rows[:, 2], 1.998 * RADIUS)
    assert np.allclose(rows[:, 3], -0.002 * RADIUS)
    bonds.write(lattice((3, 1, 1), overlap=-0.02), tmp_path, bonds.Options())
    assert path.read_text() == "id_1,id_2,distance,gap\n"
    bonds.write(lattice((3, 1, 1), overlap=-0.02), tmp_path, bonds.Options(gap="0.021"))
    assert len(path.read_text().splitlines()) == 3


def test_esys_connects_what_is_near_enough_where_a_gap_is_given(tmp_path):
    bed = cloud()
    (path,) = esys.write(bed, tmp_path, esys.Options(gap="0.05"))
    lines = path.read_text().splitlines()
    place = lines.index("BeginConnect")
    assert lines[place - 1] == "EndParticles"
    count = int(lines[place + 1])
    assert lines[place + 2 + count :] == ["EndConnect"]
    rows = np.array([line.split() for line in lines[place + 2 : place + 2 + count]], dtype=int)
    assert set(map(tuple, rows[:, :2].tolist())) == expected(bed, 0.05)
    assert not rows[:, 2].any()
    sphere_ids = [int(line.split()[4]) for line in lines[7 : 7 + bed.count]]
    assert sphere_ids == list(range(bed.count))  # bonds name the spheres by these


def read_bonded(path):
    """Read a data file of style bpm/sphere as LAMMPS' pages read_data and atom_style have it."""
    head, rest = path.read_text(encoding="ascii").split("\nAtoms # bpm/sphere\n\n")
    counts = {" ".join(line.split()[1:]): int(line.split()[0]) for line in head.splitlines()[2:6]}
    atoms, _, connected = rest.partition("\nBonds\n\n")
    rows = [
        np.array([line.split() for line in part.splitlines()], dtype=float) for part in (atoms, connected)
    ]
    assert counts["atoms"], counts["bonds"] == (len(rows[0]), len(rows[1]))
    return counts, *rows


def test_an_independent_reader_gets_spheres_and_bonds_from_the_data_file(tmp_path):
    bed = bed_in("box")
    (path,) = bpm.write(bed, tmp_path, bpm.Options())
    counts, atoms, connected = read_bonded(path)
    assert (counts["atoms"], counts["bond types"]) == (bed.count, 1)
    assert np.array_equal(atoms[:, 5:], bed.position)
    assert np.array_equal(atoms[:, 3] / 2, bed.radius)
    assert np.array_equal(atoms[:, 4], bed.density)
    assert np.array_equal(atoms[:, 0], np.arange(1, bed.count + 1))
    assert set(atoms[:, 1]) == {1.0}
    assert np.array_equal(connected[:, 0], np.arange(1, counts["bonds"] + 1))
    pairs = {(int(a) - 1, int(b) - 1) for a, b in connected[:, 2:]}
    assert pairs == expected(bed, 0.01)


def test_a_deck_is_written_only_where_bonds_are_given_their_values(tmp_path):
    bed = lattice()
    assert [path.name for path in bpm.write(bed, tmp_path, bpm.Options())] == ["bed.data"]
    paths = bpm.write(bed, tmp_path, bpm.Options(bond_coeff=COEFFICIENTS))
    assert [path.name for path in paths] == ["bed.data", "in.bed"]
    lines = paths[1].read_text().splitlines()
    order = [
        "atom_style bpm/sphere", "newton on off", "special_bonds lj 0 1 1 coul 1 1 1", "read_data bed.data",
        "bond_style bpm/rotational", "fix integrate all nve/bpm/sphere",
    ]  # fmt: skip
    assert [line for line in lines if line in order] == order
    (reach,) = [float(line.split()[-1]) for line in lines if line.startswith("comm_modify vel yes cutoff ")]
    assert reach == pytest.approx(4 * RADIUS)
    for wrong in (
        "1 2 3",
        COEFFICIENTS + " 1",
        COEFFICIENTS.replace("1e6", "-1"),
        COEFFICIENTS.replace("1e6", "x"),
    ):
        with pytest.raises(ValidationError, match="expected twelve numbers, none below 0: Kr Ks Kt Kb"):
            bpm.Options(bond_coeff=wrong)


def test_materials_that_are_not_known_are_asked_for(tmp_path):
    bed = replace(lattice(), materials=())
    with pytest.raises(ExportError, match="bpm: the materials are not known"):
        bpm.write(bed, tmp_path, bpm.Options())


def has_bonded_particles():
    program = shutil.which("lmp")
    if program is None:
        return False
    told = subprocess.run([program, "-h"], capture_output=True, text=True, check=False).stdout
    return " BPM " in told.split("List of individual style options")[0].replace("\n", " ")


@pytest.mark.solver
@pytest.mark.slow
@pytest.mark.skipif(shutil.which("lmp") is None, reason="lammps (lmp) is not installed")
@pytest.mark.parametrize("periodic", [False, True])
def test_lammps_without_the_package_reads_the_bonds_of_the_data_file(tmp_path, periodic):
    bed = lattice()
    if periodic:
        bed = replace(bed, container=replace(bed.container, periodic=(True, True, False)))
    bpm.write(bed, tmp_path, bpm.Options())
    counts, _, _ = read_bonded(tmp_path / "bed.data")
    # The same file with the columns of a style that every LAMMPS has.
    head, rest = (tmp_path / "bed.data").read_text().split("\nAtoms # bpm/sphere\n\n")
    atoms, _, connected = rest.partition("\nBonds\n\n")
    rows = [line.split() for line in atoms.splitlines()]
    turned = "\n".join(" ".join([r[0], r[2], *r[5:], r[1], r[3], r[4]]) for r in rows)
    (tmp_path / "other.data").write_text(f"{head}\nAtoms # hybrid\n\n{turned}\n\nBonds\n\n{connected}")
    flags = "p p f" if periodic else "f f f"
    (tmp_path / "in.read").write_text(
        f"units si\natom_style hybrid bond sphere\nboundary {flags}\nnewton on off\nread_data other.data\n"
    )
    run = subprocess.run(["lmp", "-in", "in.read"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout[-500:]
    assert f"{bed.count} atoms" in run.stdout
    assert f"{counts['bonds']} bonds" in run.stdout
    assert counts["bonds"] == (3 * 4 * 5 * 2 + 16 * 4) + (2 * 4 * 5 if periodic else 0)


@pytest.mark.solver
@pytest.mark.slow
@pytest.mark.skipif(not has_bonded_particles(), reason="no lammps (lmp) with the package BPM is installed")
def test_the_deck_runs_and_its_bonds_hold(tmp_path):
    bpm.write(bed_in("box"), tmp_path, bpm.Options(bond_coeff=COEFFICIENTS, steps=200))
    run = subprocess.run(["lmp", "-in", "in.bed"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout[-500:]
    assert "Loop time" in run.stdout
    assert "shorter than a bond length" not in run.stdout
