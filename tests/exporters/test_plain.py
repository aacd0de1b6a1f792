"""Each plain format, read back by a reader written from its reference, shares no code with the exporters."""

from __future__ import annotations

import numpy as np
import pytest

import exporters
from packgen.errors import ExportError
from tests.beds import box_container, make_bed
from tests.exporters.test_vtk import mixed_bed


def read_csv(folder):
    head, *lines = (folder / "bed.csv").read_text().splitlines()
    rows = np.array([line.split(",") for line in lines], dtype=float)
    column = dict(zip(head.split(","), rows.T, strict=True))
    return np.stack([column[each] for each in "xyz"], axis=1), column["radius"], column["set"]


def read_mercury(folder):
    head, *lines = (folder / "bed.data").read_text().splitlines()
    assert len(head.split()) == 8
    rows = np.array([line.split() for line in lines], dtype=float)
    assert rows.shape == (int(head.split()[0]), 14)
    return rows[:, :3], rows[:, 6], rows[:, 13]


def read_esys(folder):
    lines = (folder / "bed.geo").read_text().splitlines()
    assert lines[0] == "LSMGeometry 1.2"
    assert [lines[index].split()[0] for index in (1, 2, 3)] == [
        "BoundingBox",
        "PeriodicBoundaries",
        "Dimension",
    ]
    count = int(lines[6])  # YADE's gengeoFile reads the seventh line
    assert lines[7 + count :] == ["EndParticles", "BeginConnect", "0", "EndConnect"]
    rows = np.array([line.split() for line in lines[7 : 7 + count]], dtype=float)
    assert np.array_equal(rows[:, 4], np.arange(count))
    return rows[:, :3], rows[:, 3], rows[:, 5]


def read_kratos(folder):
    blocks, name = {}, []
    for line in (folder / "bedDEM.mdpa").read_text().splitlines():
        words = line.split()
        if words[:1] == ["Begin"]:
            name.append(" ".join(words[1:]))
            blocks["/".join(name)] = []
        elif words[:1] == ["End"]:
            assert name.pop().split()[0] == words[1]
        elif words:
            blocks["/".join(name)].append([float(word) for word in words])
    nodes = np.array(blocks["Nodes"])
    assert np.array_equal(np.array(blocks["Elements SphericParticle3D"])[:, 2], nodes[:, 0])
    sets = np.full(len(nodes), -1)
    for index in range(2):
        part = f"SubModelPart DEMParts_{index}"
        members = np.array(blocks[f"{part}/SubModelPartNodes"], dtype=int).ravel()
        assert blocks[f"{part}/SubModelPartElements"] == blocks[f"{part}/SubModelPartNodes"]
        sets[members - 1] = index
    return nodes[:, 1:], np.array(blocks["NodalData RADIUS"])[:, 2], sets


def read_chrono(folder):
    head, *lines = (folder / "bed.csv").read_text().splitlines()
    assert head == "X,Y,Z,r,family"
    rows = np.array([line.split(",") for line in lines], dtype=float)
    return rows[:, :3], rows[:, 3], rows[:, 4]


def read_mfix(folder):
    """As read_particle_input.f does: skipped lines, list-directed reads that pass over empty lines."""
    lines = (folder / "particle_input.dat").read_text().splitlines()
    assert lines[0][:11] == "Version 2.0"
    assert all(line.strip() for line in lines)
    assert lines[18].split() == ["Dimension:", "3"]
    count = int(lines[19].split()[1])
    options = [line.split()[:2] for line in lines[23:31]]
    width = {"Coordinates:": 3, "Velocity:": 3}
    start, columns = {}, 0
    for option, is_read in options:
        if is_read == "T":
            start[option] = columns
            columns += width.get(option, 1)
    rows = np.array([line.split() for line in lines[34:]], dtype=float)
    assert rows.shape == (count, columns)
    at = start["Coordinates:"]
    sets = rows[:, start["Phase_ID:"]] - 1
    assert np.array_equal(rows[:, start["Density:"]], np.array([2500.0, 3500.0])[sets.astype(int)])
    return rows[:, at : at + 3], rows[:, start["Diameter:"]] / 2, sets


READERS = {
    "csv": read_csv,
    "mercury": read_mercury,
    "esys": read_esys,
    "kratos": read_kratos,
    "chrono": read_chrono,
    "mfix": read_mfix,
}


@pytest.mark.parametrize("name", READERS)
def test_an_independent_reader_gets_the_spheres_back(tmp_path, name):
    bed = mixed_bed(9000)
    exporter = exporters.get(name)
    paths = exporter.write(bed, tmp_path, exporter.Options())
    assert [path.is_file() for path in paths] == [True] * len(paths)
    position, radius, sets = READERS[name](tmp_path)
    assert np.allclose(position, bed.position, rtol=1e-14, atol=0)
    assert np.allclose(radius, bed.radius, rtol=1e-14, atol=0)
    assert np.array_equal(sets, bed.set_index)


def test_geotaichi_has_a_file_for_each_set(tmp_path):
    bed = mixed_bed(500)
    exporter = exporters.get("geotaichi")
    paths = exporter.write(bed, tmp_path, exporter.Options())
    assert [path.name for path in paths] == ["bed_0.txt", "bed_1.txt"]
    for index, path in enumerate(paths):
        rows = np.loadtxt(path)
        assert np.array_equal(rows[:, :3], bed.position[bed.set_index == index])
        assert np.array_equal(rows[:, 3], bed.radius[bed.set_index == index])


@pytest.mark.parametrize("name", exporters.BUILTIN)
def test_every_format_refuses_an_empty_bed(tmp_path, name):
    exporter = exporters.get(name)
    empty = make_bed(np.zeros((0, 3)), 1.0, box_container((0, 0, 0), (1, 1, 1)))
    with pytest.raises(ExportError, match="no spheres"):
        exporter.write(empty, tmp_path, exporter.Options())
    assert list(tmp_path.iterdir()) == []
