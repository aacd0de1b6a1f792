"""What was written comes back, to the format's digits."""

from __future__ import annotations

import numpy as np
import pytest

from exporters import lammps
from packgen.reading import read_bed, read_spheres
from tests.cells import SKEWED, all_gaps, random_spheres
from tests.reading.beds import WRITTEN, dump_text, mixed_bed, text_file, write

WHOLE = [name for name in WRITTEN if name not in ("geotaichi",)]


@pytest.mark.parametrize("name", WHOLE)
def test_positions_radii_and_groups_come_back(tmp_path, name):
    bed = mixed_bed(200)
    found = read_spheres(write(bed, name, tmp_path))
    assert np.array_equal(found.position, bed.position)
    assert np.allclose(found.radius, bed.radius, rtol=1e-15, atol=0)
    expected = bed.type_index + 1 if found.groups.kind == "type" else bed.set_index
    assert np.array_equal(found.groups.number, expected)


@pytest.mark.parametrize("name", ["csv", "liggghts", "lammps", "bpm", "mfix", "extxyz"])
def test_densities_come_back_where_the_format_has_them(tmp_path, name):
    bed = mixed_bed(50)
    assert np.array_equal(read_spheres(write(bed, name, tmp_path)).density, bed.density)


@pytest.mark.parametrize("name", ["npz", "csv", "vtk", "vtu", "extxyz"])
def test_zones_and_batches_come_back_where_the_format_has_them(tmp_path, name):
    bed = mixed_bed(50)
    found = read_spheres(write(bed, name, tmp_path))
    assert np.array_equal(found.zone_index, bed.zone_index)
    assert np.array_equal(found.batch_index, bed.batch_index)


def test_rows_x_y_z_r_come_back(tmp_path):
    bed = mixed_bed(50)
    found = read_spheres(write(bed, "geotaichi", tmp_path))
    chosen = bed.set_index == 0
    assert np.array_equal(found.position, bed.position[chosen])
    assert np.array_equal(found.radius, bed.radius[chosen])
    assert found.groups is None


ROWS = [(3, 2, 0.5, 0.25, 1.0, 0.1), (1, 1, 0.125, 2.0, 1.5, 0.2)]


@pytest.mark.parametrize(
    ("columns", "rows"),
    [
        ("id type x y z radius", ROWS),
        ("id type xu yu zu radius", ROWS),
        ("id type xs ys zs radius", [(i, t, x / 3, y / 3, z / 3, r) for i, t, x, y, z, r in ROWS]),
        ("diameter id x vx y z type", [(2 * r, i, x, 9.0, y, z, t) for i, t, x, y, z, r in ROWS]),
    ],
)
def test_a_dump_is_read_in_each_form_of_its_columns_by_rising_id(tmp_path, columns, rows):
    found = read_spheres(text_file(tmp_path, dump_text(rows, columns)))
    assert np.allclose(found.position, [[0.125, 2.0, 1.5], [0.5, 0.25, 1.0]], rtol=1e-15)
    assert found.radius.tolist() == [0.2, 0.1]
    assert found.id.tolist() == [1, 3]
    assert found.groups.number.tolist() == [1, 2]
    assert found.cell is None


def test_a_dump_of_many_steps_gives_the_last_or_the_named_one(tmp_path):
    frames = [dump_text([(1, 1, float(step), 0.0, 0.0, 0.1)], step=step) for step in (0, 100, 250)]
    path = text_file(tmp_path, "".join(frames))
    assert read_spheres(path).position[0, 0] == 250
    assert read_spheres(path, step=100).position[0, 0] == 100
    with pytest.raises(ValueError, match="no step 7, expected one of its steps, 0, 100, 250"):
        read_spheres(path, step=7)


def test_items_between_the_steps_of_a_dump_belong_to_no_row(tmp_path):
    frames = [dump_text([(1, 1, float(step), 0.0, 0.0, 0.1)], step=step) for step in (0, 100)]
    text = "ITEM: UNITS\nsi\n" + "".join(f"ITEM: TIME\n0.5\n{frame}" for frame in frames)
    path = text_file(tmp_path, text)
    assert read_spheres(path, step=0).position[0, 0] == 0.0
    assert read_spheres(path).position[0, 0] == 100.0


def test_scaled_positions_count_from_the_lower_corner_of_the_box(tmp_path):
    rows = [(4, 7, 0.25, 0.5, 0.75, 0.1)]
    path = text_file(tmp_path, dump_text(rows, "id type xs ys zs radius", box=((-2, 2), (1, 3), (5, 9))))
    assert read_spheres(path).position.tolist() == [[-1.0, 2.0, 8.0]]


