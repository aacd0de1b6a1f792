"""Random scenes end to end; and what judges them, held against beds that are known to be wrong."""

from __future__ import annotations

import contextlib
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.container_meshes import revolved
from tests.fuzz.__main__ import main
from tests.fuzz.decks import installed, is_loadable, judge_deck, judge_rows
from tests.fuzz.generator import Case, Zone, has_lammps_walls, make_case
from tests.fuzz.judge import Bed, judge_folder, judge_lines, judge_refusal, of_amounts, overlaps, read_bed
from tests.fuzz.laws import curve, stepped
from tests.fuzz.mutations import break_case
from tests.fuzz.run import Outcome, judge, run_command, run_number
from tests.fuzz.solids import Ball, Box, Cone, Hull, Slab, Solidmesh

CORNERS = [[x, y, z] for x in (1.0, 3.0) for y in (1.0, 3.0) for z in (1.0, 3.0)]
LATTICE = np.array(CORNERS)  # eight spheres of radius 1 that fill a box of 4 m


def case_of(folder: Path, **changes) -> Case:
    law = stepped({"radius_distribution": "constant", "radius": 1.0}, [1.0], [1.0])
    zone = Zone(None, None, 64.0, [1.0], key="n_particles", amount=8)
    box = Box(np.zeros(3), np.full(3, 4.0))
    data = {"container": box.spec(), "particle_sets": [law.spec], "zones": [zone.spec()]}
    case = Case(0, folder, data, box, np.array([0.0, 0.0, -1.0]), [law], [zone], 1e-6, [], ["--no-report"])
    return replace(case, **changes)


def write_result(
    folder: Path, position=LATTICE, radius=None, *, missed=(), asked=8, zone=None, **report
) -> Path:
    """Write what a run would have left of such a bed, its report true unless told otherwise."""
    output = folder / "out"
    shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True)
    count = len(position)
    radius = np.ones(count) if radius is None else np.asarray(radius, float)
    arrays = {"position": np.asarray(position, float), "radius": radius}
    arrays |= {name: np.zeros(count, np.int32) for name in ("set_index", "zone_index", "batch_index")}
    np.savez(output / "bed.npz", provenance=np.array("{}"), **arrays)
    sound = count and np.isfinite(arrays["position"]).all()
    found = overlaps(arrays["position"], radius, np.zeros(3))[0] if sound else np.zeros(0)
    content = {
        "missed": list(missed), "sphere_count": count, "zones": [{"asked": asked, "placed": count}],
        "sets": [{"count": count, "volume": float((4.0 / 3.0 * np.pi * radius**3).sum())}],
        "overlap": {"overlap_max": float(found.max(initial=0.0))}, "files": ["bed.npz", "report.json"],
    } | report  # fmt: skip
    (output / "report.json").write_text(json.dumps(content))
    return output


def moved(index: int, *shift: float):
    position = LATTICE.copy()
    position[index] += shift
    return position


def test_a_good_bed_has_no_fault(tmp_path):
    assert judge_folder(case_of(tmp_path), write_result(tmp_path), 0) == []


@pytest.mark.parametrize(
    ("changes", "code", "fault"),
    [
        ({"position": moved(0, 0.0, 0.0, 1e-4)}, 0, "overlap by 0.0001 r"),
        ({"position": moved(0, 0.0, 0.0, -1e-4)}, 0, "not inside the container, sphere 0 by 0.0001 r"),
        ({"position": moved(0, 0.0, 0.0, -9.0)}, 0, "not inside the container, sphere 0 by 9 r"),
        ({"position": LATTICE[:7]}, 0, "7 spheres, 8 are asked for"),
        ({"position": LATTICE[:7], "asked": 7}, 0, "7 spheres, 8 are asked for"),
        ({"position": moved(0, np.nan, 0.0, 0.0)}, 0, "no number"),
        ({"radius": [0.99] + 7 * [1.0]}, 0, "is outside 1 to 1"),
        ({"sphere_count": 9}, 0, "report.json counts 9 spheres"),
        ({"overlap": {"overlap_max": 0.1}}, 0, "report.json says that spheres overlap by 0.1"),
        ({"zones": [{"asked": 8, "placed": 7}]}, 0, "differ in the spheres of a zone"),
        ({"sets": [{"count": 8, "volume": 1.0}]}, 0, "differ in the volume of a set"),
        ({"files": ["bed.npz"]}, 0, "files differ"),
        ({}, 1, "exit code 1, but missed is []"),
        ({"missed": ["x"]}, 0, "exit code 0, but missed is ['x']"),
    ],
)  # fmt: skip
def test_a_bed_that_is_wrong_is_found_out(tmp_path, changes, code, fault):
    with np.errstate(all="ignore"):
        faults = judge_folder(case_of(tmp_path), write_result(tmp_path, **changes), code)
    assert any(fault in each for each in faults), faults


