"""Containers with named parts of their walls: what closes an opening, what stands in them, what cannot be."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from packgen.container.inner_wall import with_inner_wall
from packgen.errors import GeometryError
from packgen.geometry import Mesh, Polyhedron
from packgen.reading.known import known_by_provenance
from packgen.scene import load_scene
from tests.container_meshes import extruded, joined, revolved, saved
from tests.scenes import constant, read_scene

BOX = {"box": {"min": [0, 0, 0], "max": [4, 2, 2]}}
SQUARE = [(0, 1, 2), (0, 2, 3)]


def sheet(*corners):
    """A wall of no thickness through three or four corners."""
    return trimesh.Trimesh(corners, SQUARE[: len(corners) - 2], process=False)


def gate(x=1.0, low=0.0, high=2.0):
    """A sheet across the box."""
    return sheet((x, 0, low), (x, 2, low), (x, 2, high), (x, 0, high))


def block(low, high):
    size = np.subtract(high, low)
    return trimesh.creation.box(size, trimesh.transformations.translation_matrix(low + 0.5 * size))


def silo():
    """A silo, open at its top, with a round hole in its floor, and the plug that closes it."""
    return revolved([(0.2, 0.0), (1.0, 0.0), (1.0, 2.0)]), revolved([(0.0, 0.0), (0.2, 0.0)])


def container_of(tmp_path, container, walls, **keys):
    listed = []
    for name, (mesh, more) in walls.items():
        listed.append({"name": name, "path": saved(mesh, tmp_path, f"{name}.stl")} | more)
    if isinstance(container, trimesh.Trimesh):
        container = {"path": saved(container, tmp_path)}
    return read_scene(tmp_path, container, constant(0.05), walls=listed, **keys)[1]


def refusal(tmp_path, container, walls):
    with pytest.raises(GeometryError) as caught:
        container_of(tmp_path, container, walls)
    text = str(caught.value)
    assert "\n" not in text
    return text


def corners_of(container, name):
    (part,) = (each for each in container.parts if each.name == name)
    return container.surface.vertices[container.surface.faces[part.faces]]


def test_a_plug_closes_the_hole_that_a_container_has(tmp_path):
    shell, plug = silo()
    container = container_of(tmp_path, shell, {"outlet": (plug, {"remove": True})})
    assert container.volume == pytest.approx(2 * 48 * 0.5 * np.sin(2 * np.pi / 48), rel=1e-6)
    (part,) = container.parts
    assert (part.name, part.remove, part.material, len(part.faces)) == ("outlet", True, "default", 48)
    corners = corners_of(container, "outlet")
    assert np.abs(corners[:, :, 2]).max() == 0.0
    assert np.linalg.norm(corners[:, :, :2], axis=2).max() == pytest.approx(0.2)
    assert len(container.surface.faces) == len(shell.faces) + len(plug.faces)


def test_a_vessel_that_its_parts_make_convex_is_held_by_its_planes(tmp_path):
    shell, plug = silo()
    container = container_of(tmp_path, shell, {"outlet": (plug, {})})
    assert isinstance(container.shape, Polyhedron)


def test_a_plug_with_other_corners_on_its_rim_closes_the_hole(tmp_path):
    outline = [(0, 0), (1, 0), (1, 1), (0, 1)]
    walls = extruded(outline, SQUARE, 1.0, open_top=True)
    walls.update_faces(~(walls.triangles[:, :, 2] == 0).all(axis=1))
    floor = trimesh.Trimesh(
        [(0, 0, 0), (0.5, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)],
        [(0, 4, 1), (1, 4, 3), (1, 3, 2)],
        process=False,
    )
    container = container_of(tmp_path, walls, {"floor": (floor, {})})
    assert container.volume == pytest.approx(1.0)
    assert len(container.parts[0].faces) == 3


def test_two_halves_of_a_door_close_a_hole_together(tmp_path):
    outline = [(0, 0), (1, 0), (1, 1), (0, 1)]
    walls = extruded(outline, SQUARE, 1.0, open_top=True)
    walls.update_faces(~(walls.triangles[:, :, 2] == 0).all(axis=1))
    left, right = (sheet((x, 0, 0), (x, 1, 0), (x + 0.5, 1, 0), (x + 0.5, 0, 0)) for x in (0.0, 0.5))
    container = container_of(tmp_path, walls, {"left": (left, {}), "right": (right, {})})
    assert container.volume == pytest.approx(1.0)
    assert corners_of(container, "left")[:, :, 0].max() == 0.5
    assert corners_of(container, "right")[:, :, 0].min() == 0.5


def test_a_sheet_that_divides_a_box_is_a_wall_on_both_sides(tmp_path):
    container = container_of(tmp_path, BOX, {"gate": (gate(), {"remove": True})})
    assert isinstance(container.shape, Mesh)
    assert container.volume == 16.0
    assert container.part_index.tolist() == [-1] * 12 + [0] * 2
    assert (corners_of(container, "gate")[:, :, 0] == 1.0).all()


def test_a_sheet_in_a_vessel_that_is_open_at_its_top_may_reach_the_rim(tmp_path):
    tank = extruded([(0, 0), (4, 0), (4, 2), (0, 2)], SQUARE, 2.0, open_top=True)
    container = container_of(tmp_path, tank, {"gate": (gate(), {})})
    assert container.volume == pytest.approx(16.0)
    assert (corners_of(container, "gate")[:, :, 0] == 1.0).all()


def test_a_closed_part_is_a_solid_body_that_takes_its_volume_off(tmp_path):
    container = container_of(tmp_path, BOX, {"blade": (block([1, 0.5, 0.5], [3, 0.6, 1.5]), {})})
    assert container.volume == pytest.approx(16.0 - 0.2)
    assert len(corners_of(container, "blade")) == 12


def test_parts_in_the_room_and_those_that_close_it_go_together(tmp_path):
    shell, plug = silo()
    blade = block([-0.3, -0.05, 0.5], [0.3, 0.05, 0.8])
    move = {"move": {"rotate": {"axis": "z", "rpm": 30}}}
    container = container_of(tmp_path, shell, {"blade": (blade, move), "outlet": (plug, {"remove": True})})
    assert [(each.name, len(each.faces)) for each in container.parts] == [("blade", 12), ("outlet", 48)]
    assert container.parts[0].motion.period == 2.0
    assert container.volume == pytest.approx(2 * 48 * 0.5 * np.sin(2 * np.pi / 48) - 0.018, rel=1e-6)


def test_the_solids_of_a_text_stl_are_parts_by_name(tmp_path):
    shell, plug = silo()
    text = "".join(
        trimesh.exchange.stl.export_stl_ascii(mesh)
        .replace("solid ", f"solid {name}")
        .replace("solid \n", f"solid {name}\n")
        for name, mesh in (("body", shell), ("outlet", plug))
    )
    (tmp_path / "silo.stl").write_text(text)
    walls = [{"name": "outlet", "remove": True}]
    _, container = read_scene(tmp_path, {"path": "silo.stl"}, constant(0.05), walls=walls)
    assert [(each.name, each.remove, len(each.faces)) for each in container.parts] == [("outlet", True, 48)]
    with pytest.raises(
        GeometryError,
        match=r"walls\[0\] \(lid\): found no surface of that name, expected one of .*: body, outlet",
    ):
        read_scene(tmp_path, {"path": "silo.stl"}, constant(0.05), walls=[{"name": "lid"}])


def test_a_binary_stl_has_no_solids_by_name(tmp_path):
    shell, _ = silo()
    saved(shell, tmp_path, "silo.stl")
    with pytest.raises(GeometryError, match=r"silo\.stl has no solids by name, expected a text STL"):
        read_scene(tmp_path, {"path": "silo.stl"}, constant(0.05), walls=[{"name": "outlet"}])


@pytest.mark.parametrize(
    ("mesh", "words"),
    [
        (gate(x=9.0), "walls[0] (it): found a wall outside of the container, from (9, 0, 0) to (9, 2, 2) m"),
        (block([5, 0, 0], [6, 1, 1]), "found a wall outside of the container, from (5, 0, 0) to (6, 1, 1) m"),
        (
            block([-500, -500, -500], [900, 700, 700]),
            "found a body around the container, from (-500, -500, -500) to (900, 700, 700) m",
        ),
        (sheet((0, 0, 0), (4, 0, 0), (4, 2, 0), (0, 2, 0)), "found a wall that lies on the container's own"),
    ],
    ids=["sheet", "body", "around", "on the wall"],
)
def test_a_part_that_is_nowhere_in_the_room_is_refused(tmp_path, mesh, words):
    text = refusal(tmp_path, BOX, {"it": (mesh, {})})
    assert words in text
    assert "scene.yaml:" in text


def test_a_hole_that_no_part_closes_is_told_with_the_parts(tmp_path):
    shell, _ = silo()
    text = refusal(tmp_path, shell, {"plug": (revolved([(0.0, 0.0), (0.1, 0.0)]), {})})
    assert "has holes" in text
    assert text.endswith(
        "no opening is closed by plug: a wall closes one where its rim lies on that of the opening"
    )


def test_a_part_whose_mesh_cannot_be_read_is_named(tmp_path):
    (tmp_path / "bad.stl").write_text("rubbish")
    with pytest.raises(GeometryError, match=r"blade: bad\.stl holds no triangles"):
        read_scene(tmp_path, BOX, constant(0.05), walls=[{"name": "blade", "path": "bad.stl"}])


def test_a_part_may_consist_of_several_pieces(tmp_path):
    container = container_of(tmp_path, BOX, {"gates": (joined(gate(1.0), gate(3.0)), {})})
    assert len(corners_of(container, "gates")) == 4


def test_a_bed_that_is_read_again_has_its_parts_where_their_meshes_are(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shell, plug = silo()
    move = {"move": {"rotate": {"axis": "z", "rpm": 30}}}
    walls = {"outlet": (plug, {"remove": True}), "blade": (block([-0.3, -0.05, 0.5], [0.3, 0.05, 0.8]), move)}
    first = container_of(tmp_path, shell, walls)
    settings = load_scene(tmp_path / "scene.yaml").model_dump()
    again = known_by_provenance({"settings": settings}, meshes=True).container
    assert [(each.name, each.faces.tolist(), each.remove) for each in again.parts] == [
        (each.name, each.faces.tolist(), each.remove) for each in first.parts
    ]
    assert again.parts[1].motion.period == 2.0
    assert known_by_provenance({"settings": settings}).container is None


def test_a_container_that_is_carved_keeps_its_parts(tmp_path):
    container = container_of(tmp_path, BOX, {"gate": (gate(), {})})
    hole = container_of(tmp_path, block([2, 0.5, 0.5], [3, 1, 1]), {})
    carved, _ = with_inner_wall(container, hole)
    assert (corners_of(carved, "gate")[:, :, 0] == 1.0).all()
    assert len(carved.surface.faces) == 14 + 12
