"""What is said of meshes that are no vessel, or not the one that was meant."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from packgen.container import load_container
from packgen.errors import GeometryError
from packgen.scene import load_scene
from tests import container_meshes as meshes


def loaded(folder, mesh):
    """The container of a mesh, and what was said of it."""
    (folder / "scene.yaml").write_text(
        f"container: {{path: {meshes.saved(mesh, folder)}}}\n"
        "particle_sets: [{radius_distribution: constant, radius: 0.1}]\n"
    )
    told = []
    return load_container(load_scene(folder / "scene.yaml"), told.append), told


def refusal(folder, mesh):
    with pytest.raises(GeometryError) as refused:
        loaded(folder, mesh)
    return str(refused.value)


def partitioned_box():
    """Two cubes of edge 1 with one wall between them, all corners shared."""
    left, right = trimesh.creation.box((1, 1, 1)), trimesh.creation.box((1, 1, 1))
    right.apply_translation([1, 0, 0])
    right.update_faces(right.triangles_center[:, 0] > 0.5 + 1e-9)
    return meshes.joined(left, right)


def tilted(mesh, slope):
    vertices = np.array(mesh.vertices)
    top = vertices[:, 2] > vertices[:, 2].max() - 1e-9
    vertices[top, 2] += slope * vertices[top, 0]
    return trimesh.Trimesh(vertices, mesh.faces, process=False)


OPEN_CYLINDER = [(0, 0), (1, 0), (1, 2)]


def test_a_welded_partition_is_told_from_a_hole(tmp_path):
    said = refusal(tmp_path, partitioned_box())
    assert "4 edges at which three or more facets meet, around x=0.5 y=0 z=0 m" in said
    assert "end that wall short of the shell" in said
    assert "nan" not in said


def test_a_partition_that_ends_short_of_the_shell_is_a_wall(tmp_path):
    shell = trimesh.creation.box((2, 1, 1))
    low, high = -0.4999, 0.4999
    corners = [[0, low, low], [0, high, low], [0, high, high], [0, low, high]]
    wall = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], process=False)
    container, told = loaded(tmp_path, meshes.joined(shell, wall))
    assert container.volume == pytest.approx(2.0)
    assert told == []


def test_each_hole_is_placed_by_itself(tmp_path):
    mesh = meshes.torus()
    mesh.update_faces(~np.isin(np.arange(len(mesh.faces)), [7, 1000]))
    said = refusal(tmp_path, mesh)
    assert said.count("3 boundary edges around") == 2
    assert "close all but the top one" in said


def test_a_rim_cut_aslant_is_told_with_its_heights(tmp_path):
    said = refusal(tmp_path, tilted(meshes.revolved(OPEN_CYLINDER), 0.2))
    assert "its rim level: this one goes from 1.8 to 2.2 m" in said


def test_a_vessel_that_lies_on_its_side_is_to_be_turned(tmp_path):
    said = refusal(tmp_path, meshes.standing(meshes.revolved(OPEN_CYLINDER)))
    assert "if that opening is the top, turn the mesh or `gravity_axis`" in said


def test_loose_facets_are_cracks_of_a_width(tmp_path):
    mesh = trimesh.creation.icosphere(subdivisions=2)
    loose = mesh.triangles + np.random.default_rng(0).normal(0, 1e-4, mesh.triangles.shape)
    said = refusal(tmp_path, trimesh.Trimesh(loose.reshape(-1, 3), np.arange(loose.size // 3).reshape(-1, 3)))
    assert "cracks along 9" in said
    assert "merge corners by that distance" in said


def curled(outline):
    """An outline, which may wind twice round some points, drawn up to a height of 1."""
    flat, count = np.array(outline, float), len(outline)
    vertices = np.concatenate([np.column_stack([flat, np.full(count, z)]) for z in (0.0, 1.0)])
    here, there = np.arange(count), np.roll(np.arange(count), -1)
    fan = np.array([[0, k, k + 1] for k in range(1, count - 1)])
    sides = [
        np.column_stack([here, there, there + count]),
        np.column_stack([here, there + count, here + count]),
    ]
    return trimesh.Trimesh(vertices, np.concatenate([fan[:, ::-1], fan + count, *sides]), process=False)


def test_a_surface_that_crosses_itself_is_warned_of_with_a_place(tmp_path):
    loop = [(0, 0), (4, 0), (4, 2), (1, 2), (1, -1), (3, -1), (3, 3), (0, 3)]
    _, told = loaded(tmp_path, curled(loop))
    (line,) = [each for each in told if "crosses itself" in each]
    assert "around x=" in line
    assert "repair it" in line


def test_a_surface_whose_parts_cancel_is_refused(tmp_path):
    said = refusal(tmp_path, curled([(0, 0), (2, 1), (2, 0), (0, 1)]))
    assert "encloses no volume: it crosses itself" in said


def test_separate_shells_are_filled_and_said(tmp_path):
    second = trimesh.creation.box((1, 1, 1))
    second.apply_translation([3, 0, 0])
    container, told = loaded(tmp_path, meshes.joined(trimesh.creation.box((1, 1, 1)), second))
    assert container.volume == pytest.approx(2.0)
    assert told == [
        "vessel.stl: 2 separate shells: each of them will be filled; remove from the file what is no vessel"
    ]


def test_a_shell_through_anothers_wall_is_solid_and_said(tmp_path):
    lance = trimesh.creation.cylinder(radius=0.1, height=1.0, sections=32)
    lance.apply_translation([0, 0, 0.5])
    container, told = loaded(tmp_path, meshes.joined(trimesh.creation.box((1, 1, 1)), lance))
    assert container.volume == pytest.approx(1.0 - 0.0156, abs=0.01)
    (line,) = told
    assert "around x=" in line
    assert "counts as a solid body (a lance, a tube)" in line


@pytest.mark.parametrize("name", ["torus", "u_bend", "tank", "hopper", "l_box"])
def test_a_sound_vessel_is_not_talked_about(name, tmp_path):
    mesh = meshes.torus() if name == "torus" else getattr(meshes, name)(open_top=True)
    assert loaded(tmp_path, mesh)[1] == []
