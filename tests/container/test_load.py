"""Containers and locations as scenes name them: the forms of files, units, openings, and what is refused."""

from __future__ import annotations

import math

import meshio
import numpy as np
import pytest
import trimesh
import yaml

from packgen.container import load_container, load_location
from packgen.errors import GeometryError, SceneError
from packgen.geometry import Ball, Box, Cone, Polyhedron, Slice
from packgen.scene import load_scene
from tests.scenes import box, constant, read_scene

WEDGE_VOLUME = 3.0


def wedge():
    """A convex body without symmetry: a box of 1 x 2 x 2 with its top pulled to one side, closed."""
    mesh = trimesh.creation.box([1.0, 2.0, 2.0])
    mesh.apply_translation([0.5, 1.0, 1.0])
    vertices = mesh.vertices.copy()
    vertices[(vertices[:, 0] > 0.5) & (vertices[:, 2] > 1.0), 0] = 0.5
    return trimesh.Trimesh(vertices, mesh.faces, process=False)


def opened(mesh, direction=(0, 0, 1)):
    """A mesh without the facets whose normal points along a direction."""
    keep = mesh.face_normals @ np.array(direction, float) < 0.999
    return trimesh.Trimesh(mesh.vertices, mesh.faces[keep], process=False)


def load(folder, path, warnings=None, **keys):
    container = {"path": path} | {key: keys.pop(key) for key in ("units", "shape") if key in keys}
    text = yaml.safe_dump({"container": container, "particle_sets": [constant(0.05)]} | keys)
    (folder / "scene.yaml").write_text(text, encoding="utf-8")
    said = [] if warnings is None else warnings
    return load_container(load_scene(folder / "scene.yaml"), said.append)


def write(folder, mesh, name):
    """Write a mesh in the form that its ending, or the part before it, asks for."""
    path = folder / name
    if name.endswith(".ascii.stl"):
        path.write_text(trimesh.exchange.stl.export_stl_ascii(mesh))
    elif path.suffix in {".vtk", ".vtu", ".msh"}:
        meshio.Mesh(mesh.vertices, [("triangle", mesh.faces)]).write(path)
    else:
        mesh.export(path)
    return name


@pytest.mark.parametrize(
    "name", ["a.stl", "a.ascii.stl", "a.STL", "a.ply", "a.obj", "a.off", "a.vtk", "a.vtu"]
)
def test_every_form_of_file_gives_the_same_vessel(tmp_path, name):
    warnings = []
    vessel = load(tmp_path, write(tmp_path, wedge(), name), warnings)
    assert isinstance(vessel.shape, Polyhedron)
    assert vessel.name == name.rpartition(".")[0]
    assert vessel.volume == pytest.approx(WEDGE_VOLUME, rel=1e-6)
    assert vessel.bounds == pytest.approx(np.array([[0, 0, 0], [1, 2, 2]]), abs=1e-6)
    assert len(vessel.shape.normal) == 6
    assert warnings == []


@pytest.mark.parametrize(
    ("units", "metres"), [("mm", 1e-3), ("cm", 1e-2), ("um", 1e-6), ("in", 0.0254), ("ft", 0.3048)]
)
def test_units_scale_the_vessel(tmp_path, units, metres):
    vessel = load(tmp_path, write(tmp_path, wedge(), "a.stl"), units=units)
    assert vessel.volume == pytest.approx(WEDGE_VOLUME * metres**3, rel=1e-6)
    assert vessel.bounds[1] == pytest.approx(np.array([1, 2, 2]) * metres, rel=1e-6)


def test_of_a_volume_mesh_the_boundary_is_taken(tmp_path):
    points = np.array([[x, y, z] for z in (0, 1, 2) for y in (0, 1) for x in (0, 1)], float)
    cells = [("hexahedron", [[0, 1, 3, 2, 4, 5, 7, 6], [4, 5, 7, 6, 8, 9, 11, 10]])]
    meshio.Mesh(points, cells).write(tmp_path / "bricks.vtu")
    vessel = load(tmp_path, "bricks.vtu")
    assert vessel.volume == pytest.approx(2.0)
    assert len(vessel.surface.faces) == 20  # ten outer squares, none between the bricks


@pytest.mark.parametrize("gravity_axis", ["z", "-x"])
def test_a_vessel_open_at_its_top_is_filled_to_its_rim(tmp_path, gravity_axis):
    up = {"z": (0, 0, 1), "-x": (-1, 0, 0)}[gravity_axis]
    cube = trimesh.creation.box([1, 1, 1])
    vessel = load(tmp_path, write(tmp_path, opened(cube, up), "a.stl"), gravity_axis=gravity_axis)
    assert vessel.volume == pytest.approx(1.0)
    assert len(vessel.surface.faces) == 10
    assert len(vessel.shape.normal) == 6


