from __future__ import annotations

import json
import os
import re
import shutil
import subprocess

import numpy as np
import pytest

from exporters import fraction
from packgen.errors import ExportError
from tests.beds import box_container, make_bed

SOLID = 4 / 3 * np.pi


def bed_of(count=200, periodic=(False, False, False)):
    rng = np.random.default_rng(8)
    radius = rng.uniform(0.1, 0.3, count)
    edge = 0.0 if all(periodic) else 0.3
    return make_bed(
        rng.uniform(edge, 3 - edge, (count, 3)), radius, box_container((0, 0, 0), (3, 3, 3), periodic)
    )


def write(bed, folder, **options):
    paths = fraction.write(bed, folder, fraction.Options(**options))
    assert all(path.is_file() for path in paths)
    return json.loads((folder / "fraction.json").read_text())


def foam_values(folder):
    text = (folder / "0" / "voidfraction").read_text()
    count, values = re.search(r"List<scalar>\n(\d+)\n\((.*?)\)", text, re.DOTALL).groups()
    numbers = np.array(values.split(), dtype=float)
    assert len(numbers) == int(count)
    return numbers


@pytest.mark.parametrize("cell_size", [0.2, 0.75, 5.0])
@pytest.mark.parametrize("periodic", [(False,) * 3, (True,) * 3], ids=["walls", "periodic"])
def test_the_sum_over_the_cells_is_the_volume_of_the_spheres(tmp_path, cell_size, periodic):
    bed = bed_of(periodic=periodic)
    sums = write(bed, tmp_path, cell_size=cell_size)
    assert sums["spheres_volume"] == pytest.approx(SOLID * (bed.radius**3).sum(), rel=1e-12)
    assert sums["share_in_cells"] == pytest.approx(1, abs=1e-9)


