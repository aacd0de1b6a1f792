"""A file that is not what it claims: one line a fault, with file, line, value and what is expected."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.errors import ReadError
from packgen.reading import read_spheres
from tests.reading.beds import WRITTEN, dump_text, mixed_bed, text_file, write

HEAD = "t\n\n2 atoms\n\n"
XYZ = "2\nProperties=species:S:1:pos:R:3:radius:R:1\nA 0 0 0 1\n"

FAULTS = {
    "empty": ("", r"spheres\.txt: found an empty file, expected a row a sphere"),
    "blank": ("\n \n", "an empty file"),
    "comments": ("# nothing\n# more\n", "nothing but comments"),
    "names alone": ("x,y,z,r\n", r":2: found no row of numbers"),
    "binary": ("\0\1\2\3", r"bytes that are no text, expected text, or a file whose ending is npz"),
    "words": ("1 2 3 4\n1 2 three 4\n", r"spheres\.txt:2: found z 'three', expected a finite number"),
    "not a number": ("1 2 3 4\n\n# c\n1 nan 3 4\n", r":4: found y 'nan', expected a finite number"),
    "infinite": ("1 2 3 4\n1e999 2 3 4\n", r":2: found x '1e999', expected a finite number"),
    "no size": ("1 2 3 4\n1 2 3 0\n", r":2: found radius '0', expected a number greater than 0"),
    "negative": ("x,y,z,d\n1,2,3,-4\n", r":2: found diameter '-4', expected a number greater than 0"),
    "half a set": ("1 2 3 4 0.5\n", r":1: found set '0.5', expected a whole number"),
    "underscore": ("1 2 3 4\n1 2 3 1_0\n", r":2: found radius '1_0'"),
    "short row": ("x y z r\n1 2 3 4\n1 2 3\n", r":3: found 3 values, expected 4: x, y, z, radius"),
    "cut row": ("x y z r mass\n1 2 3 4 5\n1 2 3 4", r":3: found 4 values, expected 5"),
    "row that lacks a value": (
        "x y z r mass\n1 2 3 4 5\n1 2 4 5\n1 2 3 4 5\n",
        r":3: found 4 values, expected 5",
    ),
    "longer row": ("x,y,z,r\n1,2,3,4\n1,2,3,4,5\n", r":3: found 5 values, expected 4, as in the first row"),
    "longer row among blanks": ("1 2 3 4\n 1 2 3\t4 5\n", r":2: found 5 values, expected 4, as in"),
    "more values than names": ("x y z r\n1 0.5 2 3 4\n", r":2: found 5 values, expected 4: x, y, z, radius"),
    "three columns": ("1 2 3\n", r":1: found 3 columns without names, expected x y z radius, or the names"),
    "no radius": (
        "x,y,z,mass\n1,2,3,4\n",
        r":1: found the columns x, y, z, mass, expected radius or diameter as well",
    ),
    "decimal commas": (
        "x;y;z;r\n0,5;1;2;3\n",
        r":2: found decimal commas \('0,5'\), expected decimal points; replace",
    ),
    "decimal commas without names": ("0,5;1;2;3\n0,5;1;4;3\n", r":1: found decimal commas \('0,5'\)"),
    "decimal commas among blanks": ("0,5 1,5 2,5 3,5\n", r":1: found decimal commas \('0,5'\)"),
    "mesh": (
        "solid a\nfacet normal 0 0 1\n",
        r":1: found the columns solid, a, expected .*; is it a file of",
    ),
    "scene": ("container:\n  shape: box\n", r":1: .*; is it a file of spheres\?"),
    "twice": ("x,y,z,r,radius\n1,2,3,4,5\n", r":1: found two columns for radius"),
    "id twice": (
        "id,x,y,z,r\n7,1,2,3,4\n7,5,2,3,4\n",
        "found id 7 more than once, expected each sphere once",
    ),
    "zone": ("x,y,z,r,zone\n1,2,3,4,-1\n", "found zone numbers from -1 to -1"),
    "dump cut": (
        dump_text([(1, 1, 0.0, 0.0, 0.0, 1.0)], count=3),
        "found 1 row .* the 3 that the file announces",
    ),
    "dump cut in a line": (dump_text([(1, 1, 0.0, 0.0, 0.0, 1.0)])[:-3], "found a last line without an end"),
    "dump of one word": ("ITEM: TIMEST\n", "found no line ITEM: TIMESTEP, expected one at the start of"),
    "dump cut in its head": (dump_text([])[:60], r":1: found no line ITEM: ATOMS"),
    "dump without radii": (
        dump_text([(1, 0.0, 0.0, 0.0)], "id x y z"),
        r":9: .* expected radius or diameter as well; add radius to the columns of the dump",
    ),
    "dump without positions": (dump_text([(1, 0.0)], "id radius"), "expected x y z, xu yu zu or xs ys zs"),
    "dump of pairs": (
        dump_text([(1, 0.0)]).replace("ATOMS id", "ENTRIES c"),
        "found a dump of pairs or walls",
    ),
    "dump of nothing": (dump_text([]), r"found the number of atoms '0'"),
    "dump with a box inside out": (
        dump_text([(1, 1, 0.0, 0.0, 0.0, 1.0)], box=((0, 1), (2, 1), (0, 1))),
        "expected three lines of two numbers, the lower one first",
    ),
    "dump without a box": (dump_text([(1, 1, 0.0, 0.0, 0.0, 1.0)], box=()), "box bounds that are none"),
    "dump with a tilted box": (
        dump_text([(1, 1, 0.0, 0.0, 0.0, 1.0)], flags="xy xz yz pp pp ff", box=((0, 4, 1),) * 3),
        "found a tilted box with walls, expected one that wraps around along x, y and z",
    ),
    "dump with a box of any edges": (
        dump_text([(1, 1, 0.0, 0.0, 0.0, 1.0)], flags="abc origin pp pp pp", box=((3, 0, 0, 0),) * 3),
        "found a box of any three edges, expected one whose first lies along x",
    ),
    "dump with tilts wider than its bounds": (
        dump_text([(1, 1, 0.0, 0.0, 0.0, 1.0)], flags="xy xz yz pp pp pp", box=((0, 4, 5),) * 3),
        "expected three lines of two numbers, the lower one first",
    ),
    "data with tilts and no bounds": (
        f"{HEAD}0 1 xlo xhi\n0 a ylo yhi\n0 1 zlo zhi\n0 0 0 xy xz yz\n\nAtoms\n\n"
        "1 1 0.2 2500 0 0 0\n2 1 0.2 2500 0 0 1\n",
        "found a tilted box without sound bounds, expected lines xlo xhi",
    ),
    "data cut": (f"{HEAD}Atoms\n\n1 1 0.2 2500 0 0 0\n", "found 1 row .* the 2 that the file announces"),
    "data without atoms": (HEAD, "found no section Atoms"),
    "data without rows": (f"{HEAD}Atoms\n\n", "found no rows"),
    "data of points": (
        f"{HEAD}Atoms # atomic\n\n1 1 0 0 0\n2 1 0 0 0\n",
        r":5: found Atoms # atomic with 5 columns, expected those of atom style sphere",
    ),
    "data of unlike rows": (
        f"{HEAD}Atoms\n\n1 1 0.2 2500 0 0 0\n1 1 0.2\n",
        r":8: found 3 values, expected 7: id, type, diameter",
    ),
    "xyz cut": (XYZ, "found 1 row .* the 2 that the file announces"),
    "xyz of a line": ("2\n", r":1: found nothing after the number of spheres"),
    "xyz without properties": (
        "1\nwater\nO 0 0 0\n",
        r":2: .*expected Properties=species:S:1:pos:R:3:radius:R:1",
    ),
    "xyz without radii": (
        "1\nProperties=species:S:1:pos:R:3\nO 0 0 0\n",
        r":2: .*expected radius or diameter as well",
    ),
    "xyz with words": (XYZ + "A 0 0 b 1\n", r":4: found z 'b', expected a finite number"),
    "xyz with rest": (XYZ + "A 0 0 0 1\nrest\n", r":5: found 'rest', expected the number of spheres"),
    "xyz that lacks a species": (
        "3\nProperties=pos:R:3:radius:R:1:species:S:1\n0 0 0 1 A\n0 0 3 1\n0 0 6 1 A\n",
        r":4: found 4 values, expected 5",
    ),
    "xyz that wraps around nothing": (
        '1\nProperties=pos:R:3:radius:R:1 pbc="T F F" Lattice="0 0 0 0 1 0 0 0 1"\n0 0 0 1\n',
        r":2: found a lattice of length 0 along x, expected a length greater than 0 where pbc is T",
    ),
    "xyz tilted": (
        '1\nProperties=pos:R:3:radius:R:1 pbc="T T T" Lattice="1 1 0 0 1 0 0 0 1"\n0 0 0 1\n',
        "a lattice that is tilted",
    ),
    "mfix of another version": (
        "Version 3.0\nParticles: 2\n",
        r":1: found 'Version 3\.0', expected Version 2\.0",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_a_file_that_is_not_what_it_claims_is_refused_with_a_line(tmp_path, name):
    text, expected = FAULTS[name]
    with pytest.raises(ReadError, match=expected) as caught:
        read_spheres(text_file(tmp_path, text))
    (line,) = str(caught.value).splitlines()
    assert line.startswith(str(tmp_path / "spheres.txt"))
    assert caught.value.exit_code == 2


CUTS = [(name, share) for name in WRITTEN for share in (0.3, 0.6, 0.9) if name not in ("vtk", "vtu")]


@pytest.mark.parametrize(("name", "share"), [*CUTS, ("vtk", 0.6), ("vtu", 0.6)])
def test_every_format_that_knows_its_length_refuses_a_file_cut_short(tmp_path, name, share):
    path = write(mixed_bed(300), name, tmp_path)
    whole = path.read_bytes()
    path.write_bytes(whole[: int(share * len(whole))])
    if name in {
        "csv",
        "yade",
        "chrono",
        "geotaichi",
    }:  # whatever is cut there leaves whole rows, and a part of one
        with path.open("ab") as file:
            file.write(b"\n0.5")
    with pytest.raises(ReadError) as caught:
        read_spheres(path)
    assert len(str(caught.value).splitlines()) <= 21


@pytest.mark.parametrize(
    ("ending", "content"),
    [
        ("npz", b""), ("npz", b"1 2 3 4\n"), ("npz", b"PK\3\4 no archive"), ("npz", b"\x93NUMPY"),
        ("vtp", b""), ("vtp", b"1 2 3 4\n"), ("vtu", b"<VTKFile type='PolyData'>"), ("vtk", b"PK\3\4"),
    ],
)  # fmt: skip
def test_a_file_whose_ending_lies_is_refused(tmp_path, ending, content, capfd):
    path = tmp_path / f"bed.{ending}"
    path.write_bytes(content)
    with pytest.raises(ReadError, match=rf"bed\.{ending}: found .*, expected .*"):
        read_spheres(path)
    assert capfd.readouterr() == ("", "")  # libraries keep quiet


def test_arrays_that_no_bed_has_are_named_with_their_place(tmp_path):
    position = np.zeros((3, 3))
    position[1, 2] = np.nan
    np.savez(tmp_path / "a.npz", position=position, radius=[1.0, 0.0, 1.0], set_index=[0, 0, -1])
    with pytest.raises(ReadError) as caught:
        read_spheres(tmp_path / "a.npz")
    lines = [line.removeprefix(f"{tmp_path}/a.npz:") for line in str(caught.value).splitlines()]
    assert lines == [
        "position[1, 2]: found nan, expected a finite number",
        "radius[1]: found 0.0, expected a number greater than 0",
        "set_index[2]: found -1, expected a whole number from 0 on",
    ]
    for name, value in (
        ("position", np.zeros((2, 2))),
        ("radius", np.array(["a", "b"])),
        ("zone_index", [0.5, 1]),
    ):
        arrays = {"position": np.zeros((2, 3)), "radius": np.ones(2), name: value}
        np.savez(tmp_path / "b.npz", **arrays)
        with pytest.raises(ReadError, match=rf"b\.npz:{name}: found"):
            read_spheres(tmp_path / "b.npz")
    np.savez(tmp_path / "c.npz", points=position)
    with pytest.raises(ReadError, match="found the arrays points, expected position and radius as well"):
        read_spheres(tmp_path / "c.npz")
    np.savez(tmp_path / "d.npz", position=np.zeros((0, 3)), radius=[])
    with pytest.raises(ReadError, match="found no spheres"):
        read_spheres(tmp_path / "d.npz")


def test_a_million_bad_lines_are_twenty_faults_and_their_number(tmp_path):
    path = text_file(tmp_path, "0 0 0 1\n" + "0 0 0 bad\n" * 50_000)
    with pytest.raises(ReadError) as caught:
        read_spheres(path)
    lines = str(caught.value).splitlines()
    assert len(lines) == 21
    assert lines[0] == f"{path}:2: found radius 'bad', expected a number greater than 0"
    assert lines[-1] == f"{path}: found 49,980 faults more, expected none"


def test_directories_and_files_that_are_not_there_are_refused(tmp_path):
    with pytest.raises(
        ReadError, match=r": found a directory, expected a file of spheres; name a file in it$"
    ):
        read_spheres(tmp_path)
    write(mixed_bed(3), "npz", tmp_path)
    with pytest.raises(ReadError, match=r"name a file in it, such as .*bed\.npz"):
        read_spheres(tmp_path)
    for name in ("gone.csv", "gone.npz", "gone.vtp"):
        with pytest.raises(ReadError, match=rf"{name}: found no such file, expected a file of spheres"):
            read_spheres(tmp_path / name)


@pytest.mark.parametrize("name", ["npz", "csv", "liggghts", "vtk"])
def test_a_step_of_a_file_without_steps_is_refused(tmp_path, name):
    path = write(mixed_bed(3), name, tmp_path)
    with pytest.raises(ReadError, match="which has no steps, expected a file with step 5; leave --step out"):
        read_spheres(path, step=5)


def test_glued_spheres_of_mfix_are_refused(tmp_path):
    path = write(mixed_bed(3), "mfix", tmp_path)
    text = path.read_text().replace("Temperature:", "Quaternion: T\nTemperature:")
    with pytest.raises(ReadError, match="found glued spheres"):
        read_spheres(text_file(tmp_path, text))
    for before, after, expected in (
        ("Coordinates: T", "Coordinates: F", "positions in the rows"),
        ("Coordinates: T", "Coordinates: x", "no line Coordinates: T"),
        ("Particles: 3", "Particles: many", "the number of particles 'many'"),
        ("Density: T", "Density: F", "found Density: F, expected T, or"),
    ):
        with pytest.raises(ReadError, match=expected):
            read_spheres(text_file(tmp_path, path.read_text().replace(before, after)))


def test_values_are_shown_short_and_in_plain_characters(tmp_path):
    with pytest.raises(ReadError) as caught:
        read_spheres(text_file(tmp_path, "0 0 0 1\n0 0 0 \x1b[31m" + "x" * 200 + "\n"))
    line = str(caught.value)
    assert "\\x1b[31mxxx" in line
    assert len(line) < len(str(tmp_path)) + 150


def test_a_file_on_which_vtk_ends_its_process_is_a_fault(tmp_path):
    path = write(mixed_bed(20), "vtk", tmp_path)
    data = path.read_bytes()
    assert b'NumberOfPoints="20"' in data
    path.write_bytes(data.replace(b'NumberOfPoints="20"', b'NumberOfPoints="99999999999999"'))
    with pytest.raises(ReadError, match="what VTK cannot read as points"):
        read_spheres(path)
