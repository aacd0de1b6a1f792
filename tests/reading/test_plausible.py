"""Lengths that are a thousand times too long or too short are seen."""

from __future__ import annotations

import pytest

from packgen import read_bed
from packgen.errors import ReadError
from packgen.reading import read_spheres, rounding_remark
from tests.beds import box_container, cubic_lattice
from tests.reading.beds import dump_text, text_file


def lattice_file(folder, length=1.0, size=1.0):
    """27 touching spheres of radius 0.1 in a box of 0.6, with lengths and sizes in some units."""
    rows = [(*(each / length), 0.1 / size) for each in cubic_lattice(3, 0.1)]
    return text_file(folder, "".join(" ".join(map(repr, map(float, row))) + "\n" for row in rows))


BOX = box_container((0, 0, 0), (0.6, 0.6, 0.6))


def test_spheres_in_the_units_of_their_container_are_taken(tmp_path):
    assert read_bed(lattice_file(tmp_path), BOX).count == 27
    assert read_bed(lattice_file(tmp_path, 1e-3, 1e-3), BOX, units="mm").radius[0] == pytest.approx(0.1)


def test_spheres_in_millimetres_beside_a_container_in_metres_are_refused(tmp_path):
    expected = (
        r"found spheres over 600 m, with a container of 0\.6 m, .*; if the file is in mm, give --units mm"
    )
    with pytest.raises(ReadError, match=expected):
        read_bed(lattice_file(tmp_path, 1e-3, 1e-3), BOX)
    with pytest.raises(ReadError, match=r"if the file is in um, give --units um"):
        read_bed(lattice_file(tmp_path, 1e-6, 1e-6), BOX)


def test_a_container_in_millimetres_beside_spheres_in_metres_is_refused(tmp_path):
    with pytest.raises(ReadError, match=r"if the container's mesh is in mm, say so \(--container-units mm\)"):
        read_bed(lattice_file(tmp_path), box_container((0, 0, 0), (600, 600, 600)))


@pytest.mark.parametrize("units", [(1.0, 1e-3), (1e-3, 1.0)])
def test_radii_in_another_unit_than_positions_are_refused(tmp_path, units):
    with pytest.raises(ReadError, match="expected radii and positions in one unit"):
        read_bed(lattice_file(tmp_path, *units))


CGS = "ITEM: UNITS\ncgs\n" + dump_text([(1, 1, 0.0, 0.0, 0.0, 0.1)])


@pytest.mark.parametrize(
    ("text", "unit", "named"),
    [
        ("x [mm],y [mm],z [mm],d [mm]\n0,0,0,10\n", "mm", r"'x \[mm\]'"),
        ("x,y,z,Radius (cm)\n0,0,0,10\n", "cm", r"'Radius \(cm\)'"),
        ("# x[um] y[um] z[um] r\n0 0 0 10\n", "um", r"'x\[um\]'"),
        (CGS, "cm", "'ITEM: UNITS cgs'"),
    ],
)
def test_a_unit_that_the_file_names_is_the_one_to_give(tmp_path, text, unit, named):
    path = text_file(tmp_path, text)
    with pytest.raises(
        ReadError, match=f":[12]: found lengths in {unit} .{named}., expected m; give --units {unit}"
    ):
        read_spheres(path)
    with pytest.raises(ReadError, match=f"found lengths in {unit} .*, expected in"):
        read_spheres(path, units="in")
    assert read_spheres(path, units=unit).count == 1


def test_columns_of_several_units_are_refused(tmp_path):
    path = text_file(tmp_path, "x [m],y [m],z [m],d [mm]\n0,0,0,10\n")
    with pytest.raises(ReadError, match=r":1: found lengths in m and mm, expected one unit; convert"):
        read_spheres(path, units="mm")


def test_units_that_are_given_are_believed(tmp_path):
    assert read_bed(lattice_file(tmp_path, 1e-3, 1e-3), BOX, units="m").radius[0] == pytest.approx(100)


def test_large_spheres_are_worth_a_word_where_no_container_tells(tmp_path):
    said = []
    read_bed(lattice_file(tmp_path, 1e-3, 1e-3), warn=said.append)
    assert any("radii up to 100 m; if the file is in millimetres, give --units mm" in line for line in said)


def test_positions_of_few_digits_are_told_where_overlaps_may_be_rounding(tmp_path):
    def remark(text, tolerance=1e-6):
        return rounding_remark(read_spheres(text_file(tmp_path, text)), tolerance)

    assert "have 6 digits: overlaps up to 0.017 of the smallest radius" in remark("12.3456 1 1 0.01\n")
    assert remark("12.3456 1 1 0.01\n", 0.1) is None
    assert remark("12.3456 1 1 0.01\n", None) is None
    assert remark("12.34567890123 1 1 0.01\n") is None
    assert remark("12 1 1 0.01\n") is None


def test_a_few_spheres_far_apart_are_taken(tmp_path):
    rows = "".join(f"{each / 9!r} {each % 3} {each % 2} 0.001\n" for each in range(10))
    assert read_bed(text_file(tmp_path, rows)).count == 10
