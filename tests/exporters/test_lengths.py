"""Decks of vessels whose meshes LIGGGHTS does not take in metres."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exporters import cfdem, liggghts
from exporters.shared import lengths
from packgen.bed import Bed
from packgen.errors import ExportError
from packgen.geometry import Mesh
from tests.exporters.beds import read_data_file
from tests.exporters.test_liggghts import needs_liggghts, run
from tests.validation.beds import bed_in


def shrunk(bed: Bed, factor: float) -> Bed:
    """The bed with lengths and moduli times a factor: as soft under the same gravity as the first."""
    small = replace(lengths.in_unit(bed, 1 / factor), gravity=bed.gravity)
    softer = tuple(replace(each, youngs_modulus=factor * each.youngs_modulus) for each in bed.materials)
    return replace(small, materials=softer)


def write(bed, folder, **options):
    liggghts.write(bed, folder, liggghts.Options(**options))
    return (folder / "in.bed").read_text(encoding="ascii")


@pytest.mark.parametrize(("factor", "unit"), [(1e-7, 1e-9), (1e-6, 1e-6), (1e-5, 1e-6), (1e8, 1e6)])
def test_a_mesh_out_of_the_solvers_range_spans_1_to_1000_in_the_decks_unit(tmp_path, factor, unit):
    bed = shrunk(bed_in("mesh"), factor)
    text = write(bed, tmp_path)
    assert f"variable length_unit index 1e{round(np.log10(unit))}\n" in text
    header, rows = read_data_file(tmp_path / "bed.data")
    assert rows[:, 2] * unit == pytest.approx(2 * bed.radius, rel=1e-14)
    assert rows[:, 3] == pytest.approx(bed.density)
    assert rows[:, 4:] * unit == pytest.approx(bed.position, rel=1e-14)
    assert header["zlo zhi"][1] * unit > bed.container.bounds[1, 2]
    vertices = np.array(
        [line.split()[1:] for line in (tmp_path / "wall.stl").read_text().splitlines() if "vertex" in line],
        dtype=float,
    )
    assert 1 <= np.ptp(vertices, axis=0).max() < 1000
    gravity = float(text.split("fix gravity all gravity ")[1].split()[0])
    assert gravity == pytest.approx(np.linalg.norm(bed.gravity) * unit)
    small = {line.split()[1]: line.split()[-1] for line in text.splitlines() if "property/global" in line}
    assert float(small["youngs_modulus"]) == bed.materials[-1].youngs_modulus


@pytest.mark.parametrize("factor", [1e-3, 1.0, 1e4])
def test_a_mesh_that_the_solver_takes_is_written_in_metres(tmp_path, factor):
    text = write(shrunk(bed_in("mesh"), factor), tmp_path)
    assert "length_unit" not in text
    assert "SI units" in text


def test_primitive_walls_are_written_in_metres_whatever_their_size(tmp_path):
    small = shrunk(bed_in("box"), 1e-7)
    assert "length_unit" not in write(small, tmp_path)
    assert "length_unit" in write(small, tmp_path, walls="mesh")


def test_a_coupled_case_in_another_unit_is_refused_with_a_remedy(tmp_path):
    with pytest.raises(ExportError, match=r"found a container of 8e-06 m, expected 0.001 to 1e\+06 m.*scale"):
        cfdem.write(shrunk(bed_in("mesh"), 1e-6), tmp_path, cfdem.Options())
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", ["box", "ball", "cylinder", "drum", "mesh", "cone", "hopper"])
def test_every_shape_shrinks_as_its_surface_does(kind):
    bed = bed_in(kind)
    there = lengths.in_unit(lengths.in_unit(bed, 1e-6), 1e6)
    assert lengths.in_unit(bed, 1.0) is bed
    assert there.container.bounds == pytest.approx(bed.container.bounds)
    assert there.container.volume == pytest.approx(bed.container.volume)
    for name in bed.container.shape.__slots__:
        before, after = getattr(bed.container.shape, name), getattr(there.container.shape, name)
        if name == "surface":
            before, after = before.vertices, after.vertices
        assert after == pytest.approx(before)


@pytest.mark.solver
@needs_liggghts
@pytest.mark.parametrize("factor", [1e-7, 1e-5, 1e9])
def test_liggghts_runs_a_vessel_of_any_size(tmp_path, factor):
    bed = shrunk(bed_in("mesh"), factor)
    assert isinstance(bed.container.shape, Mesh)
    write(bed, tmp_path, steps=20)
    assert "Loop time" in run(tmp_path)
