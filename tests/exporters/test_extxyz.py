"""Extended XYZ, read back by a reader written from OVITO's and ASE's pages."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from exporters import extxyz
from packgen.bed import ParticleSet
from tests.beds import box_container, make_bed
from tests.exporters.test_vtk import mixed_bed


def read_extxyz(path):
    """Return the second line's keys, and the columns by the names of the properties."""
    count, head, *lines = path.read_text(encoding="ascii").splitlines()
    assert len(lines) == int(count)
    keys = {name: quoted or plain for name, quoted, plain in re.findall(r'(\w+)=(?:"([^"]*)"|(\S+))', head)}
    words = keys["Properties"].split(":")
    cells, columns, place = [line.split(" ") for line in lines], {}, 0
    for name, kind, width in zip(words[::3], words[1::3], map(int, words[2::3]), strict=True):
        values = np.array([row[place : place + width] for row in cells])
        columns[name] = values if kind == "S" else values.astype({"R": float, "I": int}[kind])
        place += width
    assert {len(row) for row in cells} == {place}
    return keys, columns


def test_an_independent_reader_gets_the_bed_back(tmp_path):
    bed = mixed_bed(9000)
    (path,) = extxyz.write(bed, tmp_path, extxyz.Options())
    keys, columns = read_extxyz(path)
    assert keys["Lattice"] == "3.0 0.0 0.0 0.0 3.0 0.0 0.0 0.0 3.0"
    assert (keys["Origin"], keys["pbc"]) == ("0.0 0.0 0.0", "F F F")
    assert np.array_equal(columns["pos"], bed.position)
    assert np.array_equal(columns["radius"][:, 0], bed.radius)
    assert np.array_equal(columns["density"][:, 0], bed.density)
    assert np.array_equal(columns["species"][:, 0], np.array(["a", "b"])[bed.set_index])
    assert np.array_equal(columns["id"][:, 0], np.arange(1, 9001))
    for name in ("set", "zone", "batch"):
        assert np.array_equal(columns[name][:, 0], getattr(bed, f"{name}_index"))


def test_names_are_words_and_boxes_that_wrap_around_are_told(tmp_path):
    box = box_container((1, 2, 3), (3, 5, 7), (True, False, True))
    bed = make_bed([[2, 3, 4]], 0.5, box, particle_sets=(ParticleSet('a "b", [c]', 2500.0, "ore"),))
    keys, columns = read_extxyz(extxyz.write(bed, tmp_path, extxyz.Options())[0])
    assert (keys["pbc"], keys["Origin"]) == ("T F T", "1.0 2.0 3.0")
    assert columns["species"].tolist() == [["a__b____c_"]]


def test_a_density_that_is_not_known_is_left_out(tmp_path):
    bed = replace(mixed_bed(3), particle_sets=(ParticleSet("a", np.nan, ""), ParticleSet("b", np.nan, "")))
    assert "density" not in read_extxyz(extxyz.write(bed, tmp_path, extxyz.Options())[0])[1]