def test_a_missing_array_a_missing_deck_and_a_second_deck_are_found_out(tmp_path):
    output = write_result(tmp_path)
    assert "vtk: a deck and a refusal, or neither: []" in judge_folder(
        case_of(tmp_path, exports=["vtk"]), output, 0
    )
    np.savez(output / "bed.npz", position=LATTICE)
    assert "cannot be read" in judge_folder(case_of(tmp_path), output, 0)[0]
    whole = (output / "bed.npz").read_bytes()
    for length in (0, len(whole) // 2):
        (output / "bed.npz").write_bytes(whole[:length])
        assert "cannot be read" in judge_folder(case_of(tmp_path), output, 0)[0]


def test_spheres_of_all_sizes_that_overlap_are_found_across_periodic_sides_too():
    rng = np.random.default_rng(3)
    position, radius = rng.random((400, 3)), 0.05 * rng.uniform(0.05, 1.0, 400)
    for period in (np.zeros(3), np.ones(3), np.array([1.0, 0.0, 0.0])):
        apart = position[:, None] - position
        apart -= np.where(period > 0.0, np.round(apart), 0.0)
        distance = np.linalg.norm(apart, axis=2)
        deep = (radius[:, None] + radius - distance) / np.minimum(radius[:, None], radius)
        first, second = np.nonzero(np.triu(deep > 0.0, 1))
        found, pairs = overlaps(position, radius, period)
        assert {tuple(sorted(each)) for each in pairs.tolist()} == set(
            zip(first.tolist(), second.tolist(), strict=True)
        )
        assert found.max() == pytest.approx(deep[first, second].max())


def test_a_sphere_outside_its_location_is_found_and_a_slice_bounds_centres(tmp_path):
    output = write_result(tmp_path)
    for location, fine in (
        (Slab(2, 1.0, 3.0), True), (Slab(2, 1.1, 3.0), False), (Slab(0, 0.0, 4.0), True),
        (Slab(0, 0.1, 4.0), False), (Ball(np.full(3, 2.0), 2.74), True), (Ball(np.full(3, 2.0), 2.7), False),
    ):  # fmt: skip
        zone = Zone(location, location.spec(), 64.0, [1.0], key="n_particles", amount=8)
        faults = judge_folder(case_of(tmp_path, zones=[zone]), output, 0)
        assert (faults == []) == fine, (location, faults)


def test_an_amount_that_is_missed_by_more_than_a_sphere_is_found_out(tmp_path):
    volume = 8 * 4.0 / 3.0 * np.pi
    output = write_result(tmp_path)
    for amount, fine in ((volume, True), (1.1 * volume, True), (1.2 * volume, False), (0.8 * volume, False)):
        zone = Zone(None, None, 64.0, [1.0], key="volume", amount=amount)
        assert (judge_folder(case_of(tmp_path, zones=[zone]), output, 0) == []) == fine


HEAVY, LIGHT = 4.0 / 3.0 * np.pi, 4.0 / 3.0 * np.pi * 0.5**3


@pytest.mark.parametrize(
    ("key", "shares_by", "shares", "amount", "counts", "fault"),
    [
        ("volume", "number", [0.5, 0.5], 4 * HEAVY + 4 * LIGHT, [4, 4], ""),
        ("volume", "number", [0.55, 0.45], 4 * HEAVY + 4 * LIGHT, [4, 4], ""),
        ("volume", "number", [0.8, 0.2], 4 * HEAVY + 4 * LIGHT, [4, 4], "sets have [4, 4] spheres"),
        ("volume", "number", [0.5, 0.5], 5 * HEAVY + 3 * LIGHT, [5, 3], "sets have [5, 3] spheres"),
        ("volume", "volume", [8.0 / 9.0, 1.0 / 9.0], 4 * HEAVY + 4 * LIGHT, [4, 4], ""),
        ("volume", "volume", [0.9, 0.1], 4 * HEAVY + 4 * LIGHT, [4, 4], ""),
        ("volume", "volume", [0.8, 0.2], 4 * HEAVY + 4.5 * LIGHT, [4, 4], "set 1: volume is"),
        ("volume", "volume", [0.7, 0.3], 4 * HEAVY + 4 * LIGHT, [4, 4], "set 0: volume is"),
        ("volume", "mass", [8.0 / 10.0, 2.0 / 10.0], 4 * HEAVY + 4 * LIGHT, [4, 4], ""),
        ("mass", "volume", [8.0 / 9.0, 1.0 / 9.0], 4 * HEAVY + 8 * LIGHT, [4, 4], ""),
        ("mass", "mass", [8.0 / 10.0, 2.0 / 10.0], 4 * HEAVY + 8 * LIGHT, [4, 4], ""),
        ("mass", "mass", [0.5, 0.5], 4 * HEAVY + 8 * LIGHT, [4, 4], "set 1: mass is"),
        ("mass", "mass", [1.0, 0.0], 4 * HEAVY + 8 * LIGHT, [4, 4], "sets of share 0 have spheres"),
    ],
)  # fmt: skip
def test_a_sum_of_several_sets_is_held_against_their_shares(
    tmp_path, key, shares_by, shares, amount, counts, fault
):
    radius, set_index = np.repeat([1.0, 0.5], counts), np.repeat([0, 1], counts).astype(np.int32)
    laws = [stepped({}, [each], [1.0]) for each in (1.0, 0.5)]
    case = case_of(tmp_path, laws=laws, zones=[Zone(None, None, 64.0, shares, shares_by, key, amount)])
    case.data["particle_sets"] = [{"density": 1.0}, {"density": 2.0}]
    bed = Bed(LATTICE, radius, set_index, np.zeros(8, np.int32), np.zeros(8, np.int32))
    faults = list(of_amounts(case, bed, {"zones": [{"asked": 8}]}, 0))
    assert any(fault in each for each in faults) if fault else faults == [], faults


@pytest.mark.parametrize(
    ("shares_by", "parts", "missing"),
    [
        ("volume", [2.4, 2.4, 4.4], False),
        ("volume", [2.4, 2.4, 4.6], True),
        ("number", [2.4, 2.4, 4.4], True),
    ],
)
def test_shares_of_a_sum_come_first_and_may_each_leave_half_a_sphere_of_it_out(
    tmp_path, shares_by, parts, missing
):
    shares = [each / sum(parts) for each in parts]
    zone = Zone(None, None, 64.0, shares, shares_by, "volume", sum(parts) * HEAVY)
    case = case_of(tmp_path, laws=3 * [stepped({}, [1.0], [1.0])], zones=[zone])
    case.data["particle_sets"] = [{}, {}, {}]
    set_index = np.repeat([0, 1, 2], [2, 2, 4]).astype(np.int32)
    bed = Bed(LATTICE, np.ones(8), set_index, np.zeros(8, np.int32), np.zeros(8, np.int32))
    assert bool(list(of_amounts(case, bed, {"zones": [{"asked": 8}]}, 0))) == missing


def test_a_file_that_is_used_up_may_leave_its_share_short(tmp_path):
    laws = [stepped({}, [1.0], [1.0]), stepped({}, [0.5] * 4, np.ones(4), listed=True)]
    amount = 4 * HEAVY + 6 * LIGHT
    zone = Zone(None, None, 64.0, [4 * HEAVY / amount, 6 * LIGHT / amount], "volume", "volume", amount)
    case = case_of(tmp_path, laws=laws, zones=[zone])
    case.data["particle_sets"] = [{}, {}]
    set_index = np.repeat([0, 1], 4).astype(np.int32)
    bed = Bed(LATTICE, np.repeat([1.0, 0.5], 4), set_index, np.zeros(8, np.int32), np.zeros(8, np.int32))
    assert list(of_amounts(case, bed, {"zones": [{"asked": 8}]}, 0)) == []


@pytest.mark.parametrize("convex", [True, False])
def test_lammps_has_walls_for_convex_vessels_alone(convex):
    outline = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 1.4), (0.5, 1.8), (0.0, 1.8)]
    mesh = revolved([*outline[:3], (0.0, 1.0)] if convex else outline, 12)
    vertices = np.asarray(mesh.vertices, np.float32).astype(float)
    body = Solidmesh(vertices, np.asarray(mesh.faces), np.zeros(len(mesh.faces), bool))
    assert has_lammps_walls(body) == convex
    assert has_lammps_walls(Hull(vertices))