@pytest.mark.parametrize("columns", ["id type x y z radius", "id type xs ys zs radius"])
def test_a_dump_of_a_tilted_box_is_a_periodic_cell_from_the_origin(tmp_path, columns):
    bed, corner = random_spheres(8), np.array([5.0, -3.0, 2.0])
    place = bed.position @ np.linalg.inv(SKEWED) if "xs" in columns else bed.position + corner
    rows = [
        (number, 1, *each, size)
        for number, (each, size) in enumerate(zip(place.tolist(), bed.radius.tolist(), strict=True))
    ]
    # The bounds of the box around it, by the corners of the cell one by one: yz moves nothing along x.
    (lx, _, _), (xy, ly, _), (xz, yz, lz) = SKEWED.tolist()
    along_x, along_y = [0.0, xy, xz, xy + xz], [0.0, yz]
    box = (
        (corner[0] + min(along_x), corner[0] + lx + max(along_x), xy),
        (corner[1] + min(along_y), corner[1] + ly + max(along_y), xz),
        (corner[2], corner[2] + lz, yz),
    )
    text = dump_text(rows, columns, flags="xy xz yz pp pp pp", box=[tuple(map(float, each)) for each in box])
    found = read_bed(text_file(tmp_path, text))
    assert found.container.cell == pytest.approx(SKEWED)
    assert found.position == pytest.approx(bed.position)
    assert all_gaps(found) == pytest.approx(all_gaps(bed))


def test_a_dump_whose_tilts_are_none_is_a_box(tmp_path):
    flags, box = "xy xz yz pp pp ff", ((0, 1, 0), (-1, 2, 0), (3, 5, 0))
    cell = read_spheres(text_file(tmp_path, dump_text(ROWS, flags=flags, box=box))).cell
    assert cell.vectors is None
    assert cell.periodic == (True, True, False)
    assert cell.bounds.tolist() == [[0, -1, 3], [1, 2, 5]]


def test_data_with_tilts_are_a_periodic_cell_from_the_origin(tmp_path):
    bed, corner = random_spheres(8), np.array([5.0, -3.0, 2.0])
    lammps.write(bed, tmp_path, lammps.Options())
    found = read_bed(tmp_path / "bed.data")
    assert np.array_equal(found.container.cell, SKEWED)
    assert np.array_equal(found.position, bed.position)
    bounds = "".join(
        f"{low!r} {low + size!r} {axis}lo {axis}hi\n"
        for axis, low, size in zip("xyz", corner.tolist(), np.diag(SKEWED).tolist(), strict=True)
    )
    rows = "".join(
        f"{number} 1 {2 * size!r} 2500 {x!r} {y!r} {z!r}\n"
        for number, (size, (x, y, z)) in enumerate(
            zip(bed.radius.tolist(), (bed.position + corner).tolist(), strict=True), start=1
        )
    )
    moved = text_file(
        tmp_path, f"moved\n\n8 atoms\n1 atom types\n\n{bounds}1.2 -1.4 1.1 xy xz yz\n\nAtoms\n\n{rows}"
    )
    found = read_bed(moved)
    assert found.container.cell == pytest.approx(SKEWED)
    assert found.position == pytest.approx(bed.position)


def test_a_dump_knows_along_which_axes_its_box_wraps_around(tmp_path):
    text = dump_text(ROWS, flags="pp ff pp", box=((0, 1), (-1, 2), (3, 5)))
    cell = read_spheres(text_file(tmp_path, text)).cell
    assert cell.periodic == (True, False, True)
    assert cell.bounds.tolist() == [[0, -1, 3], [1, 2, 5]]


def test_a_data_file_is_read_with_image_flags_velocities_and_bodies(tmp_path):
    head = "LAMMPS data file\n\n2 atoms\n3 atom types\n\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\n"
    sphere = "Atoms # sphere\n\n2 1 0.2 2500 0.5 0.6 0.7 0 0 -1\n1 3 0.4 3500 0.1 0.2 0.3 0 0 0\n\n"
    found = read_spheres(text_file(tmp_path, f"{head}{sphere}Velocities\n\n1 0 0 0 0 0 0\n"))
    assert found.position.tolist() == [[0.1, 0.2, 0.3], [0.5, 0.6, 0.7]]
    assert found.radius.tolist() == [0.2, 0.1]
    assert found.groups.number.tolist() == [3, 1]
    assert found.body_index is None
    hybrid = "Atoms\n\n1 1 0.1 0.2 0.3 0.4 2500 7\n2 1 0.5 0.6 0.7 0.4 2500 7\n"
    found = read_spheres(text_file(tmp_path, head + hybrid))
    assert found.position[1].tolist() == [0.5, 0.6, 0.7]
    assert found.body_index[0] == found.body_index[1]


def test_bonded_spheres_are_bodies_of_their_own(tmp_path):
    assert read_spheres(write(mixed_bed(20), "bpm", tmp_path)).body_index is None


