from __future__ import annotations

import numpy as np
import pytest

from exporters import vtk
from packgen.bed import Material, ParticleSet
from packgen.errors import ExportError
from tests.beds import box_container, make_bed


def mixed_bed(count=1000):
    rng = np.random.default_rng(11)
    return make_bed(
        rng.uniform(0, 3, (count, 3)),
        rng.uniform(1e-3, 1e-1, count),
        box_container((0, 0, 0), (3, 3, 3)),
        set_index=rng.integers(0, 2, count),
        zone_index=rng.integers(0, 3, count),
        batch_index=rng.integers(0, 9, count),
        particle_sets=(ParticleSet("a", 2500.0, "coke"), ParticleSet("b", 3500.0, "ore")),
        materials=(Material("ore"), Material("coke")),
    )


def test_pyvista_reads_every_array_back_to_the_last_bit(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    bed = mixed_bed()
    vtk.write(bed, tmp_path, vtk.Options())
    mesh = pyvista.read(tmp_path / "bed.vtp")
    assert mesh.n_verts == mesh.n_cells == mesh.n_points == bed.count
    assert mesh.points.dtype == np.float64
    assert np.array_equal(mesh.points, bed.position)
    expected = {
        "radius": bed.radius,
        "diameter": 2 * bed.radius,
        "id": np.arange(bed.count) + 1,
        "type": 2 - bed.set_index,
        "set": bed.set_index,
        "zone": bed.zone_index,
        "batch": bed.batch_index,
    }
    assert set(mesh.point_data) == set(expected)
    for name, values in expected.items():
        assert np.array_equal(mesh.point_data[name], values), name
    assert mesh.point_data.active_scalars_name == "diameter"


def test_the_walls_are_a_closed_surface_of_the_containers_volume(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    vtk.write(mixed_bed(), tmp_path, vtk.Options())
    wall = pyvista.read(tmp_path / "wall.vtp")
    assert (wall.n_points, wall.n_cells, wall.n_open_edges) == (8, 12, 0)
    assert wall.volume == pytest.approx(27)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 40, 40_000])
def test_meshio_and_pyvista_read_the_unstructured_form(tmp_path, count):
    import meshio
    import pyvista

    bed = mixed_bed(count)
    assert [path.name for path in vtk.write(bed, tmp_path, vtk.Options(unstructured=True))][2] == "bed.vtu"
    mesh = meshio.read(tmp_path / "bed.vtu")
    assert np.array_equal(mesh.points, bed.position)
    for name, values in vtk.sphere_arrays(bed).items():
        assert np.array_equal(mesh.point_data[name], values)
    assert mesh.cells_dict["vertex"].shape == (bed.count, 1)
    grid = pyvista.read(tmp_path / "bed.vtu")
    assert np.array_equal(grid.points, bed.position)
    assert set(grid.celltypes) == {pyvista.CellType.VERTEX}
    for name, values in vtk.sphere_arrays(bed).items():
        assert np.array_equal(grid.point_data[name], values)


def test_an_empty_bed_is_refused(tmp_path):
    with pytest.raises(ExportError, match="no spheres"):
        vtk.write(mixed_bed(0), tmp_path, vtk.Options())
