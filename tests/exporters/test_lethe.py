"""Lethe's insertion files, read back by a reader written from its documentation."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exporters import lethe
from packgen.errors import ExportError
from packgen.reading import read_spheres
from tests.exporters.test_vtk import mixed_bed


def read_insertion(path):
    """Columns by name: words between semicolons, an empty one at a line's end is none."""
    head, *lines = ([word.strip() for word in line.split(";")] for line in path.read_text().splitlines())
    names = [name for name in head if name]
    rows = np.array([[float(word) for word in line if word] for line in lines])
    return dict(zip(names, rows.T, strict=True))


def read_parameters(path):
    """The values of a parameter file by the path of their subsections."""
    found, inside = {}, []
    for line in path.read_text().splitlines():
        words = line.split("#")[0].split()
        if words[:1] == ["subsection"]:
            inside.append(" ".join(words[1:]))
        elif words[:1] == ["end"]:
            inside.pop()
        elif words[:1] == ["set"]:
            key, _, value = line.strip().removeprefix("set ").partition("=")
            found["/".join([*inside, key.strip()])] = value.strip()
    assert inside == []
    return found


def test_an_independent_reader_gets_each_set_back(tmp_path):
    bed = mixed_bed()
    paths = lethe.write(bed, tmp_path, lethe.Options())
    assert [path.name for path in paths] == ["particles_0.input", "particles_1.input", "bed.prm"]
    for index, path in enumerate(paths[:2]):
        columns = read_insertion(path)
        chosen = bed.set_index == index
        assert np.array_equal(
            np.stack([columns[f"p_{axis}"] for axis in "xyz"], axis=1), bed.position[chosen]
        )
        assert np.array_equal(columns["diameters"], 2 * bed.radius[chosen])
        still = [name for name in columns if name[:2] in ("v_", "w_") or name.startswith("fem_")]
        assert len(still) == 12
        assert not any(columns[name].any() for name in still)


def test_the_parameters_are_those_of_the_scene(tmp_path):
    bed = mixed_bed()
    lethe.write(bed, tmp_path, lethe.Options())
    values = read_parameters(tmp_path / "bed.prm")
    assert values["insertion info/insertion method"] == "file"
    assert values["insertion info/list of input files"] == "particles_0.input, particles_1.input"
    properties = "lagrangian physical properties"
    assert values[f"{properties}/number of particle types"] == "2"
    for index in range(2):
        kind = f"{properties}/particle type {index}"
        chosen = bed.set_index == index
        assert int(values[f"{kind}/number of particles"]) == chosen.sum()
        assert float(values[f"{kind}/density particles"]) == bed.particle_sets[index].density
        assert float(values[f"{kind}/diameter"]) == 2 * bed.radius[chosen].max()
        assert float(values[f"{kind}/friction coefficient particles"]) == 0.5
    assert float(values[f"{properties}/young modulus wall"]) == 1e8
    assert float(values[f"{properties}/gz"]) == -9.81


def test_a_set_without_spheres_is_no_type_and_temperatures_are_a_column(tmp_path):
    bed = mixed_bed(50)
    bed = replace(bed, set_index=np.ones(50, np.int32))
    paths = lethe.write(bed, tmp_path, lethe.Options(temperature="293"))
    assert [path.name for path in paths] == ["particles_0.input", "bed.prm"]
    assert set(read_insertion(paths[0])["T"]) == {293.0}
    assert read_spheres(paths[0]).count == 50


def test_what_lethe_needs_and_nobody_says_is_asked_for(tmp_path):
    bed = replace(mixed_bed(5), materials=())
    with pytest.raises(ExportError, match="lethe: the materials are not known"):
        lethe.write(bed, tmp_path, lethe.Options())
