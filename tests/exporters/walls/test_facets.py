from __future__ import annotations

import numpy as np
import pytest
import trimesh

from exporters.walls import facets as walls
from exporters.walls import slivers
from exporters.walls.stl import write_stl
from packgen.errors import ExportError
from packgen.geometry import Ball, Box, Cone, Mesh, Surface
from tests import container_meshes as meshes
from tests.beds import box_container, box_surface, make_container, revolved_surface
from tests.scenes import constant, read_scene


def read_stl(path):
    import meshio

    mesh = meshio.read(path)
    return mesh.points[mesh.cells_dict["triangle"]]


@pytest.mark.parametrize(("binary", "tolerance"), [(False, 0.0), (True, 2e-6)])
def test_stl_survives_a_round_trip(tmp_path, binary, tolerance):
    triangles = np.random.default_rng(3).uniform(-30, 30, (20, 3, 3))
    path = write_stl(tmp_path / "wall.stl", triangles, binary=binary)
    assert path.read_bytes().startswith(b"solid") is not binary
    if binary:
        assert np.allclose(read_stl(path), triangles, rtol=0, atol=tolerance)
        return
    rows = [line.split()[1:] for line in path.read_text().splitlines() if line.strip().startswith("vertex")]
    assert np.array_equal(np.array(rows, dtype=float).reshape(-1, 3, 3), triangles)


def test_smooth_angle_is_just_above_the_angle_between_facets_of_a_hollow_surface():
    drum = revolved_surface([(0, 1), (4, 1)], facets=48)  # 7.5 degrees from facet to facet, 90 at the ends
    assert 7.5 < walls.smooth_angle(drum) < 8.5


def test_smooth_angle_is_below_that_of_edges_that_protrude_into_the_container():
    waist = revolved_surface([(0, 1.2), (4, 1.0), (8, 1.2)], facets=48)  # 5.7 degrees inwards at half height
    assert walls.smooth_angle(waist) < np.degrees(2 * np.arctan(0.05))
    belly = revolved_surface([(0, 1.0), (4, 1.2), (8, 1.0)], facets=48)
    assert walls.smooth_angle(belly) > 7.5


def test_smooth_angle_is_below_that_of_a_curved_sheet_with_spheres_on_either_side(tmp_path):
    # a cyclone's finder: from outside, where spheres are as well, all its edges protrude
    pipe = trimesh.creation.cylinder(radius=0.3, height=1.0, sections=24)
    pipe.update_faces(np.abs(pipe.face_normals[:, 2]) < 0.5)
    drum = trimesh.creation.cylinder(radius=1.0, height=2.0, sections=48)
    for parts, low, high in (
        ((drum,), 7.5, 8.5),
        ((drum, pipe), 7.5, 8.5),
        ((drum, rounder(pipe)), 3.0, 3.76),
    ):
        meshes.saved(trimesh.util.concatenate(parts), tmp_path)
        _, container = read_scene(tmp_path, {"path": "vessel.stl"}, constant(0.05))
        assert low < walls.wall_facets(container).smooth_angle < high


def test_facets_of_a_sheet_exceed_the_smooth_angle_and_its_surface_stays(tmp_path):
    tank = meshes.tank(open_top=True)
    meshes.saved(tank, tmp_path)
    _, container = read_scene(tmp_path, {"path": "vessel.stl"}, constant(0.05))
    facets = walls.wall_facets(container)
    assert facets.smooth_angle > 7.5  # the drum around the baffles, as smooth as before
    flat = np.isclose(facets.triangles[:, :, 1], 0.0).all(axis=1)  # the baffles in the plane y = 0
    vertices, index = np.unique(facets.triangles.reshape(-1, 3), axis=0, return_inverse=True)
    angle = walls.smallest_angles(vertices, index.reshape(-1, 3))
    assert angle[flat].min() > 1.05 * facets.smooth_angle
    area = np.linalg.norm(np.cross(*np.diff(facets.triangles, axis=1).transpose(1, 0, 2)), axis=1).sum() / 2
    assert area == pytest.approx(tank.area, rel=1e-6)


