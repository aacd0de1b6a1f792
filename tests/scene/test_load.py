"""Claims on the scene file: the contract's keys, in SI, with defaults; every fault with its place."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest

from packgen.bed import Material
from packgen.scene import BoxSpec, ConeSpec, CylinderSpec, Params, SphereSpec
from tests.scene.texts import BOX, SETS, load
from tests.seeds import raised

# Fig. 9 of the paper, with the blanks that its print has in some keys.
FIGURE_9 = """\
container:
   path: "cone.stl"
algorithm: "COLLECTIVE_ARRANGEMENT"
params:
    lr: 0.01
    n_epoch: 1000
    patience: 50
    verbosity: 10
gravity_axis: z
particle_sets:
 - radius distribution: "uniform"
   radius_min: 0.05
   radius_max: 0.08
 - radius_distribution: "normal"
   radius_mean: 0.04
   radius_std_dev: 0.005
zones:
 - n particles: 200
   location:
           path: "sphere.stl"
   set proportions: [0.0, 1.0,]
 - n_particles: 300
   location:
        slice:
            axis: 2
            min bound: 0.8
            max_bound: 1.5
   set_proportions: [1.0, 0.0]
"""


def test_the_papers_example_loads_as_printed(tmp_path: Path) -> None:
    scene = load(tmp_path, FIGURE_9)
    assert scene.container.path == tmp_path / "cone.stl"
    assert (scene.params.lr, scene.params.n_epoch, scene.params.patience) == (0.01, 1000, 50)
    assert scene.gravity_direction == (0.0, 0.0, -1.0)
    assert [each.distribution.radius_bounds for each in scene.particle_sets] == [
        (0.05, 0.08),
        pytest.approx((0.02, 0.06)),
    ]
    sphere, layer = scene.zones
    assert (sphere.n_particles, layer.n_particles) == (200, 300)
    assert sphere.location is not None
    assert sphere.location.path == tmp_path / "sphere.stl"
    assert layer.location is not None
    assert layer.location.slice is not None
    assert layer.location.slice.axis == (0.0, 0.0, 1.0)
    assert (layer.location.slice.min_bound, layer.location.slice.max_bound) == (0.8, 1.5)
    assert sphere.set_proportions == (0.0, 1.0)
    assert scene.mark("zones[1].location.slice.axis").endswith("scene.yaml:25:19")


def test_a_short_scene_gets_the_contracts_defaults(tmp_path: Path) -> None:
    scene = load(tmp_path, BOX + SETS + "zones:\nparams:\n")
    assert scene.params == Params(
        optimizer="projection", batch_size=None, lr=0.01, n_epoch=2000, patience=50, alpha=100.0, beta=10.0,
        gamma=100.0, tolerance=1e-6, verbosity=10,
    )  # fmt: skip
    assert (scene.gravity, scene.seed, scene.algorithm) == (9.81, raised(0), "COLLECTIVE_ARRANGEMENT")
    assert scene.materials == (Material("default"),)
    assert scene.wall_material == "default"
    assert [(each.name, each.density, each.material) for each in scene.particle_sets] == [
        ("set_0", 2500.0, "default")
    ]
    (zone,) = scene.zones
    assert (zone.n_particles, zone.volume, zone.mass, zone.location) == (None, None, None, None)
    assert zone.set_proportions == (1.0,)
    assert (scene.validation.force_limit, scene.validation.work_budget) == (1.0, 2.0e9)


@pytest.mark.parametrize(
    ("text", "primitive"),
    [
        ("box: {min: [0, 0, 0], max: [2, 2, '300 cm']}", BoxSpec(min=(0, 0, 0), max=(2, 2, 3))),
        ("cylinder: {radius: 500 mm, height: 4.0, axis: y}", CylinderSpec(radius=0.5, height=4, axis="y")),
        (
            "cone: {radius_bottom: 0, radius_top: 1, height: 3, base: [1, 2, 3], axis: [0, 0, -2]}",
            ConeSpec(radius_bottom=0, radius_top=1, height=3, base=(1, 2, 3), axis="-z"),
        ),
        ("sphere: {radius: 1.0, center: [0, 0, 1]}", SphereSpec(radius=1, center=(0, 0, 1))),
    ],
)
def test_each_primitive_loads_as_container_and_as_location(
    tmp_path: Path, text: str, primitive: object
) -> None:
    scene = load(tmp_path, f"container: {{{text}}}\n{SETS}zones:\n  - location: {{{text}}}\n")
    assert scene.container.primitive == primitive
    assert scene.zones[0].location is not None
    assert scene.zones[0].location.primitive == primitive


def test_mesh_keys_and_periodic_axes_arrive(tmp_path: Path) -> None:
    scene = load(tmp_path, "container: {path: cone.stl, units: mm, shape: convex_hull}\n" + SETS)
    assert (scene.container.scale, scene.container.shape) == (1e-3, "convex_hull")
    box = BOX.replace("}}", "}, periodic: [x, z]}")
    assert load(tmp_path, box + SETS).container.periodic == (True, False, True)


@pytest.mark.parametrize(
    ("axis", "direction"),
    [("z", (0, 0, -1)), ("-y", (0, 1, 0)), ("x", (-1, 0, 0)), ("[0, 3, -4]", (0, 0.6, -0.8))],
)
def test_letters_point_up_and_vectors_point_down(
    tmp_path: Path, axis: str, direction: tuple[float, ...]
) -> None:
    scene = load(tmp_path, f"{BOX}{SETS}gravity_axis: {axis}\n")
    assert scene.gravity_direction == pytest.approx(direction)
    assert math.hypot(*scene.gravity_direction) == pytest.approx(1.0, abs=1e-15)


def test_every_law_of_sizes_loads(tmp_path: Path) -> None:
    (tmp_path / "radii.csv").write_text("# made by hand\nid;Radius\n1;0.01\n2;0.03\n")
    laws = """\