def test_lammps_has_no_walls_for_tilted_or_flat_cones():
    def cone(axis, top):
        return Cone(np.zeros(3), np.asarray(axis), 1.0, 0.5, top)

    assert has_lammps_walls(cone([0.0, -1.0, 0.0], 0.5))
    assert not has_lammps_walls(cone([0.0, 0.6, 0.8], 0.5))
    assert not has_lammps_walls(cone([0.0, 0.0, 1.0], 3.0))


def test_scenes_ask_seldom_for_decks_that_are_refused_early(tmp_path, monkeypatch):
    monkeypatch.setattr("tests.fuzz.generator.EXPORTERS", 4 * ("lammps",))
    monkeypatch.setattr("tests.fuzz.generator.REFUSED", 0.0)
    cases = [make_case(number, tmp_path) for number in range(12)]
    walled = [has_lammps_walls(case.container) for case in cases]
    asks = ["lammps" in case.exports for case in cases]
    assert not all(walled)
    assert any(asks)
    assert not any(asked and not has for asked, has in zip(asks, walled, strict=True))


def test_a_deck_without_walls_that_is_not_refused_is_found_out(tmp_path):
    tilted = Cone(np.zeros(3), np.array([0.0, 0.6, 0.8]), 9.0, 9.0, 9.0)
    case = case_of(tmp_path, container=tilted, exports=["lammps"])
    assert judge(case, 0, "") == ["exit code 0, but LAMMPS has no walls for such a container"]