def test_a_cell_holds_what_counting_points_finds(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    bed = bed_of(60)
    write(bed, tmp_path, cell_size=1.0)
    image = pyvista.read(tmp_path / "fraction.vti")
    assert image.dimensions == (4, 4, 4)
    solid = image.cell_data["solid_fraction"].reshape(3, 3, 3, order="F")
    assert np.allclose(image.cell_data["void_fraction"], 1 - image.cell_data["solid_fraction"])
    # Overlapping spheres count twice in both, points of each sphere alone.
    points = np.random.default_rng(0).uniform(0, 1, (20000, 3)) + np.array([1, 0, 2])
    inside = sum(
        (((points - x) ** 2).sum(axis=1) < r * r).mean()
        for x, r in zip(bed.position, bed.radius, strict=True)
    )
    assert solid[1, 0, 2] == pytest.approx(inside, abs=0.015)


def test_the_foam_field_is_in_the_order_of_block_mesh(tmp_path):
    bed = make_bed([[2.5, 0.5, 0.5]], 0.4, box_container((0, 0, 0), (3, 2, 1)))
    write(bed, tmp_path, cell_size=1.0)
    values = foam_values(tmp_path)
    assert len(values) == 6
    assert np.flatnonzero(values < 1).tolist() == [2]  # x counts first
    assert values[2] == pytest.approx(1 - SOLID * 0.4**3)
    mesh = (tmp_path / "system" / "blockMeshDict").read_text()
    assert "hex (0 1 2 3 4 5 6 7) (3 2 1)" in mesh
    corners = [
        tuple(map(float, line.strip(" ()").split())) for line in mesh.splitlines() if line.startswith("    (")
    ]
    assert corners == [(0, 0, 0), (3, 0, 0), (3, 2, 0), (0, 2, 0), (0, 0, 1), (3, 0, 1), (3, 2, 1), (0, 2, 1)]


def foam(folder, *command):
    environment = {"WM_PROJECT_DIR": "/usr/share/openfoam", **os.environ}
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, env=environment, timeout=60, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


def write_foam_case(folder):
    """The rest of what OpenFOAM's tools ask of a case."""
    (folder / "system" / "controlDict").write_text(
        "FoamFile { version 2.0; format ascii; class dictionary; object controlDict; }\n"
        "application none; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1;\n"
        "writeControl timeStep; writeInterval 1;\n"
    )
    schemes = (
        "ddtSchemes{} gradSchemes{} divSchemes{} laplacianSchemes{} interpolationSchemes{} snGradSchemes{}"
    )
    for name, content in (("fvSchemes", schemes), ("fvSolution", "")):
        (folder / "system" / name).write_text(
            f"FoamFile {{ version 2.0; format ascii; class dictionary; object {name}; }}\n{content}\n"
        )


needs_foam = pytest.mark.skipif(shutil.which("foamToVTK") is None, reason="OpenFOAM is not installed")


@pytest.mark.solver
@needs_foam
def test_the_sides_of_a_periodic_box_are_cyclic_for_openfoam(tmp_path):
    box = box_container((0, 0, 0), (1, 1, 2), periodic=(True, True, False))
    write(make_bed([[0.05, 0.5, 0.3], [0.5, 0.98, 1.5]], 0.2, box), tmp_path, cell_size=0.25)
    write_foam_case(tmp_path)
    patches = foam(tmp_path, "blockMesh")
    assert [f"name: {axis}_{end}" in patches for axis in "xyz" for end in ("low", "high")] == 4 * [
        True
    ] + 2 * [False]
    assert "Mesh OK" in foam(tmp_path, "checkMesh")
    assert "Wrote" in foam(tmp_path, "foamToVTK", "-time", "0")


@pytest.mark.solver
@needs_foam
def test_openfoam_reads_the_field_on_the_grid_and_on_a_mesh_of_its_own(tmp_path):
    pyvista = pytest.importorskip("pyvista")
    bed = bed_of(100)
    write(bed, tmp_path, cell_size=0.5)
    write_foam_case(tmp_path)
    assert "[ 0 0 0 0 0 0 0 ]" in foam(tmp_path, "foamDictionary", "-entry", "dimensions", "0/voidfraction")
    assert "nCells: 216" in foam(tmp_path, "blockMesh")
    assert "Mesh OK" in foam(tmp_path, "checkMesh")
    foam(tmp_path, "foamToVTK", "-time", "0")
    mesh = next((tmp_path / "VTK").glob("*/internal.vtu"))
    seen, image = pyvista.read(mesh), pyvista.read(tmp_path / "fraction.vti")
    assert np.allclose(seen.cell_centers().points, image.cell_centers().points, atol=1e-6)
    assert np.allclose(seen.cell_data["voidfraction"], image.cell_data["void_fraction"], atol=1e-6)
    # And back: the mesh as OpenFOAM sees it gives the same field, in the order of its cells.
    (tmp_path / "again").mkdir()
    write(bed, tmp_path / "again", mesh=mesh)
    assert np.allclose(foam_values(tmp_path / "again"), foam_values(tmp_path), atol=1e-5)


def mesh_of(kind):
    """The box of three metres in hexahedra, each split where the kind asks for it; some are inside out."""
    nodes = np.linspace(0, 3, 5)
    grid = np.stack(np.meshgrid(nodes, nodes, nodes, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(125).reshape(5, 5, 5)
    low = number[:4, :4, :4].ravel()
    hexahedra = low[:, None] + np.array([0, 25, 30, 5, 1, 26, 31, 6])
    if kind == "hexahedron":
        hexahedra[::3] = hexahedra[::3][:, [4, 5, 6, 7, 0, 1, 2, 3]]
        return grid, {kind: hexahedra}
    wedges = np.concatenate((hexahedra[:, [0, 1, 2, 4, 5, 6]], hexahedra[:, [0, 2, 3, 4, 6, 7]]))
    if kind == "wedge":
        return grid, {kind: wedges}
    tetrahedra = np.concatenate(
        [wedges[:, list(each)] for each in ((0, 1, 2, 5), (0, 1, 5, 4), (0, 4, 5, 3))]
    )
    tetrahedra[::2] = tetrahedra[::2][:, [0, 2, 1, 3]]
    if kind == "tetra":
        return grid, {kind: tetrahedra}
    return grid, {
        "wedge": wedges[:64],
        "tetra": tetrahedra[[each for start in (64, 192, 320) for each in range(start, start + 64)]],
    }


@pytest.mark.parametrize("kind", ["hexahedron", "wedge", "tetra", "mixed"])
def test_on_a_users_mesh_the_sum_is_the_volume_of_the_spheres_too(tmp_path, kind):
    import meshio

    points, blocks = mesh_of(kind)
    meshio.Mesh(points * 1000, list(blocks.items())).write(tmp_path / "mesh.vtu")
    (tmp_path / "out").mkdir()
    bed = bed_of(80)
    sums = write(bed, tmp_path / "out", mesh=tmp_path / "mesh.vtu", scale=1e-3)
    assert sums["share_in_cells"] == pytest.approx(1, abs=1e-9)
    read = meshio.read(tmp_path / "out" / "fraction.vtu")
    assert np.allclose(read.points, points)
    solid = np.concatenate(read.cell_data["solid_fraction"])
    assert np.allclose(foam_values(tmp_path / "out"), 1 - solid, rtol=1e-12, atol=1e-12)
    assert solid.min() >= 0


def test_the_field_is_in_the_order_of_a_mesh_whose_kinds_of_cells_take_turns(tmp_path):
    import meshio

    points, blocks = mesh_of("wedge")
    wedges = blocks["wedge"]
    tetrahedra = mesh_of("tetra")[1]["tetra"]
    # The first wedge, tetrahedra of the second one's place, the rest.
    parts = [("wedge", wedges[:1]), ("tetra", tetrahedra[[1, 129, 257]]), ("wedge", wedges[2:])]
    meshio.Mesh(points, parts).write(tmp_path / "mesh.vtu")
    (tmp_path / "out").mkdir()
    target = points[wedges[5]].mean(axis=0)
    bed = make_bed([target], 0.05, box_container((0, 0, 0), (3, 3, 3)))
    write(bed, tmp_path / "out", mesh=tmp_path / "mesh.vtu")
    assert np.flatnonzero(foam_values(tmp_path / "out") < 1).tolist() == [1 + 3 + 3]


def test_a_mesh_that_cannot_serve_is_refused(tmp_path):
    import meshio

    points = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]], dtype=float)
    meshio.Mesh(points, [("pyramid", [[0, 1, 2, 3, 4]])]).write(tmp_path / "pyramid.vtu")
    with pytest.raises(ExportError, match="has pyramid, expected hexahedron, wedge, tetra"):
        write(bed_of(5), tmp_path, mesh=tmp_path / "pyramid.vtu")
    flat = points[[0, 1, 2, 3]]
    meshio.Mesh(flat, [("tetra", [[0, 1, 2, 3]])]).write(tmp_path / "flat.vtu")
    with pytest.raises(ExportError, match="tetra 0 has no volume, the only one; mend the mesh"):
        write(bed_of(5), tmp_path, mesh=tmp_path / "flat.vtu")
    (tmp_path / "none.unknown").write_text("?")
    (tmp_path / "none.vtu").write_text("?")
    for name in ("none.vtu", "none.unknown"):
        with pytest.raises(ExportError, match=name):
            write(bed_of(5), tmp_path, mesh=tmp_path / name)
    with pytest.raises(ExportError, match="enlarge cell_size"):
        write(bed_of(5), tmp_path, cell_size=1e-3)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"mesh": "nowhere.vtu"}, "mesh"),
        ({"scale": 2.0}, "give mesh=FILE"),
        ({"cell_size": float("inf")}, "cell_size"),
        ({"cell_size": 0.1, "mesh": __file__}, "leave one of them out"),
    ],
)
def test_options_that_make_no_sense_are_refused_before_a_run(options, said):
    with pytest.raises(ValueError, match=said):
        fraction.Options(**options)


def test_a_mesh_that_is_not_the_beds_is_refused(tmp_path):
    import meshio

    points, blocks = mesh_of("hexahedron")
    meshio.Mesh(points + 50, list(blocks.items())).write(tmp_path / "away.vtu")
    with pytest.raises(ExportError, match=r"no sphere is in it: it goes from \[50. 50. 50.\] to"):
        write(bed_of(5), tmp_path, mesh=tmp_path / "away.vtu")
    twice = np.concatenate([blocks["hexahedron"], blocks["hexahedron"]])
    meshio.Mesh(points, [("hexahedron", twice)]).write(tmp_path / "twice.vtu")
    with pytest.raises(ExportError, match="hold 2 times the spheres' volume"):
        write(bed_of(5), tmp_path, mesh=tmp_path / "twice.vtu")


def test_a_cell_inside_a_sphere_has_no_void(tmp_path):
    bed = make_bed([[1.5, 1.5, 1.5]], 1.4, box_container((0, 0, 0), (3, 3, 3)))
    write(bed, tmp_path, cell_size=0.2)
    void = foam_values(tmp_path)
    assert void.min() == 0.0
    assert (void == 0.0).sum() > 500