particle_sets:
  - {radius_distribution: constant, radius: 12 mm}
  - {radius_distribution: uniform, radius_min: 0.01, radius_max: 0.02}
  - {radius_distribution: normal, radius_mean: 0.01, radius_std_dev: 1e-3, radius_min: 0.009}
  - {radius_distribution: lognormal, radius_median: 0.01, sigma: 0.3, radius_max: 0.02}
  - {radius_distribution: rosin_rammler, radius_63: 0.02, exponent: 3, radius_min: 0.01, radius_max: 0.04}
  - {radius_distribution: sieve, diameters: [20 mm, 40 mm, 80 mm], passing: [0, 0.4, 1]}
  - {radius_distribution: discrete, radii: [0.01, 0.02], fractions: [0.25, 0.75], by: mass}
  - {radius_distribution: file, path: radii.csv}
"""
    bounds = [each.distribution.radius_bounds for each in load(tmp_path, BOX + laws).particle_sets]
    expected = [
        (0.012, 0.012), (0.01, 0.02), (0.009, 0.014), (0.01 * math.exp(-1.2), 0.02), (0.01, 0.04),
        (0.01, 0.04), (0.01, 0.02), (0.01, 0.03),
    ]  # fmt: skip
    assert bounds == [pytest.approx(each) for each in expected]


def test_materials_are_declared_ones_then_used_ones(tmp_path: Path) -> None:
    text = BOX + SETS.replace("}", ", material: ore}") + "wall_material: steel\n"
    assert [each.name for each in load(tmp_path, text).materials] == ["ore", "steel"]
    declared = "materials: {steel: {youngs_modulus: 200 MPa}, ore: {friction: 0.7}}\n"
    scene = load(tmp_path, text + declared)
    assert scene.materials == (Material("steel", youngs_modulus=2e8), Material("ore", friction=0.7))


def test_settings_of_another_algorithm_are_passed_on_as_they_are(tmp_path: Path) -> None:
    scene = load(tmp_path, BOX + SETS + "algorithm: acme.RAIN\nparams: {drops: 3, mode: {fast: true}}\n")
    assert scene.algorithm == "acme.RAIN"
    assert scene.raw_params == {"drops": 3, "mode": {"fast": True}}
    assert scene.model_dump()["params"] == {"drops": 3, "mode": {"fast": True}}


def test_files_without_proportions_use_each_of_their_spheres(tmp_path: Path) -> None:
    (tmp_path / "a.txt").write_text("0.01\n0.02\n0.03\n")
    (tmp_path / "b.txt").write_text("0.01\n")
    files = [f"{{radius_distribution: file, path: {name}.txt}}" for name in "ab"]
    sets = f"particle_sets: [{', '.join(files)}]\n"
    assert load(tmp_path, BOX + sets).zones[0].set_proportions == (0.75, 0.25)


def test_reading_a_scene_loads_nothing_heavy(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(BOX + SETS)
    code = (
        "import sys; from pathlib import Path; from packgen.scene import load_scene;"
        "load_scene(Path(sys.argv[1]));"
        "print([name for name in ('torch', 'trimesh', 'scipy', 'numba', 'meshio') if name in sys.modules])"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "scene.yaml")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "[]\n"
