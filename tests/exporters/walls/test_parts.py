"""Decks with named parts of the walls: a wall a part, of its own material, that moves or is removed."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from exporters import lammps, liggghts, yade
from exporters.shared.lengths import in_unit
from exporters.walls.parts import parts_of, reach_of_motions
from packgen.bed import Material
from packgen.errors import ExportError
from packgen.geometry import (
    Box,
    Container,
    Mesh,
    Polyhedron,
    Rotation,
    Surface,
    Translation,
    Vibration,
    WallPart,
)
from packgen.validation import Limits, validate
from tests.beds import box_surface, make_bed

LOW, HIGH = np.zeros(3), np.array([0.4, 0.1, 0.2])
GATE = np.array([[0.1, 0, 0], [0.1, 0.1, 0], [0.1, 0.1, 0.2], [0.1, 0, 0.2]])
TURN = Rotation(np.array([0.1, 0.0, 0.1]), np.array([0.0, 1.0, 0.0]), 0.5)
MATERIALS = (Material("ore"), Material("rubber", friction=0.9, youngs_modulus=2e7))


def gated(**keys):
    """A box with a sheet across it, which is a part by name."""
    box = box_surface(LOW, HIGH)
    vertices = np.concatenate([box.vertices, GATE])
    sheet = np.array([[8, 9, 10], [8, 10, 11]])
    walls = Surface(vertices, np.concatenate([box.faces, sheet]))
    closed = Surface(vertices, np.concatenate([box.faces, sheet, sheet[:, ::-1]]))
    part = WallPart(**({"name": "gate.1", "faces": np.array([12, 13]), "material": "ore"} | keys))
    return Container("tank", Mesh(closed), walls, np.stack([LOW, HIGH]), 0.008, parts=(part,))


def bed_of(container, position=((0.05, 0.05, 0.01), (0.08, 0.05, 0.01)), **keys):
    return make_bed(position, 0.01, container, materials=MATERIALS, **keys)


def liggghts_deck(bed, folder):
    liggghts.write(bed, folder, liggghts.Options(steps=100))
    return (folder / "in.bed").read_text()


def yade_deck(bed, folder):
    yade.write(bed, folder, yade.Options(steps=100))
    return (folder / "bed.py").read_text()


def lammps_deck(bed, folder):
    lammps.write(bed, folder, lammps.Options(steps=100))
    return (folder / "in.bed").read_text()


def corners_in(path):
    rows = [line.split()[1:] for line in path.read_text().splitlines() if line.strip().startswith("vertex")]
    return np.array(rows, float).reshape(-1, 3, 3)


def test_a_part_is_a_mesh_of_its_own_material(tmp_path):
    deck = liggghts_deck(bed_of(gated(material="rubber")), tmp_path)
    assert re.search(r"^fix wall_mesh all mesh/surface file wall.stl type 1 ", deck, re.MULTILINE)
    assert re.search(r"^fix part_gate_1 all mesh/surface file wall_gate_1.stl type 2 ", deck, re.MULTILINE)
    assert "mesh n_meshes 2 meshes wall_mesh part_gate_1\n" in deck
    assert "peratomtype 100000000.0 20000000.0\n" in deck
    assert len(corners_in(tmp_path / "wall.stl")) == 12
    assert (corners_in(tmp_path / "wall_gate_1.stl")[:, :, 0] == 0.1).all()
    assert "steps_open" not in deck
    assert "move/mesh" not in deck


def test_a_part_that_is_removed_is_there_for_steps_and_gone_for_more(tmp_path):
    deck = liggghts_deck(bed_of(gated(remove=True)), tmp_path)
    before, after = deck.split("run ${steps}\n")
    assert "variable steps_open index 100\n" in before
    assert (
        after.index('"unfix wall"')
        < after.index('"unfix part_gate_1"')
        < after.index("n_meshes 1 meshes wall_mesh")
    )
    assert after.index("n_meshes 1") < after.index('"run ${steps_open}"')


def test_parts_move_behind_the_end_of_the_set_up(tmp_path):
    deck = liggghts_deck(bed_of(gated(motion=TURN)), tmp_path)
    move = "move/mesh mesh part_gate_1 rotate origin 0.1 0.0 0.1 axis 0.0 1.0 0.0 period 0.5\n"
    assert deck.index("setup_only} == 1") < deck.index(move)
    deck = liggghts_deck(bed_of(gated(motion=Translation(np.array([0.0, 0.0, 0.3])))), tmp_path)
    assert "move/mesh mesh part_gate_1 linear 0.0 0.0 0.3\n" in deck
    deck = liggghts_deck(bed_of(gated(motion=Vibration(np.array([0.01, 0, 0]), 0.2))), tmp_path)
    assert "move/mesh mesh part_gate_1 wiggle amplitude 0.01 0.0 0.0 period 0.2\n" in deck


def test_a_part_that_moves_and_is_removed_loses_its_motion_first(tmp_path):
    deck = liggghts_deck(bed_of(gated(motion=TURN, remove=True)), tmp_path)
    assert deck.index('"unfix move_part_gate_1"') < deck.index('"unfix part_gate_1"')


def test_the_box_holds_what_turns_and_swings(tmp_path):
    reach = reach_of_motions(gated(motion=TURN))
    radius = np.hypot(0.0, 0.1)
    np.testing.assert_allclose(reach[0], [0.1 - radius, 0, 0], atol=1e-12)
    np.testing.assert_allclose(reach[1], [0.4, 0.1, 0.1 + radius])
    swing = Vibration(np.array([0.35, 0.0, 0.0]), 1.0)
    assert reach_of_motions(gated(motion=swing))[:, 0].tolist() == [pytest.approx(-0.25), pytest.approx(0.45)]
    liggghts_deck(bed_of(gated(motion=swing)), tmp_path)
    low, high = map(float, (tmp_path / "bed.data").read_text().split("xlo")[0].split()[-2:])
    assert low < -0.25
    assert high > 0.45


def test_motions_are_in_the_unit_of_the_deck():
    turn = in_unit(bed_of(gated(motion=TURN)), 1e-3).container.parts[0].motion
    assert turn.origin.tolist() == [100.0, 0.0, 100.0]
    assert turn.period == 500.0
    swing = (
        in_unit(bed_of(gated(motion=Vibration(np.array([0.01, 0, 0]), 0.2))), 1e-3).container.parts[0].motion
    )
    assert (swing.amplitude[0], swing.period) == (10.0, 200.0)


def test_labels_of_parts_are_unlike(tmp_path):
    container = gated()
    one, other = (WallPart(name, np.array([face]), "ore") for name, face in (("a.b", 12), ("a-b", 13)))
    double = Container(
        **{name: getattr(container, name) for name in ("name", "shape", "surface", "bounds", "volume")},
        parts=(one, other),
    )
    assert [each.label for each in parts_of(double)] == ["a_b", "a_b_"]


def test_yade_has_the_facets_of_a_part_by_name_and_material(tmp_path):
    deck = yade_deck(bed_of(gated(material="rubber", remove=True, motion=TURN)), tmp_path)
    assert '"gate.1": facets("wall_gate_1.stl", materials[1]),' in deck
    assert "# wall gate.1, material rubber\n" in deck
    assert "RotationEngine(" in deck
    assert deck.index("setup_only") < deck.index("+ motions +")
    assert (
        deck.index("O.run(steps, True)")
        < deck.index("O.bodies.erase")
        < deck.index("O.run(steps_open, True)")
    )
    assert (corners_in(tmp_path / "wall_gate_1.stl")[:, :, 0] == 0.1).all()
    compile(deck, "bed.py", "exec")


@pytest.mark.parametrize(
    "motion", [TURN, Translation(np.array([0.0, 0.0, 0.3])), Vibration(np.array([0.01, 0, 0]), 0.2)]
)
def test_yades_decks_are_python(tmp_path, motion):
    compile(yade_deck(bed_of(gated(motion=motion)), tmp_path), "bed.py", "exec")


def test_in_lammps_a_rectangle_is_a_block_without_thickness_of_its_own_material(tmp_path):
    deck = lammps_deck(bed_of(gated(material="rubber")), tmp_path)
    assert "region part_gate_1 block 0.1 0.1 0.0 0.1 0.0 0.2 side out" in deck
    (wall,) = re.findall(r"^fix wall_1 .* granular (.*) region wall$", deck, re.MULTILINE)
    (part,) = re.findall(r"^fix part_gate_1_1 .* granular (.*) region part_gate_1$", deck, re.MULTILINE)
    assert wall != part
    assert deck.count(" plane ") == 6


def test_in_lammps_a_part_moves_behind_the_end_of_the_set_up_and_goes_after_the_run(tmp_path):
    deck = lammps_deck(bed_of(gated(motion=TURN, remove=True)), tmp_path)
    before, _, after = deck.partition("jump SELF setup_end")
    assert "rotate v_" not in before
    assert "variable turn_gate_1 equal 2.0*PI*step*dt/0.5" in after
    assert "side out rotate v_turn_gate_1 0.1 0.0 0.1 0.0 1.0 0.0" in after
    removed = after.rindex('"unfix part_gate_1_1"')
    assert after.index("run ${steps}") < removed < after.index('"run ${steps_open}"')
    swings = lammps_deck(bed_of(gated(motion=Vibration(np.array([0.01, 0, 0]), 0.2))), tmp_path)
    assert "side out move v_x_gate_1 NULL NULL" in swings
    assert "variable x_gate_1 equal 0.01*sin(2.0*PI*step*dt/0.2)" in swings


def test_lammps_refuses_parts_that_no_region_is_by_name(tmp_path):
    tilted = gated()
    vertices = tilted.surface.vertices.copy()
    vertices[-2:, 0] += 0.05
    askew = replace(tilted, surface=Surface(vertices, tilted.surface.faces))
    with pytest.raises(
        ExportError, match=r"lammps: wall gate\.1: walls with it are not convex, .*; export it for liggghts"
    ):
        lammps.write(bed_of(askew), tmp_path, lammps.Options())


def convex(**keys):
    """A box held by its planes, whose floor is a part by name."""
    surface = box_surface(LOW, HIGH)
    normal = np.concatenate([np.eye(3), -np.eye(3)])
    shape = Polyhedron(normal, np.concatenate([HIGH, -LOW]), surface)
    part = WallPart(**({"name": "floor", "faces": np.array([0, 1]), "material": "ore"} | keys))
    return Container("tank", shape, surface, np.stack([LOW, HIGH]), 0.008, parts=(part,))


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"motion": TURN}, "cannot move a part of it; export it for liggghts or yade, or leave `move` out"),
        ({"material": "rubber"}, "its material is rubber, .* or give it the material ore"),
    ],
)
def test_lammps_takes_parts_of_a_convex_container_that_are_like_the_rest(tmp_path, keys, words):
    lammps.write(bed_of(convex()), tmp_path, lammps.Options())
    with pytest.raises(ExportError, match=f"lammps: wall floor: .*{words}"):
        lammps.write(bed_of(convex(**keys)), tmp_path, lammps.Options())


def test_lammps_removes_a_plane_that_a_part_has_to_itself(tmp_path):
    deck = lammps_deck(bed_of(convex(remove=True)), tmp_path)
    assert "region wall_left intersect 5 " in deck
    assert deck.index("run ${steps}") < deck.index('"unfix wall_1"') < deck.index('region wall_left" &')
    half = convex(remove=True, faces=np.array([0]))
    with pytest.raises(ExportError, match=r"wall floor: it is a part of a flat wall, and LAMMPS has no wall"):
        lammps.write(bed_of(half), tmp_path, lammps.Options())


def test_lammps_refuses_an_opening_that_walls_lean_over(tmp_path):
    surface = box_surface(LOW, HIGH)
    vertices = surface.vertices.copy()
    top = vertices[:, 2] > 0.1
    vertices[top, 0] = np.where(vertices[top, 0] > 0.1, 0.5, -0.1)
    surface = Surface(vertices, surface.faces)
    along, down = np.array([0.2, 0.1]) / np.hypot(0.1, 0.2)
    sides = [[along, 0, -down], [-along, 0, -down], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]]
    offset = np.array([0.4 * along, 0.0, 0.1, 0.0, 0.2, 0.0])
    shape = Polyhedron(np.array(sides), offset, surface)
    funnel = replace(convex(remove=True), shape=shape, surface=surface)
    with pytest.raises(ExportError, match=r"wall floor: LAMMPS' walls beside it would .* lean over it"):
        lammps.write(bed_of(funnel), tmp_path, lammps.Options())


def test_a_floor_that_is_removed_is_no_endless_plane_in_yade(tmp_path):
    assert "(2, 0.0)" in yade_deck(
        bed_of(Container("tank", Box(LOW, HIGH), box_surface(LOW, HIGH), np.stack([LOW, HIGH]), 0.008)),
        tmp_path,
    )
    assert "(2, 0.0)" not in yade_deck(bed_of(convex(remove=True)), tmp_path)


@pytest.fixture(params=[-1, 1])
def sense(request):
    return request.param


def run(program, folder, *arguments):
    commands = {
        "liggghts": ["stdbuf", "-oL", "liggghts", "-in", "in.bed", "-log", "none", *arguments],
        "lmp": ["lmp", "-in", "in.bed", "-log", "none", *arguments],
        "yade": ["yade", "-n", "-x", "-j1", "bed.py", *arguments],
    }
    done = subprocess.run(
        commands[program],
        cwd=folder,
        capture_output=True,
        text=True,
        errors="replace",
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


def end_of(program, folder, step):
    """Positions at the end of a run [m], in the order of the bed."""
    if program == "yade":
        return np.loadtxt(folder / "post/bed_end.txt", ndmin=2)[:, :3]
    rows = re.split(r"radius ?\n", (folder / f"post/bed_{step}.dump").read_text())[1].splitlines()
    table = np.array([row.split() for row in rows], float)
    return table[np.argsort(table[:, 0])][:, 2:5]


PROGRAMS = [
    pytest.param(
        name,
        marks=[
            pytest.mark.slow,
            pytest.mark.solver,
            pytest.mark.skipif(not shutil.which(name), reason=f"no {name}"),
        ],
    )
    for name in ("liggghts", "lmp", "yade")
]


def moved(program, folder, container, position, steps, more=0):
    """Where spheres are after a run of a deck [m]."""
    bed = bed_of(container, position, gravity=np.array([0.0, 0.0, -9.81]))
    if program == "yade":
        yade.write(bed, folder, yade.Options())
        run(program, folder, str(steps), str(more))
    else:
        writer = {"liggghts": liggghts, "lmp": lammps}[program]
        writer.write(bed, folder, writer.Options())
        variables = {"steps": steps, "dump_every": steps, "steps_open": more}
        listed = [word for name, value in variables.items() for word in ("-var", name, str(value))]
        run(program, folder, *(listed if container.parts[0].remove else listed[:-3]))
    return end_of(program, folder, steps + more)


@pytest.mark.parametrize("program", PROGRAMS)
def test_in_solvers_a_wall_that_moves_takes_a_sphere_with_it(tmp_path, program, sense):
    push = gated(motion=Translation(np.array([sense * 0.5, 0.0, 0.0])))
    (at,) = moved(program, tmp_path, push, [(0.1 + sense * 0.0101, 0.05, 0.01)], 2000)
    assert sense * (at[0] - 0.1) > 0.02


@pytest.mark.parametrize("program", PROGRAMS)
def test_in_solvers_a_wall_turns_counter_clockwise_about_its_axis(tmp_path, program):
    # About y through the foot of the gate: its upper part goes to +x.
    turn = Rotation(np.array([0.1, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]), 1.0)
    right = moved(program, tmp_path, gated(motion=turn), [(0.1101, 0.05, 0.01), (0.0899, 0.05, 0.01)], 1500)
    assert right[0, 0] > 0.112
    assert right[1, 0] == pytest.approx(0.0899, abs=1e-3)


@pytest.mark.parametrize("program", PROGRAMS)
def test_in_solvers_a_sphere_falls_where_a_floor_is_removed(tmp_path, program):
    spheres = [(0.1, 0.05, 0.01), (0.2, 0.05, 0.01)]
    held = moved(program, tmp_path, convex(remove=True), spheres, 600)
    np.testing.assert_allclose(held[:, 2], 0.01, atol=1e-4)
    fallen = moved(program, tmp_path, convex(remove=True), spheres, 300, 900)
    assert (fallen[:, 2] < 0.008).all()


def test_the_box_grows_with_a_part_that_leaves_it(tmp_path):
    for velocity, boundary in (((0, 0, 1), "f f fm"), ((-1, 0, -1), "mf f mf"), ((0, 2, 0), "f fm f")):
        deck = liggghts_deck(bed_of(gated(motion=Translation(np.array(velocity, float)))), tmp_path)
        assert f"boundary {boundary}\n" in deck


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.skipif(not shutil.which("liggghts"), reason="no liggghts")
def test_liggghts_runs_on_when_a_part_has_left_the_box(tmp_path):
    lift = gated(motion=Translation(np.array([0.0, 0.0, 40.0])))
    (at,) = moved("liggghts", tmp_path, lift, [(0.05, 0.05, 0.01)], 2000)
    assert at[2] == pytest.approx(0.01, abs=1e-4)


@pytest.mark.parametrize("program", [each for each in PROGRAMS if each.values != ("lmp",)])
def test_forces_of_parts_in_solvers_follow_their_materials(tmp_path, program):
    spheres = [(0.10995, 0.05, 0.05), (0.38, 0.05, 0.00995)]
    bed = bed_of(gated(material="rubber"), spheres)
    writer = {"liggghts": liggghts, "yade": yade}[program]
    writer.write(bed, tmp_path, writer.Options())
    zero = validate(bed, tmp_path, solver=program, limits=Limits(free_fall_times=0.1)).step_zero
    assert zero.wall_count >= 2
    assert zero.law_error < 1e-3
