from __future__ import annotations

import importlib.util
import json
import os
import shutil
import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from packgen.cli import main
from packgen.container import load_container
from packgen.geometry import Polyhedron
from packgen.scene import load_scene

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
SCRIPTS = [
    EXAMPLES / "run",
    EXAMPLES.parent / "tests/run",
    EXAMPLES.parent / ".ci/run",
    EXAMPLES.parent / ".ci/venv",
]


def shells():
    """The script that makes the surfaces, as a module."""
    spec = importlib.util.spec_from_file_location("shells", EXAMPLES / "shells.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def corners_of(path):
    facets = np.frombuffer(
        path.read_bytes()[84:], dtype=[("rest", "<f4", 3), ("corners", "<f4", (3, 3)), ("end", "<u2")]
    )
    return facets["corners"]


def test_the_surfaces_are_those_that_the_script_makes(tmp_path):
    module = shells()
    module.__file__ = str(tmp_path / "shells.py")
    module.main()
    for path in sorted(tmp_path.glob("*.stl")):
        np.testing.assert_allclose(corners_of(path), corners_of(EXAMPLES / path.name), rtol=0, atol=1e-6)
    assert {path.name for path in tmp_path.glob("*.stl")} == {path.name for path in EXAMPLES.glob("*.stl")}


def test_binary_surfaces_do_not_begin_like_text_ones():
    assert not any(path.read_bytes().startswith(b"solid") for path in EXAMPLES.glob("*.stl"))


def test_the_furnace_has_the_papers_profile_and_room():
    container = load_container(load_scene(EXAMPLES / "furnace.yaml"))
    assert isinstance(container.shape, Polyhedron)
    np.testing.assert_allclose(container.bounds, [[-3.25, -3.25, 0], [3.25, 3.25, 32]], atol=1e-6)
    # Frustums on regular 96-gons, whose area is sin(2 pi / 96) * 48 r^2.
    profile = [(0, 1.2), (7, 3.25), (26, 3.25), (32, 1.0)]
    area = 48 * np.sin(2 * np.pi / 96)
    steps = pairwise(profile)
    volume = sum(area * (b[0] - a[0]) * (a[1] ** 2 + a[1] * b[1] + b[1] ** 2) / 3 for a, b in steps)
    assert container.volume == pytest.approx(volume, rel=1e-6)


def test_fig_9_of_the_paper_loads_with_its_zones():
    scene = load_scene(EXAMPLES / "cone.yaml")
    assert [zone.n_particles for zone in scene.zones] == [200, 300]
    assert scene.zones[0].set_proportions == (0.0, 1.0)
    assert scene.params.n_epoch == 1000


def test_the_burden_alternates_twelve_layers_that_leave_no_gap():
    scene = load_scene(EXAMPLES / "burden.yaml")
    slices = [zone.location.slice for zone in scene.zones]
    assert [zone.set_proportions for zone in scene.zones] == [(1.0, 0.0), (0.0, 1.0)] * 6
    assert all(lower.max_bound == upper.min_bound for lower, upper in pairwise(slices))
    assert {each.material for each in scene.particle_sets} == {"coke", "ore"}


# Coke under ore, ore under coke: how deep the upper layer reaches into the lower one, in the smallest radius
# of both, and the solid fraction across the seam.
# 20 seeds: 3.85 to 3.87 and 0.679 to 0.700; 1.93 to 2.46 and 0.486 to 0.501.
SEAMS = [(3.7, 0.69), (1.6, 0.494)]


@pytest.mark.slow
def test_layers_of_coke_and_ore_interlock_as_poured_ones_do(tmp_path):
    lines = (EXAMPLES / "burden.yaml").read_text().splitlines()
    zones = [line for line in lines if line.startswith("  - {location")]
    # Four layers of the twelve have seams of either kind.
    (tmp_path / "burden.yaml").write_text("\n".join(each for each in lines if each not in zones[4:]))
    folder = tmp_path / "burden"
    assert main([str(tmp_path / "burden.yaml"), "--export", "liggghts", "-o", str(folder), "--quiet"]) == 0
    bed = np.load(folder / "bed.npz")
    height, radius, zone = bed["position"][:, 2], bed["radius"], bed["zone_index"]
    assert zone.max() == 3
    for below in range(3):
        deep, share = SEAMS[below % 2]
        lower, upper = zone == below, zone == below + 1
        # The upper layer's spheres reach down between the uppermost of the lower one.
        depth = (height + radius)[lower].max() - (height - radius)[upper].min()
        assert depth > deep * min(radius[lower].min(), radius[upper].min())
        # Ore fills the hollows of the coke below it; coke is too large for those of ore.
        seam = 0.5 * (height[lower].max() + height[upper].min())
        assert solid_share(bed, seam, 0.4, 0.01) == pytest.approx(share, abs=0.025)
    types = [
        int(line.split()[1])
        for line in (folder / "liggghts/bed.data").read_text().split("Atoms")[1].splitlines()
        if line
    ]
    assert len(set(types)) == 2


def solid_share(bed, height, radius, half):
    """Solid fraction of a disc round z, by points."""
    rng = np.random.default_rng(0)
    across, angle = radius * np.sqrt(rng.random(20_000)), rng.uniform(0.0, 2.0 * np.pi, 20_000)
    points = np.column_stack(
        [across * np.cos(angle), across * np.sin(angle), height + half * rng.uniform(-1, 1, 20_000)]
    )
    near = np.abs(bed["position"][:, 2] - height) < half + bed["radius"].max()
    distance, index = cKDTree(bed["position"][near]).query(points, k=8)
    return float((distance < bed["radius"][near][index]).any(axis=1).mean())


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_scripts_are_sound_and_may_be_run(path):
    assert os.access(path, os.X_OK)
    subprocess.run(["bash", "-n", str(path)], check=True)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["cone", "box"])