def test_sets_that_have_not_their_shares_and_radii_off_their_law_are_found_out(tmp_path):
    low, high = (stepped({}, [each], [1.0]) for each in (0.5, 1.0))
    two = case_of(
        tmp_path, laws=[low, high], zones=[Zone(None, None, 64.0, [0.25, 0.75], "number", "n_particles", 8)]
    )
    two.data["particle_sets"] = [{}, {}]
    sets = {"sets": [{"count": 0, "volume": 0.0}, {"count": 8, "volume": 8 * 4.0 / 3.0 * np.pi}]}
    output = write_result(tmp_path, **sets)
    with np.load(output / "bed.npz") as file:
        arrays = dict(file) | {"set_index": np.ones(8, np.int32)}
    np.savez(output / "bed.npz", **arrays)
    assert judge_folder(two, output, 0) == ["zone 0: sets have [0, 8] spheres, expected [2.0, 6.0]"]
    even = curve({}, 0.5, 1.0, lambda radius: radius)
    faults = judge_folder(case_of(tmp_path, laws=[even]), write_result(tmp_path), 0)
    assert faults == ["zone 0: set 0: the curve of its 8 radii is off by 0.938"]


def test_a_sphere_of_a_file_that_is_there_twice_is_found_out(tmp_path):
    files = stepped({}, [0.5, 1.0], [1.0, 1.0], listed=True)
    assert "a sphere of its file is there twice" in str(
        judge_folder(case_of(tmp_path, laws=[files]), write_result(tmp_path), 0)
    )


def test_a_container_that_is_not_full_is_found_out(tmp_path):
    zone = Zone(None, None, 64.0 * 30.0, [1.0])
    faults = judge_folder(case_of(tmp_path, zones=[zone]), write_result(tmp_path, asked=None), 0)
    assert faults == ["zone 0: filled until full with 8 spheres, about 252 have room"]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("packgen: scene.yaml:3:1: seed: found -1, expected ...", ""),
        ("packgen: sorry, this is a fault of packgen", "says"),
        ("packgen: scene.yaml: x\nTraceback (most recent call last)", "says"),
        ("packgen: something is wrong", "without a place"),
        ("packgen: scene.yaml: x\nmodule.py:3: RuntimeWarning: divide by zero", "prints"),
    ],
)
def test_a_refusal_is_clean_lines_with_a_place_and_leaves_nothing(tmp_path, text, fault):
    faults = judge_refusal(text, tmp_path / "out")
    assert (fault in str(faults)) if fault else faults == []
    (tmp_path / ".out.unfinished-x").mkdir()
    assert "is there" in str(judge_refusal(text, tmp_path / "out"))


def test_exit_codes_that_are_none_are_faults(tmp_path):
    assert judge(case_of(tmp_path), 3, "") == ["exit code 3"]
    assert judge_lines("packgen: warning: x\narrange: 3 spheres") == []