@pytest.mark.parametrize("direction", [(0, 0, -1), (1, 0, 0)], ids=["below", "beside"])
def test_a_hole_that_is_not_the_top_is_refused_with_its_place(tmp_path, direction):
    name = write(tmp_path, opened(trimesh.creation.box([1, 1, 1]), direction), "holed.stl")
    with pytest.raises(GeometryError, match=r"scene\.yaml:2:9: holed\.stl has holes .*x=.*expected a closed"):
        load(tmp_path, name)


def test_a_hull_ignores_holes_and_dents(tmp_path):
    torn = wedge()
    torn.faces = torn.faces[:-3]
    vessel = load(tmp_path, write(tmp_path, torn, "torn.stl"), shape="convex_hull")
    assert vessel.volume == pytest.approx(WEDGE_VOLUME, rel=1e-6)


def test_faults_that_can_be_mended_are_mended_and_told(tmp_path):
    mesh = wedge()
    extra = [[0, 0, 1], mesh.faces[3], mesh.faces[3][::-1]]
    faces = np.concatenate([mesh.faces, extra])
    faces[5] = faces[5][::-1]
    trimesh.Trimesh(mesh.vertices, faces, process=False).export(tmp_path / "poor.obj")
    warnings = []
    vessel = load(tmp_path, "poor.obj", warnings)
    assert vessel.volume == pytest.approx(WEDGE_VOLUME)
    told = " ".join(warnings)
    assert "1 degenerate facets" in told
    assert "2 repeated facets" in told
    assert "1 facets turned" in told


def test_a_mesh_turned_inside_out_is_turned_back(tmp_path):
    mesh = wedge()
    mesh.invert()
    surface = load(tmp_path, write(tmp_path, mesh, "out.stl")).surface
    corners = surface.vertices[surface.faces]
    volume = np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6.0
    assert volume == pytest.approx(WEDGE_VOLUME, rel=1e-6)