def test_an_example_runs_to_a_complete_bed(name, tmp_path):
    assert main([str(EXAMPLES / f"{name}.yaml"), "-o", str(tmp_path / name), "--quiet"]) == 0
    report = json.loads((tmp_path / name / "report.json").read_text())
    assert report["missed"] == []
    if name == "box":
        # 20 seeds: 948 to 1004 spheres, and a core of 0.576 +- 0.007.
        assert 915 <= report["sphere_count"] <= 1015
        assert 0.54 < report["solid_fraction"]["core"] < 0.61


# Number of spheres, where the fraction alone gives it; solid fraction; least distance of two surfaces [m].
DISPERSED = {"fuel": (560, 0.35, 0.02 * 427.5e-6), "concrete": (None, 0.40, 3e-4)}


@pytest.mark.parametrize("name", DISPERSED)
def test_dispersed_examples_have_their_fraction_and_gap(name, tmp_path):
    count, fraction, gap = DISPERSED[name]
    folder = tmp_path / name
    assert main([str(EXAMPLES / f"{name}.yaml"), "--export", "liggghts", "-o", str(folder), "--quiet"]) == 0
    report = json.loads((folder / "report.json").read_text())
    assert report["missed"] == []
    assert report["warnings"] == []
    assert count in (None, report["sphere_count"])
    assert report["solid_fraction"]["filled"] == pytest.approx(fraction, abs=1e-3)
    with np.load(folder / "bed.npz") as bed:
        position, radius = bed["position"], bed["radius"]
    pairs = cKDTree(position).query_pairs(2 * radius.max() + 3 * gap, output_type="ndarray")
    apart = np.linalg.norm(position[pairs[:, 0]] - position[pairs[:, 1]], axis=1) - radius[pairs].sum(axis=1)
    assert gap * (1 - 1e-9) <= apart.min() < 3 * gap
    assert "# No gravity" in (folder / "liggghts" / "in.bed").read_text()