def test_a_deck_that_loses_spheres_or_pushes_them_is_found_out(tmp_path):
    case = case_of(tmp_path)
    bed = read_bed(write_result(tmp_path) / "bed.npz")
    rows = np.column_stack([LATTICE, np.ones(8), np.zeros((8, 3))])
    assert judge_rows(case, bed, rows, 8) == []
    assert "7 at step" in judge_rows(case, bed, rows, 7)[0]
    pushed, shifted = rows.copy(), rows.copy()
    pushed[3, 5], shifted[0, 0] = 1e8, 1.001
    assert "sphere 3 is pushed" in judge_rows(case, bed, pushed, 8)[0]
    assert "not those of bed.npz" in judge_rows(case, bed, shifted, 8)[0]


@pytest.mark.solver
@pytest.mark.parametrize("solver", installed())
def test_a_deck_that_its_solver_refuses_is_found_out(tmp_path, solver):
    case = case_of(tmp_path, exports=[solver], options=["--no-report", "--seed", "1"])
    case.write()
    code, said = run_command([str(case.path), "-o", str(tmp_path / "out"), *case.arguments])
    assert judge(case, code, said) == []
    assert judge_deck(case, solver) == []
    shutil.rmtree(tmp_path / f"run_{solver}")
    deck = tmp_path / "out" / solver / ("bed.py" if solver == "yade" else "in.bed")
    deck.write_text(deck.read_text() + "\nno_such_command\n")
    assert f"{solver}: exit code" in str(judge_deck(case, solver))


def test_a_scene_without_end_is_stopped_and_ctrl_c_ends_the_fuzzer(tmp_path, monkeypatch):
    def endless(_arguments):
        with contextlib.suppress(KeyboardInterrupt):
            while True:
                pass
        return 130

    monkeypatch.setattr("tests.fuzz.run.main", endless)
    assert run_command([], 0.05) == (130, "")
    monkeypatch.setattr("tests.fuzz.run.main", lambda _arguments: 130)
    with pytest.raises(KeyboardInterrupt):
        run_command([])


def test_a_number_is_a_scene(tmp_path):
    texts = []
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        case = make_case(4711, tmp_path / name)
        break_case(case, np.random.default_rng(1))
        texts.append([each.read_bytes() for each in sorted((tmp_path / name).iterdir())])
    assert texts[0] == texts[1]
    (tmp_path / "c").mkdir()
    assert make_case(4712, tmp_path / "c").path.read_bytes() not in texts[0]


def test_a_scene_broken_anywhere_leaves_the_judge_what_it_knows(tmp_path):
    path = tmp_path / "scene.yaml"
    for number in range(60):
        case = case_of(tmp_path)
        case.data |= {"materials": {"ore": {"youngs_modulus": 1e8}}, "gravity": 9.81}
        known = json.dumps(case.data)
        case.write()
        sound = path.read_bytes()
        break_case(case, np.random.default_rng(number))
        assert case.broken
        assert path.read_bytes() != sound, case.broken
        assert json.dumps(case.data) == known, case.broken
        assert is_loadable(case)


def test_a_scene_that_no_solver_loads_is_not_looked_at_for_one(tmp_path, monkeypatch):
    def unexpected(_case):
        raise AssertionError

    monkeypatch.setattr("tests.fuzz.run.main", lambda _arguments: 0)
    monkeypatch.setattr("tests.fuzz.run.judge_folder", lambda *_: [])
    monkeypatch.setattr("tests.fuzz.run.is_loadable", unexpected)
    (tmp_path / "out").mkdir()
    assert run_number(6, tmp_path).loaded == ""


def test_a_fault_of_the_fuzzer_is_told_as_a_scenes_and_the_next_scenes_follow(monkeypatch, capsys):
    def failing(number, _folder, _solvers, *, every):
        if number == 8:
            raise TypeError("no such value")
        return Outcome(number, 0, 1, 0.0, ())

    monkeypatch.setattr("tests.fuzz.__main__.run_number", failing)
    assert main(["--first", "7", "--scenes", "3"]) == 1
    said = capsys.readouterr().out
    assert "scene 8: the fuzzer fails at test_fuzz_scenes.py:" in said
    assert "TypeError: no such value" in said
    assert "3 scenes" in said
    assert "1 with faults" in said


@pytest.mark.slow
def test_a_hundred_random_scenes_have_no_fault(capsys):
    failed = main(["--scenes", "100", "--first", "0"])
    said = capsys.readouterr().out
    assert not failed, said
    assert "100 scenes" in said