def test_a_file_cut_short_is_refused(tmp_path):
    whole = write(tmp_path, trimesh.creation.icosphere(subdivisions=2), "a.stl")
    data = (tmp_path / whole).read_bytes()
    for length in (0, 10, 83, 90, len(data) // 2, len(data) - 1):
        (tmp_path / "cut.stl").write_bytes(data[:length])
        with pytest.raises(GeometryError, match=r"scene\.yaml:2:9: cut\.stl .*complete"):
            load(tmp_path, "cut.stl")


@pytest.mark.parametrize(
    ("name", "content"),
    [
        (
            "words.stl",
            b"once upon a time there was a furnace, and it was made of words, not of triangles " * 3,
        ),
        ("words.obj", b"once upon a time"),
        ("words.ply", b"ply\nformat ascii 1.0\nonce"),
        ("words.vtu", b"<VTKFile"),
        ("words.msh", b"$MeshFormat\n"),
        ("words.xyz", b"1 2 3"),
        ("empty.off", b""),
        ("nan.obj", b"v 0 0 0\nv nan 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 3 4\n"),
    ],
)
def test_rubbish_is_refused_with_the_files_name(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(GeometryError, match=rf"scene\.yaml:2:9: {name}"):
        load(tmp_path, name)


def test_a_flat_mesh_is_refused(tmp_path):
    square = trimesh.Trimesh(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], [[0, 1, 2], [0, 2, 3]], process=False
    )
    with pytest.raises(GeometryError, match=r"scene\.yaml:2:9: .*flat"):
        load(tmp_path, write(tmp_path, square, "square.stl"))


@pytest.mark.parametrize("name", ["gone.stl", "folder.stl"])
def test_a_missing_file_or_a_folder_is_refused_by_its_name(tmp_path, name):
    (tmp_path / "folder.stl").mkdir()
    with pytest.raises((GeometryError, SceneError), match=rf"scene\.yaml:2:9: .*{name}.*expected"):
        load(tmp_path, name)


def test_primitives_are_kept_as_they_are(tmp_path):
    def shape_of(container):
        return read_scene(tmp_path, container, constant(0.05))[1]

    cube = shape_of(box([0, 0, 0], [1, 2, 3]))
    assert isinstance(cube.shape, Box)
    assert cube.volume == pytest.approx(6.0)
    tube = shape_of({"cylinder": {"radius": 0.5, "height": 4.0, "base": [1, 0, 0], "axis": "x"}})
    assert isinstance(tube.shape, Cone)
    assert tube.volume == pytest.approx(math.pi)
    assert tube.bounds == pytest.approx(np.array([[1, -0.5, -0.5], [5, 0.5, 0.5]]))
    cone = shape_of({"cone": {"radius_bottom": 0.2, "radius_top": 1.0, "height": 3.0}})
    assert cone.volume == pytest.approx(math.pi * (0.04 + 0.2 + 1.0))
    assert cone.bounds == pytest.approx(np.array([[-1, -1, 0], [1, 1, 3]]))
    ball = shape_of({"sphere": {"radius": 1.0, "center": [0, 0, 7]}})
    assert isinstance(ball.shape, Ball)
    assert ball.volume == pytest.approx(4.0 / 3.0 * math.pi)
    assert ball.bounds == pytest.approx(np.array([[-1, -1, 6], [1, 1, 8]]))


def test_a_slice_bounds_centres_across_gravity_and_spheres_beside_it(tmp_path):
    def location(axis, gravity_axis):
        zones = [{"location": {"slice": {"axis": axis, "min_bound": 0.2, "max_bound": 0.6}}}]
        keys = {"zones": zones, "gravity_axis": gravity_axis}
        scene, _ = read_scene(tmp_path, box([0] * 3, [1] * 3), constant(0.05), **keys)
        return load_location(scene.zones[0].location, scene, "zones[0].location")

    across, beside = location("z", "-z"), location("x", "z")
    assert isinstance(across, Slice)
    assert (across.low, across.high) == (0.2, 0.6)
    assert across.centers_only
    assert not beside.centers_only
    assert not location("z", [1, 0, 1]).centers_only


def test_bytes_after_an_stls_triangles_are_ignored_and_a_cut_text_is_reported(tmp_path):
    mesh = trimesh.creation.icosphere(subdivisions=2)
    data = (tmp_path / write(tmp_path, mesh, "a.stl")).read_bytes()
    (tmp_path / "longer.stl").write_bytes(data + 500 * b"\0")
    assert load(tmp_path, "longer.stl").volume == pytest.approx(mesh.volume, rel=1e-6)
    text = (tmp_path / write(tmp_path, mesh, "b.ascii.stl")).read_text()
    (tmp_path / "cut.stl").write_text(text[: text.index("facet", len(text) // 2)])
    with pytest.raises(GeometryError, match="cut short: its text does not end with endsolid"):
        load(tmp_path, "cut.stl")


def test_polygons_are_triangulated_and_curved_cells_refused(tmp_path):
    cube = trimesh.creation.box([1, 1, 1])
    corners = np.array(
        [[x, y, z] for z in (0, 1) for x, y in ((0, 0), (2, 0), (3, 1), (1, 2), (-1, 1))], float
    )
    around = range(5)
    sides = [[k, (k + 1) % 5, 5 + (k + 1) % 5, 5 + k] for k in around]
    cells = [("quad", sides), ("polygon", [[4, 3, 2, 1, 0], [5, 6, 7, 8, 9]])]
    meshio.Mesh(corners, cells).write(tmp_path / "prism.vtu")
    base = 0.5 * sum(
        corners[k, 0] * corners[(k + 1) % 5, 1] - corners[(k + 1) % 5, 0] * corners[k, 1] for k in around
    )
    assert load(tmp_path, "prism.vtu").volume == pytest.approx(base)
    curved = [("triangle", cube.faces), ("triangle6", [[0, 1, 2, 3, 4, 5]])]
    meshio.Mesh(cube.vertices, curved).write(tmp_path / "curved.vtu")
    with pytest.raises(GeometryError, match="it holds triangle6, expected triangles"):
        load(tmp_path, "curved.vtu")


def test_a_file_too_large_for_any_wall_is_refused_unread(tmp_path):
    with (tmp_path / "huge.ply").open("wb") as file:
        file.truncate(1_000_000_000)
    with pytest.raises(GeometryError, match=r"huge\.ply has 1,000 MB, expected at most 500 MB"):
        load(tmp_path, "huge.ply")


def test_libraries_say_nothing_on_the_screen(tmp_path, capfd):
    (tmp_path / "words.vtu").write_text("<VTKFile")
    with pytest.raises(GeometryError, match=r"words\.vtu"):
        load(tmp_path, "words.vtu")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("length", [0.22, 2.0])
def test_a_tube_across_a_vessel_is_solid_however_long_it_is(tmp_path, length):
    vessel = trimesh.creation.cylinder(radius=0.1, height=0.3)
    tube = trimesh.creation.cylinder(radius=0.03, height=length)
    tube.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
    trimesh.util.concatenate(vessel, tube).export(tmp_path / "tube.stl")
    said = []
    container = load(tmp_path, "tube.stl", said)
    assert "crosses a larger one and counts as a solid body" in said[0]
    assert container.volume == pytest.approx(np.pi * (0.1**2 * 0.3 - 0.03**2 * 0.19), rel=0.1)


def test_a_mesh_without_any_area_is_refused_with_its_place_and_name(tmp_path):
    (tmp_path / "flat.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n2 0 0\n3 0 1 2\n")
    with pytest.raises(GeometryError, match=r"scene\.yaml:\d+:\d+: .*flat\.off: found no facet with an area"):
        read_scene(tmp_path, {"path": "flat.off"}, constant(0.1))