@pytest.mark.slow
def test_the_jammed_example_is_proven(tmp_path):
    folder = tmp_path / "jammed"
    scene = str(EXAMPLES / "jammed.yaml")
    assert main([scene, "--export", "liggghts,lammps,yade", "-o", str(folder), "--quiet"]) == 0
    report = json.loads((folder / "report.json").read_text())
    assert report["missed"] == []
    assert report["warnings"] == []
    assert report["sphere_count"] == 1000
    proof = report["jamming"]
    assert proof["proven"]
    assert proof["isostatic_excess"] == 0
    assert proof["force_residual"] < 1e-10
    assert report["overlap"]["overlap_max"] < 1e-11
    # 20 seeds of 1,000 spheres: 0.6356 to 0.6420.
    assert 0.632 < report["solid_fraction"]["filled"] < 0.648
    assert proof["crystal"] < 0.05
    edge = proof["extent"][0]
    assert f"{edge:.4g}"[:5] in (folder / "lammps" / "bed.data").read_text()


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_the_tube_is_confirmed_by_liggghts(tmp_path):
    folder = tmp_path / "tube"
    assert main([str(EXAMPLES / "tube.yaml"), "--validate", "--quiet", "-o", str(folder)]) == 0
    assert json.loads((folder / "validation.json").read_text())["passed"] is True


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")
def test_a_furnace_of_larger_spheres_stands_in_liggghts(tmp_path):
    text = (EXAMPLES / "furnace.yaml").read_text()
    # A model furnace, its mesh read in inches, with spheres 2.5 times as large for its size: at E = 1e8 Pa
    # the full height is compressed by its own weight by percents, whatever the packing.
    changes = (
        ("units: m", "units: in"), ("430062", "2500"), ("0.052", "0.0033"), ("0.075", "0.00476"),
    )  # fmt: skip
    for found, wanted in changes:
        assert text.count(found) == 1
        text = text.replace(found, wanted)
    text += "validation: {free_fall_times: 8}\n"
    (tmp_path / "furnace.yaml").write_text(text)
    shutil.copy(EXAMPLES / "furnace.stl", tmp_path)
    folder = tmp_path / "out"
    assert main([str(tmp_path / "furnace.yaml"), "--validate", "--quiet", "-o", str(folder)]) == 0
    validation = json.loads((folder / "validation.json").read_text())
    assert validation["passed"] is True
    assert validation["solvers"]["liggghts"]["sphere_count"] == 2500


@pytest.mark.parametrize(("name", "part", "faces"), [("silo", "outlet", 48), ("column", "gate", 2)])
def test_the_examples_with_named_walls_have_a_wall_that_is_removed(name, part, faces):
    container = load_container(load_scene(EXAMPLES / f"{name}.yaml"))
    assert [(each.name, each.remove, len(each.faces)) for each in container.parts] == [(part, True, faces)]


def let_go(name, folder, more, *keys):
    """Positions and ids at the end of the bed of an example whose wall LIGGGHTS has removed [m]."""
    arguments = [str(EXAMPLES / f"{name}.yaml"), "-o", str(folder / "bed"), "--export", "liggghts", "--quiet"]
    assert main([*arguments, "--no-report", *keys]) == 0
    deck = folder / "bed/liggghts"
    variables = {"steps": 200, "steps_open": more, "dump_every": 200}
    listed = [word for key, value in variables.items() for word in ("-var", key, str(value))]
    done = subprocess.run(
        ["stdbuf", "-oL", "liggghts", "-in", "in.bed", "-log", "none", *listed],
        cwd=deck, capture_output=True, text=True, errors="replace", timeout=600, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:]
    ends = []
    for step in (200, 200 + more):
        rows = (deck / f"post/bed_{step}.dump").read_text().split("radius \n")[1].splitlines()
        ends.append(np.array([row.split()[2:5] for row in rows], float))
    return ends


needs_liggghts = pytest.mark.skipif(shutil.which("liggghts") is None, reason="liggghts is not installed")


@pytest.mark.slow
@pytest.mark.solver
@needs_liggghts
def test_the_silos_grains_flow_out_once_its_outlet_is_removed(tmp_path):
    shut, opened = let_go("silo", tmp_path, 3000, "--set", "zones[0].n_particles=1000")
    assert len(shut) == 1000
    assert shut[:, 2].min() > 0.0075
    gone = 1000 - len(opened)  # they have left the solver's box
    assert gone + (opened[:, 2] < 0.0).sum() >= 20


@pytest.mark.slow
@pytest.mark.solver
@needs_liggghts
def test_the_column_collapses_once_its_gate_is_removed(tmp_path):
    stands, fallen = let_go("column", tmp_path, 4000)
    assert stands[:, 0].max() < 0.0965
    assert len(fallen) == len(stands)
    assert (fallen[:, 0] > 0.1).mean() > 0.1