def test_smooth_angle_is_below_the_angle_at_the_tip_of_a_slender_insert(tmp_path):
    tip = trimesh.creation.cone(radius=0.1, height=0.5, sections=60)  # facets of 1.2 degrees at the tip
    tip.apply_translation([0.0, 0.0, -0.9])
    drum = trimesh.creation.cylinder(radius=1.0, height=2.0, sections=48)
    meshes.saved(meshes.joined(drum, tip), tmp_path)
    _, container = read_scene(tmp_path, {"path": "vessel.stl"}, constant(0.05))
    assert walls.wall_facets(container).smooth_angle < 1.2


def test_a_sliver_along_a_ridge_leaves_the_drum_around_it_smooth(tmp_path):
    waist = revolved_surface([(0, 1.2), (4, 0.6), (8, 1.2)], facets=48)  # a ridge of 17 degrees half way up
    faces = waist.faces.tolist()
    at = next(k for k, face in enumerate(faces) if np.isclose(waist.vertices[face][:, 2], 4.0).sum() == 2)
    on, off = (faces[at] + faces[at])[:6], waist.vertices[faces[at]]
    turn = next(k for k in range(3) if np.isclose(off[[k, (k + 1) % 3]][:, 2], 4.0).all())
    a, b, c = on[turn : turn + 3]
    inner = 0.999 * 0.5 * (waist.vertices[a] + waist.vertices[b]) + 0.001 * waist.vertices[c]
    new = len(waist.vertices)
    faces[at : at + 1] = [[a, b, new], [b, c, new], [c, a, new]]
    surface = Surface(np.vstack([waist.vertices, inner]), np.array(faces))
    facets = walls.wall_facets(make_container(Mesh(surface), surface, 1.0))
    assert facets.smooth_angle == pytest.approx(walls.smooth_angle(waist))


def rounder(pipe):
    """The same pipe of 96 facets: flatter edges than the drum's."""
    fine = trimesh.creation.cylinder(radius=0.3, height=1.0, sections=96)
    fine.update_faces(np.abs(fine.face_normals[:, 2]) < 0.5)
    return fine


def test_facets_that_liggghts_refuses_are_left_out():
    box = box_surface((0, 0, 0), (1, 1, 1))
    vertices = np.concatenate((box.vertices, [[0.5, 0.0, 1e-4], [0.5, 0.0, 1e-2], [1, 0, 0]]))
    extra = [[0, 1, 8], [0, 0, 1], box.faces[3], box.faces[4][[1, 2, 0]], [0, 1, 9], [1, 10, 6]]
    container = make_container(Mesh(box), Surface(vertices, np.concatenate((box.faces, extra))), 1.0)
    facets = walls.wall_facets(container)
    # A sliver of 0.01 degrees, a line, two doubles and a facet of no area go; one of 1.1 degrees stays.
    assert facets.dropped == 5
    assert len(facets.triangles) == 13


def test_too_many_neighbors_are_refused():
    wheel = np.array([[0, 0, 0], [0, 0, 1], *([np.cos(a), np.sin(a), 0] for a in np.arange(7))])
    surface = Surface(wheel, np.array([[0, 1, 2 + k] for k in range(7)]))
    with pytest.raises(ExportError, match="7 facets share their edges with more than 5"):
        walls.wall_facets(make_container(Mesh(surface), surface, 1.0))


def test_periodic_sides_have_no_wall():
    container = box_container((0, 0, 0), (1, 2, 3), periodic=(True, False, False))
    facets = walls.wall_facets(container)
    assert len(facets.triangles) == 8
    assert not (np.ptp(facets.triangles[:, :, 0], axis=1) == 0).any()
    assert [wall.form.split()[0] for wall in walls.primitive_walls(container)] == ["yplane"] * 2 + [
        "zplane"
    ] * 2


