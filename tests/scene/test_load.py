"""Claims on the scene file: the contract's keys, in SI, with defaults; every fault with its place."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from pydantic import BaseModel

from packgen.arrange.collective.params import Params
from packgen.arrange.spheres import Spheres
from packgen.arrange.task import Task
from packgen.bed import Material
from packgen.errors import SceneError
from packgen.scene import BoxSpec, ConeSpec, CylinderSpec, SphereSpec
from packgen.values import Count, Flag, Keys, Tolerance
from tests.scene.texts import BOX, SETS, load
from tests.scenes import box, constant, read_scene
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


class Drops(Keys):
    """Settings of a plug-in."""

    drops: Count
    fast: Flag = False
    tolerance: Tolerance | None = 1.0e-3


class Plain(BaseModel):
    """Settings of a plug-in that knows pydantic only."""

    drops: int = 1


def rain(task: Task) -> Spheres:
    raise NotImplementedError(task)


@pytest.fixture
def plugins(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Algorithms of third parties by name; what a test puts in is found."""
    known: dict[str, Any] = {}

    class Entry:
        value = "somewhere"

        def __init__(self, name: str) -> None:
            self.name = name

        def load(self) -> Any:
            return known[self.name]

    monkeypatch.setattr(
        "packgen.arrange.registry.entry_points", lambda group: [Entry(name) for name in known]
    )
    return known


RAIN = BOX + SETS + "algorithm: acme.RAIN\n"


def test_an_algorithm_without_a_model_gets_its_params_as_they_are(
    tmp_path: Path, plugins: dict[str, Any]
) -> None:
    plugins["acme.RAIN"] = rain
    scene = load(tmp_path, RAIN + "params: {drops: 3, mode: {fast: true}, tolerance: 0.01}\n")
    assert scene.params == {"drops": 3, "mode": {"fast": True}, "tolerance": 0.01}
    assert scene.tolerance == 0.01
    assert scene.model_dump()["params"] == scene.params
    assert (load(tmp_path, RAIN).params, load(tmp_path, RAIN).tolerance) == ({}, 1e-6)


def test_an_algorithm_with_a_model_gets_an_instance_of_it(tmp_path: Path, plugins: dict[str, Any]) -> None:
    plugins["acme.RAIN"] = SimpleNamespace(arrange=rain, Params=Drops)
    scene = load(tmp_path, RAIN + "params: {drops: 3}\n")
    assert (scene.params.drops, scene.params.fast, scene.tolerance) == (3, False, 1e-3)
    assert scene.model_dump()["params"] == {"drops": 3, "fast": False, "tolerance": 1e-3}


@pytest.mark.parametrize("model", [Drops, Plain])
def test_unknown_params_of_a_plug_in_are_refused_with_their_place(
    tmp_path: Path, plugins: dict[str, Any], model: type[BaseModel]
) -> None:
    plugins["acme.RAIN"] = SimpleNamespace(arrange=rain, Params=model)
    with pytest.raises(SceneError, match=r"scene\.yaml:\d:10: params\.dropz: found an unknown key, .*drops"):
        load(tmp_path, RAIN.replace("algorithm", "params: {dropz: 3, drops: 3}\nalgorithm"))


@pytest.mark.parametrize(
    ("given", "found"),
    [
        ("params: {drops: none}", r":5:17: params\.drops: found 'none', expected a whole number"),
        ("", r": params\.drops: found nothing, expected this key and a value"),
        ("params: {drops: 1, tolerance: -1}", r":5:31: params\.tolerance: found -1"),
    ],
)
def test_params_of_a_plug_in_are_held_against_its_model(
    tmp_path: Path, plugins: dict[str, Any], given: str, found: str
) -> None:
    plugins["acme.RAIN"] = SimpleNamespace(arrange=rain, Params=Drops)
    with pytest.raises(SceneError, match=found):
        load(tmp_path, RAIN + given)


def test_a_tolerance_is_held_against_its_bounds_even_without_a_model(
    tmp_path: Path, plugins: dict[str, Any]
) -> None:
    plugins["acme.RAIN"] = rain
    with pytest.raises(SceneError, match=r":5:21: params\.tolerance: found 'tight'"):
        load(tmp_path, RAIN + "params: {tolerance: tight}")


def test_an_unknown_algorithm_is_one_fault_among_the_others(tmp_path: Path) -> None:
    with pytest.raises(SceneError) as caught:
        load(tmp_path, RAIN + "gravity: heavy\nparams: {anything: 1}\n")
    first, second = caught.value.problems
    assert "algorithm: found 'acme.RAIN', expected one of COLLECTIVE_ARRANGEMENT, ADAM" in first
    assert "gravity: found 'heavy'" in second


def test_the_settings_of_the_paper_are_those_of_the_algorithm_adam_too(tmp_path: Path) -> None:
    paper = "params: {batch_size: 100, lr: 0.02, alpha: 50, verbosity: 5"
    own = load(tmp_path, BOX + SETS + f"{paper}, optimizer: adam}}\n").params
    alone = load(tmp_path, BOX + SETS + f"algorithm: ADAM\n{paper}}}\n").params
    assert own.model_dump(exclude={"optimizer", "tile"}) == alone.model_dump()


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


@pytest.mark.parametrize("tilt", [1e-300, 1e-9, 9e-7])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_gravity_a_hair_off_an_axis_points_along_the_axis(tmp_path, axis, tilt):
    vector = [tilt, -tilt, tilt]
    vector[axis] = -2.0
    scene, _ = read_scene(tmp_path, box((0, 0, 0), (1, 1, 1)), constant(0.1), gravity_axis=vector)
    wanted = [0.0, 0.0, 0.0]
    wanted[axis] = -1.0
    assert list(scene.gravity_direction) == wanted


def test_a_tilt_of_gravity_that_is_more_than_rounding_stays(tmp_path):
    scene, _ = read_scene(tmp_path, box((0, 0, 0), (1, 1, 1)), constant(0.1), gravity_axis=[2e-6, 0.0, -1.0])
    assert scene.gravity_direction[0] == pytest.approx(2e-6)
