# ruff: noqa: E501 (each row of the table of faults stays on one line)
"""Claims on the named parts of walls that scenes have."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from packgen.geometry import Rotation, Translation, Vibration
from tests.scene.texts import BOX, SETS, load, problems

FILE = "container: {path: sphere.stl}\n"
BLADE = "walls: [{name: blade, path: cone.stl, %s}]\n"


def wall(folder: Path, keys: str):
    (found,) = load(folder, BOX + SETS + BLADE % keys).walls
    return found


def test_a_wall_has_a_name_a_mesh_a_material_and_may_be_removed(tmp_path: Path) -> None:
    text = "materials: {glass: {}, rubber: {friction: 0.8}}\nwall_material: glass\nwalls:\n"
    text += "  - {name: outlet, path: cone.stl, units: mm, material: rubber, remove: true}\n"
    text += "  - {name: lid, path: sphere.stl}\n"
    scene = load(tmp_path, BOX + SETS.replace("0.08}", "0.08, material: glass}") + text)
    outlet, lid = scene.walls
    assert (outlet.name, outlet.path, outlet.scale) == ("outlet", tmp_path / "cone.stl", 1e-3)
    assert (outlet.material, outlet.remove, lid.material, lid.remove) == ("rubber", True, "glass", False)
    assert [each.name for each in scene.materials] == ["glass", "rubber"]
    assert [each["name"] for each in scene.model_dump()["walls"]] == ["outlet", "lid"]


def test_a_scene_without_walls_says_nothing_of_them(tmp_path: Path) -> None:
    assert "walls" not in load(tmp_path, BOX + SETS).model_dump()


def test_turns_a_minute_are_a_period(tmp_path: Path) -> None:
    motion = wall(tmp_path, "move: {rotate: {axis: z, origin: [1 cm, 0, 0], rpm: 30}}").motion
    assert isinstance(motion, Rotation)
    assert (motion.axis.tolist(), motion.origin.tolist(), motion.period) == ([0, 0, 1], [0.01, 0, 0], 2.0)
    motion = wall(tmp_path, "move: {rotate: {axis: [0, 3, 4], period: 500 ms}}").motion
    assert (motion.axis.tolist(), motion.period) == ([0.0, 0.6, 0.8], 0.5)


def test_walls_move_along_a_line_or_swing(tmp_path: Path) -> None:
    motion = wall(tmp_path, "move: {linear: {velocity: [0, 0, 5 cm/s]}}").motion
    assert isinstance(motion, Translation)
    assert motion.velocity.tolist() == [0, 0, 0.05]
    motion = wall(tmp_path, "move: {vibrate: {amplitude: [0, 1 mm, 0], frequency: 50 Hz}}").motion
    assert isinstance(motion, Vibration)
    assert motion.amplitude.tolist() == [0, 0.001, 0]
    assert math.isclose(motion.period, 0.02)


FAULTS = [
    ("name: a b, path: cone.stl", "walls[0].name: found 'a b', expected a name of at most 64 letters"),
    ("path: cone.stl", "walls[0].name: found nothing, expected this key and a value"),
    ("name: a, path: nope.stl", "walls[0].path: found 'nope.stl', expected a file that exists"),
    ("name: a", "walls[0].path: found nothing, expected this key and a mesh file: only a container with a `path`"),
    ("name: a, path: cone.stl}, {name: a, path: cone.stl", "walls[1].name: found 'a', expected a name that no other wall has"),
    ("name: a, path: cone.stl, material: wood", "walls[0].material: found 'wood', expected one of the materials: ore"),
    ("name: a, path: cone.stl, remove: 1", "walls[0].remove: found 1, expected true or false"),
    ("name: a, path: cone.stl, removed: true", "walls[0].removed: found an unknown key"),
    ("name: a, path: cone.stl, move: {}", "walls[0].move: found none of them, expected exactly one of rotate, linear, vibrate"),
    ("name: a, path: cone.stl, move: {rotate: {axis: z, rpm: 1}, linear: {velocity: [1, 0, 0]}}", "walls[0].move.linear: found rotate and linear, expected exactly one of"),
    ("name: a, path: cone.stl, move: {rotate: {axis: z}}", "walls[0].move.rotate: found none of them, expected exactly one of rpm, period"),
    ("name: a, path: cone.stl, move: {rotate: {axis: z, rpm: 1, period: 2}}", "move.rotate.period: found rpm and period, expected exactly one"),
    ("name: a, path: cone.stl, move: {rotate: {axis: w, rpm: 1}}", "move.rotate.axis: found 'w', expected x, y, z"),
    ("name: a, path: cone.stl, move: {rotate: {axis: z, rpm: -1}}", "move.rotate.rpm: found -1, expected a number greater than 0"),
    ("name: a, path: cone.stl, move: {linear: {velocity: [0, 0, 0]}}", "linear.velocity: found [0.0, 0.0, 0.0], expected a velocity that is not zero"),
    ("name: a, path: cone.stl, move: {linear: {velocity: 3}}", "linear.velocity: found 3, expected a list of three velocities"),
    ("name: a, path: cone.stl, move: {vibrate: {amplitude: [0, 0, 0], period: 1}}", "vibrate.amplitude: found [0.0, 0.0, 0.0], expected an amplitude that"),
    ("name: a, path: cone.stl, move: {spin: 3}", "walls[0].move.spin: found an unknown key, expected one of linear, rotate, vibrate"),
]  # fmt: skip


@pytest.mark.parametrize(("keys", "words"), FAULTS, ids=[keys for keys, _ in FAULTS])
def test_an_impossible_wall_is_one_line_with_place_value_and_expectation(
    tmp_path: Path, keys: str, words: str
) -> None:
    sets = SETS.replace("0.08}", "0.08, material: ore}")
    (found,) = problems(tmp_path, f"{BOX}{sets}materials: {{ore: {{}}}}\nwalls: [{{{keys}}}]\n")
    assert found.startswith("scene.yaml:")
    assert words in found


@pytest.mark.parametrize(
    ("container", "words"),
    [
        ("{box: {min: [0, 0, 0], max: [2, 2, 2]}, periodic: x}", "container.periodic: found 'x', expected a container that does not wrap"),
        ("{path: cone.stl, shape: convex_hull}", "container.shape: found 'convex_hull', expected mesh: a hull has no place"),
    ],
)  # fmt: skip
def test_containers_that_can_have_no_parts_are_refused(tmp_path: Path, container: str, words: str) -> None:
    (found,) = problems(tmp_path, f"container: {container}\n{SETS}walls: [{{name: a, path: sphere.stl}}]\n")
    assert words in found


def test_a_wall_may_be_a_solid_of_the_containers_file(tmp_path: Path) -> None:
    (found,) = load(tmp_path, f"{FILE}{SETS}walls: [{{name: outlet}}]\n").walls
    assert found.path is None