def test_only_axis_parallel_boxes_and_cylinders_become_primitive_walls():
    surface = box_surface((-1, -1, -1), (1, 1, 1))

    def forms(shape):
        primitives = walls.primitive_walls(make_container(shape, surface, 1.0))
        return primitives and [wall.form for wall in primitives]

    base, z = np.array([0.1, 0.2, 0.3]), np.array([0.0, 0.0, 1.0])
    assert forms(Cone(base, -z, 2.0, 0.5, 0.5)) == ["zcylinder 0.5 0.1 0.2", "zplane -1.7", "zplane 0.3"]
    assert forms(Box(base, base + 1))[5] == "zplane 1.3"
    tilted = np.array([0.0, np.sin(1e-3), np.cos(1e-3)])
    for shape in (
        Cone(base, tilted, 2.0, 0.5, 0.5),
        Cone(base, z, 2.0, 0.5, 0.4),
        Ball(base, 1.0),
        Mesh(surface),
    ):
        assert forms(shape) is None


def closed(triangles):
    """Whether every edge belongs to two facets."""
    _, index = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    edges = np.sort(index.reshape(-1, 3)[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    return (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


def volume_of(triangles):
    return np.einsum("ij,ij->", triangles[:, 0], np.cross(triangles[:, 1], triangles[:, 2])) / 6


def narrow_tip():
    """A cone whose tip is so narrow that half the facets of its side have an angle of 0.04 degrees."""
    return revolved_surface([(0, 0.02), (1.8, 0.812)], facets=96)


def test_narrow_facets_of_a_cone_are_made_wider_and_its_surface_stays():
    surface = narrow_tip()
    facets = walls.wall_facets(make_container(Mesh(surface), surface, 1.0))
    assert facets.dropped == 0
    assert closed(facets.triangles)
    assert volume_of(facets.triangles) == pytest.approx(volume_of(surface.vertices[surface.faces]), rel=1e-9)
    vertices, index = np.unique(facets.triangles.reshape(-1, 3), axis=0, return_inverse=True)
    assert walls.smallest_angles(vertices, index.reshape(-1, 3)).min() > 2 * walls.FACET_ANGLE_MIN
    assert facets.smooth_angle > 3.4  # the facets are neighbours: one smooth wall


def test_facets_of_a_surface_without_narrow_ones_stay_as_they_are():
    surface = revolved_surface([(0, 2), (6, 5)], facets=24)
    facets = walls.wall_facets(make_container(Mesh(surface), surface, 1.0))
    assert np.array_equal(
        np.sort(facets.triangles, axis=None), np.sort(surface.vertices[surface.faces], axis=None)
    )


def test_a_flat_part_that_is_not_convex_keeps_its_facets():
    # An L with a sliver along its long side.
    outline = np.array([[0, 0], [4, 0], [4, 1], [1, 1], [1, 4], [0, 4], [2, -1e-3]], dtype=float)
    vertices = np.column_stack((outline, np.zeros(7)))
    faces = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5], [0, 6, 1]])
    narrow = walls.smallest_angles(vertices, faces) <= walls.FACET_ANGLE_MIN
    assert narrow.tolist() == [False] * 4 + [True]
    found, kept, source = slivers.widened(vertices, faces, narrow)
    assert np.array_equal(kept, faces[source])
    assert np.array_equal(np.sort(kept, axis=0), np.sort(faces, axis=0))
    assert np.array_equal(found[:7], vertices)


def lance():
    """A drum with a long, round lance in it: slender facets whose corners at its ends protrude."""
    rod = trimesh.creation.cylinder(radius=0.1, height=1.2, sections=32)
    return meshes.joined(trimesh.creation.cylinder(radius=1.0, height=2.0, sections=48), rod)


@pytest.mark.parametrize("vessel", [lance, lambda: meshes.tank(open_top=True)], ids=["lance", "tank"])
def test_dividing_what_protrudes_makes_no_facet_that_liggghts_refuses(tmp_path, vessel):
    mesh = vessel()
    meshes.saved(mesh, tmp_path)
    _, container = read_scene(tmp_path, {"path": "vessel.stl"}, constant(0.05))
    facets = walls.wall_facets(container)
    assert len(facets.triangles) > len(mesh.faces)
    assert facets.smooth_angle > 7.5  # the drum stays smooth
    vertices, index = np.unique(facets.triangles.reshape(-1, 3), axis=0, return_inverse=True)
    assert walls.clean_facets(vertices, index.reshape(-1, 3)).all()
    sides = np.diff(facets.triangles, axis=1)
    assert np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).sum() / 2 == pytest.approx(mesh.area)
