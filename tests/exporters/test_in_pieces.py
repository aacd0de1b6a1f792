"""A bed in pieces is written as the gathered bed is, byte for byte, without ever being whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import exporters
from exporters.shared import lengths
from packgen.errors import ExportError
from packgen.pieces import PieceBed, in_pieces
from tests.beds import make_container, revolved_surface
from tests.pieces.beds import shaken

STREAMED = ("liggghts", "lammps", "yade", "csv", "extxyz", "cfdem")


def tube(bed):
    """The bed in an upright cone: its walls are facets for YADE, and no primitive for LIGGGHTS."""
    from packgen.geometry import Cone

    size = 2.0 * float(bed.container.bounds[1, 0])
    surface = revolved_surface([(0.0, 0.8 * size), (size, size)], 24)
    cone = Cone(np.zeros(3), np.array([0.0, 0.0, 1.0]), size, 0.8 * size, size)
    return replace(bed, container=make_container(cone, surface, 1.0))


@pytest.fixture(autouse=True)
def _never_whole(monkeypatch):
    def whole(self):
        raise AssertionError("the bed was gathered")

    monkeypatch.setattr(PieceBed, "gathered", whole)


def written(bed, name, folder, **options):
    folder.mkdir(parents=True)
    exporter = exporters.get(name)
    paths = exporter.write(bed, folder, exporter.Options(**options))
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in paths}


@pytest.mark.parametrize("shape", ["box", "cone"])
@pytest.mark.parametrize("name", STREAMED)
def test_the_files_are_those_of_the_gathered_bed_byte_for_byte(tmp_path, name, shape):
    pieces = in_pieces(shaken() if shape == "box" else tube(shaken()), tmp_path, spheres=100)
    assert exporters.get(name).STREAMS
    found = written(pieces, name, tmp_path / "found")
    assert found == written(pieces.every(1), name, tmp_path / "wanted")
    assert all(found.values())


def test_a_mesh_that_wants_another_unit_of_length_is_written_in_it_too(tmp_path):
    small = lengths.in_unit(tube(shaken()), 1e6)
    pieces = in_pieces(small, tmp_path, spheres=100)
    found = written(pieces, "liggghts", tmp_path / "found", walls="mesh")
    assert found == written(pieces.every(1), "liggghts", tmp_path / "wanted", walls="mesh")
    assert b"1e-6" in found["in.bed"]


def test_vtk_names_a_file_a_piece_in_one_that_is_read_as_a_whole(tmp_path):
    import pyvista
    from vtkmodules.vtkIOXML import vtkXMLPPolyDataReader

    pieces = in_pieces(shaken(), tmp_path, spheres=100)
    found = written(pieces, "vtk", tmp_path / "found")
    assert set(found) > {"bed.pvtp", "bed/bed_000000.vtp", "wall.vtp"}
    reader = vtkXMLPPolyDataReader()
    reader.SetFileName(str(tmp_path / "found" / "bed.pvtp"))
    reader.Update()
    written(pieces.every(1), "vtk", tmp_path / "wanted")
    one, other = pyvista.wrap(reader.GetOutput()), pyvista.read(tmp_path / "wanted" / "bed.vtp")
    assert one.n_verts == other.n_verts
    assert np.array_equal(one.points, other.points)
    assert set(one.point_data) == set(other.point_data)
    for name in one.point_data:
        assert np.array_equal(one.point_data[name], other.point_data[name]), name
        assert one.point_data[name].dtype == other.point_data[name].dtype


def test_vtk_refuses_the_file_that_cannot_be_in_pieces(tmp_path):
    pieces = in_pieces(shaken(), tmp_path, spheres=100)
    with pytest.raises(ExportError, match=r"leave vtk\.unstructured out"):
        written(pieces, "vtk", tmp_path / "found", unstructured=True)


def test_a_sphere_that_is_no_number_is_named_by_its_number_in_the_whole_bed(tmp_path):
    bed = shaken()
    radius = bed.radius.copy()
    radius[-1] = -1.0
    pieces = in_pieces(replace(bed, radius=radius), tmp_path, spheres=100)
    place = int(np.flatnonzero(pieces.every(1).radius < 0.0)[0])
    with pytest.raises(ExportError, match=f"radius of sphere {place + 1} is -1.0 m"):
        written(pieces, "csv", tmp_path / "found")


def test_formats_that_do_not_say_so_take_no_bed_in_pieces(monkeypatch):
    from importlib.metadata import EntryPoint

    assert not exporters.get("mfix").STREAMS
    point = EntryPoint("heights", "tests.plugin.packgen_heights", exporters.ENTRY_POINT_GROUP)
    monkeypatch.setattr(exporters, "entry_points", lambda group: [point])
    assert not exporters.get("heights").STREAMS