def test_a_sphere_of_no_molecule_is_a_body_of_its_own(tmp_path):
    rows = "1 1 0.1 0.2 0.3 0.4 2500 0\n2 1 0.5 0.6 0.7 0.4 2500 0\n3 1 0.5 0.6 0.7 0.4 2500 1\n"
    found = read_spheres(text_file(tmp_path, f"title\n\n3 atoms\n\nAtoms\n\n{rows}"))
    assert len(set(found.body_index.tolist())) == 3


@pytest.mark.parametrize(
    "text",
    [
        "0 0 1 0.5 0\n0 0 2 0.25 1\n",
        "#format x_y_z_r_matId\n0 0 1 0.5 0\n0 0 2 0.25 1\n",
        "# x y z r set\n\n0 0 1 0.5 0\n0 0 2 0.25 1\n",
        "x,y,z,radius,set\n0,0,1,0.5,0\n0,0,2,0.25,1",
        '"X [m]";"Y [m]";"Z [m]";"Diameter [m]";"Material"\r\n0;0;1;1;0\r\n0;0;2;0.5;1\r\n',
        "p_x; p_y; p_z; v_x; diameters; set;\n0; 0; 1; 9; 1; 0;\n0; 0; 2; 9; 0.5; 1;\n",
        "x\ty\tz\tr\tset\n0\t0\t1\t0.5\t0\n0\t0\t2\t0.25\t1\n",
        "  0   0  1 5e-1   0\n  0   0  2 2.5E-1 +1  # the second\n",
    ],
)
def test_tables_are_read_with_and_without_names_of_columns(tmp_path, text):
    found = read_spheres(text_file(tmp_path, text))
    assert found.position.tolist() == [[0, 0, 1], [0, 0, 2]]
    assert found.radius.tolist() == [0.5, 0.25]
    assert found.groups.number.tolist() == [0, 1]


def test_yades_clumps_are_bodies(tmp_path):
    found = read_spheres(text_file(tmp_path, "#x_y_z_r_clumpId\n0 0 0 1 4\n0 0 1 1 4\n0 9 0 1 5\n"))
    assert found.body_index.tolist() == [4, 4, 5]


def test_extended_xyz_of_others_is_read_by_its_properties(tmp_path):
    text = (
        '2\nProperties=id:I:1:species:S:1:pos:R:3:velo:R:3:radius:R:1 Lattice="2 0 0 0 3 0 0 0 4" pbc="T F T"'
        ' Origin="-1 0 0" Timestep=5\n2 Fe 1 1 1 0 0 0 0.5\n1 C 0 0 0 0 0 0 0.25\n'
    )
    found = read_spheres(text_file(tmp_path, text, "a.xyz"))
    assert found.radius.tolist() == [0.25, 0.5]
    assert [found.groups.label(each) for each in found.groups.number] == ["C", "Fe"]
    assert found.cell.periodic == (True, False, True)
    assert found.cell.bounds.tolist() == [[-1, 0, 0], [1, 3, 4]]
    later = text.replace("Timestep=5", "Timestep=9").replace("0.5", "0.75")
    path = text_file(tmp_path, text + later, "b.xyz")
    assert read_spheres(path).radius[1] == 0.75
    assert read_spheres(path, step=5).radius[1] == 0.5


def test_extended_xyz_may_have_no_length_where_nothing_wraps_around(tmp_path):
    head = '1\nProperties=pos:R:3:radius:R:1 Lattice="2 0 0 0 3 0 0 0 0" pbc="T T F"\n'
    cell = read_spheres(text_file(tmp_path, head + "0 0 0 1\n")).cell
    assert cell.periodic == (True, True, False)
    assert cell.bounds[1, :2].tolist() == [2.0, 3.0]


def test_mfix_has_what_is_the_same_for_all_in_its_options(tmp_path):
    path = write(mixed_bed(5), "mfix", tmp_path)
    text = path.read_text().replace("Diameter: T", "Diameter: F 0.5").replace("Phase_ID: T", "Phase_ID: F 2")
    lines = text.splitlines()
    rows = [" ".join([*line.split()[:3], line.split()[5]]) for line in lines[34:]]
    found = read_spheres(text_file(tmp_path, "\n".join([*lines[:34], *rows]) + "\n"))
    assert found.radius.tolist() == [0.25] * 5
    assert found.groups.number.tolist() == [1] * 5


def test_lengths_in_another_unit_become_metres(tmp_path):
    found = read_spheres(text_file(tmp_path, "0 0 1000 5\n"), units="mm")
    assert found.position[0, 2] == 1.0
    assert found.radius[0] == 0.005


def test_archives_of_numpy_need_positions_and_radii_alone(tmp_path):
    np.savez(tmp_path / "a.npz", position=[[0, 0, 1]], radius=[1])
    found = read_spheres(tmp_path / "a.npz")
    assert found.position.dtype == found.radius.dtype == np.float64
    assert found.groups is None
