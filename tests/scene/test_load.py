# ruff: noqa: E501 (each row of the tables of faults stays on one line)
"""Claims on the scene file: the contract's keys, in SI, with defaults; every fault with its place."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest

from packgen.bed import Material
from packgen.errors import SceneError
from packgen.scene import BoxSpec, ConeSpec, CylinderSpec, Params, Scene, SphereSpec, load_scene

BOX = "container: {box: {min: [0, 0, 0], max: [2, 2, 2]}}\n"
SETS = "particle_sets:\n  - {radius_distribution: uniform, radius_min: 0.05, radius_max: 0.08}\n"

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


def load(folder: Path, text: str) -> Scene:
    path = folder / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    for name in ("cone.stl", "sphere.stl"):
        (folder / name).touch()
    return load_scene(path)


def problems(folder: Path, text: str) -> list[str]:
    """Return the faults without the folder."""
    with pytest.raises(SceneError) as caught:
        load(folder, text)
    return [each.replace(str(folder) + "/", "") for each in caught.value.problems]


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
    assert (scene.gravity, scene.seed, scene.algorithm) == (9.81, 0, "COLLECTIVE_ARRANGEMENT")
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


def test_all_faults_are_shown_at_once_in_the_order_of_the_file(tmp_path: Path) -> None:
    text = """\
container: {path: nope.stl, unit: mm}
gravity: -9.81
seed: 1.5
params:
  lr: .nan
  optimiser: adam
particle_sets:
  - radius_distribution: unifrom
  - {radius_distribution: uniform, radius_min: 12 mm, radius_max: 8 mm, material: iron}
materials: {ore: {}}
zones:
  - n_particles: 0
  - {volume: 1, mass: 2, set_proportions: [1]}
extra: 1
"""
    found = problems(tmp_path, text)
    starts = [each.rsplit(": found", 1)[0] for each in found]
    assert starts == [
        "scene.yaml:1:19: container.path", "scene.yaml:1:29: container.unit", "scene.yaml:2:10: gravity",
        "scene.yaml:3:7: seed", "scene.yaml:5:7: params.lr", "scene.yaml:6:3: params.optimiser",
        "scene.yaml:8:26: particle_sets[0].radius_distribution",
        "scene.yaml:9:67: particle_sets[1].radius_max",
        "scene.yaml:9:83: particle_sets[1].material", "scene.yaml:12:18: zones[0].n_particles",
        "scene.yaml:13:23: zones[1].mass", "scene.yaml:13:43: zones[1].set_proportions",
        "scene.yaml:14:1: extra",
    ]  # fmt: skip
    assert "did you mean units?" in found[1]
    assert "did you mean optimizer?" in found[5]
    assert "found 'unifrom'" in found[6]
    assert "did you mean uniform?" in found[6]


SET = "{radius_distribution: constant, radius: 0.1%s}"
FAULTS = [
    ("gravity_axis: w", "2:15: gravity_axis: found 'w', expected x, y, z, -x, -y, -z or a vector"),
    ("gravity_axis: [0, 0, 0]", "gravity_axis: found [0, 0, 0], expected a vector that is not zero"),
    ("gravity_axis: [0, 0, .inf]", "gravity_axis: found [0, 0, inf], expected a finite number"),
    ("gravity: yes", "gravity: found 'yes', expected a number"),
    ("seed: -1", "seed: found -1, expected a whole number from 0"),
    ("seed: true", "seed: found true, expected a whole number"),
    ("algorithm: 'a b'", "algorithm: found 'a b', expected a name of at most 64 letters"),
    ("params: {tolerance: 0}", "params.tolerance: found 0, expected a number greater than 0 and below 1"),
    ("params: {batch_size: 1e99}", "params.batch_size: found 1e+99, expected a whole number"),
    ("params: [1]", "params: found [1], expected a mapping of keys"),
    ("zones: []", "zones: found [], expected a list of at least one"),
    ("zones: [3]", "zones[0]: found 3, expected a mapping of keys"),
    ("zones: [{volume: -1}]", "zones[0].volume: found -1, expected a number greater than 0"),
    ("zones: [{volume: 1e-12}]", "zones[0].volume: found 1e-12, expected at least that of one sphere"),
    ("zones: [{set_proportions: [0.5]}]", "expected numbers that add up to 1, not to 0.5"),
    ("zones: [{set_proportions: [.nan]}]", "zones[0].set_proportions[0]: found nan, expected a finite number"),
    ("zones: [{set_proportions: [2]}]", "zones[0].set_proportions[0]: found 2, expected a number from 0 to 1"),
    ("zones: [{proportions_by: weight}]", "found 'weight', expected one of mass, number, volume"),
    ("zones: [{location: {}}]", "zones[0].location: found none of them, expected exactly one of path, slice"),
    ("zones: [{location: {slice: {axis: 3, min_bound: 0, max_bound: 1}}}]", "slice.axis: found 3, expected 0, 1, 2"),
    ("zones: [{location: {slice: {axis: x, min_bound: 1, max_bound: 0}}}]", "max_bound: found 0.0, expected more"),
    ("zones: [{location: {slice: {axis: x, min_bound: 1}}}]", "slice.max_bound: found nothing, expected this key"),
    ("zones: [{location: {periodic: [x], sphere: {radius: 1}}}]", "location.periodic: found an unknown key"),
    ("materials: {\"o're\": {}}", "letters (A-Z, a-z), digits"),
    ("materials: {ore: {poissons_ratio: 0.6}}", "materials.ore.poissons_ratio: found 0.6, expected a number from"),
    ("materials: {ore: {}}\nwall_material: iron", "wall_material: found 'iron', expected one of the materials: ore"),
    ("validation: {lost_limit: -1}", "validation.lost_limit: found -1, expected a whole number from 0"),
]  # fmt: skip


@pytest.mark.parametrize(("line", "words"), FAULTS, ids=[line for line, _ in FAULTS])
def test_an_impossible_value_is_one_line_with_place_value_and_expectation(
    tmp_path: Path, line: str, words: str
) -> None:
    found = problems(tmp_path, f"{BOX}{line}\nparticle_sets: [{SET % ''}]\n")
    assert len(found) == 1
    assert found[0].startswith("scene.yaml:")
    assert words in found[0]


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (", density: 0", "density: found 0, expected a number greater than 0"),
        (", density: 2 kg", "density: found '2 kg', expected a number, or a number with a unit (kg/m3"),
        (', name: "a\\nb"', "name: found 'a\\nb', expected a name of at most 64 letters"),
        (', name: "run; rm"', "name: found 'run; rm', expected a name"),
        (", name: 12", "put a name that looks like a number into quotes"),
        (", material: '$x'", "material: found '$x', expected a name"),
        (
            ", radius_min: 1",
            "radius_min: found an unknown key, expected one of density, material, name, radius",
        ),
    ],
)
def test_a_set_says_what_is_wrong_with_it(tmp_path: Path, more: str, words: str) -> None:
    (found,) = problems(tmp_path, f"{BOX}particle_sets: [{SET % more}]\n")
    assert words in found
    assert "particle_sets[0]." in found


@pytest.mark.parametrize(
    ("law", "words"),
    [
        ("constant, radius: 0", "radius: found 0, expected a number greater than 0"),
        ("constant, radius: 1e999", "radius: found inf, expected a finite number"),
        ("constant", "radius: found nothing, expected this key and a value"),
        ("uniform, radius_min: 2, radius_max: 1", "radius_max: found 1.0, expected at least radius_min = 2"),
        (
            "normal, radius_mean: 1, radius_std_dev: 0.1, radius_min: 5, radius_max: 6",
            "a millionth of the spheres",
        ),
        (
            "normal, radius_mean: 1, radius_std_dev: 0.1, radius_min: 1, radius_max: 1",
            "expected more than radius_min",
        ),
        (
            "lognormal, radius_median: 1, sigma: 50",
            "sigma: found 50.0, expected the standard deviation of ln",
        ),
        ("rosin_rammler, radius_63: 1, exponent: 9, radius_min: 7, radius_max: 8", "a billionth of the mass"),
        ("sieve, diameters: [1], passing: [1]", "at least two diameters"),
        (
            "sieve, diameters: [1, 2], passing: [0, 0.5, 1]",
            "passing: found 3 fractions, expected 2 fractions",
        ),
        (
            "sieve, diameters: [1, 3, 2], passing: [0, 0.5, 1]",
            "diameters[2]: found 2.0, expected diameters in rising",
        ),
        (
            "sieve, diameters: [1, 2, 3], passing: [0.5, 0.2, 1]",
            "passing[1]: found 0.2, expected fractions that rise",
        ),
        ("sieve, diameters: [1, 2], passing: [0, 0.9]", "passing[1]: found 0.9, expected 1 at the largest"),
        (
            "sieve, diameters: [1, 2], passing: [0, 100]",
            "passing[1]: found 100, expected a number from 0 to 1",
        ),
        ("discrete, radii: [1, 2], fractions: [0.4, 0.5]", "fractions that add up to 1, not to 0.9"),
        ("discrete, radii: [1, 1], fractions: [0.5, 0.5]", "each radius once"),
        ("discrete, radii: [], fractions: []", "radii: found [], expected a list of numbers"),
        ("file, path: absent.txt", "expected a file that exists"),
        ("file, path: .", "is a directory"),
        ("file, path: bad.txt", "found '-1' in"),
    ],
)
def test_a_law_says_what_is_wrong_with_it(tmp_path: Path, law: str, words: str) -> None:
    (tmp_path / "bad.txt").write_text("0.1\n-1\n")
    found = problems(tmp_path, f"{BOX}particle_sets: [{{radius_distribution: {law}}}]\n")
    assert any(words in each for each in found)
    assert all("particle_sets[0]." in each for each in found)


@pytest.mark.parametrize(
    ("container", "words"),
    [
        ("{}", "container: found none of them, expected exactly one of path, box, cylinder, cone, sphere"),
        (
            "{path: cone.stl, sphere: {radius: 1}}",
            "container.sphere: found path and sphere, expected exactly one",
        ),
        ("{sphere: {radius: 1}, units: mm}", "container.units: found mm, expected this key only beside path"),
        (
            "{sphere: {radius: 1}, periodic: [x]}",
            "container.periodic: found ['x'], expected this key only beside box",
        ),
        ("{box: {min: [0, 0, 0], max: [1, 0, 1]}}", "expected a corner above min = [0.0, 0.0, 0.0] along y"),
        ("{box: {min: [0, 0], max: [1, 0, 1]}}", "box.min: found [0, 0], expected a list of three lengths"),
        ("{cone: {radius_bottom: 0, radius_top: 0, height: 1}}", "expected a radius greater than 0 at one"),
        ("{path: .}", "expected a file, but"),
        ('{path: "a\\0b"}', "expected the path of a file"),
        ("{path: " + "x" * 5000 + "}", "a file that can be read; File name too long"),
        ("{path: cone.stl, units: km}", "found 'km', expected one of cm, ft, in, m, mm, um"),
    ],
)
def test_a_container_says_what_is_wrong_with_it(tmp_path: Path, container: str, words: str) -> None:
    (found,) = problems(tmp_path, f"container: {container}\n{SETS}")
    assert words in found


def test_missing_sections_are_missed_by_name(tmp_path: Path) -> None:
    found = problems(tmp_path, "seed: 1\n")
    assert [each.split(": found")[0] for each in found] == [
        "scene.yaml:1:1: container",
        "scene.yaml:1:1: particle_sets",
    ]
    assert "expected a mapping with the keys container" in problems(tmp_path, "just words")[0]
    assert "expected a mapping with the keys container" in problems(tmp_path, "")[0]


def test_two_sets_cannot_share_a_name(tmp_path: Path) -> None:
    sets = f"particle_sets: [{SET % ', name: set_1'}, {SET % ''}]\n"
    (found,) = problems(tmp_path, BOX + sets)
    assert "particle_sets[1]" in found
    assert "a name that no other set has" in found


def test_a_file_of_radii_cannot_give_more_spheres_than_it_has(tmp_path: Path) -> None:
    (tmp_path / "radii.txt").write_text("0.1\n0.2\n")
    sets = "particle_sets: [{radius_distribution: file, path: radii.txt}]\n"
    for amount in ("n_particles: 3", "volume: 1", "mass: 2000"):
        (found,) = problems(tmp_path, f"{BOX}{sets}zones: [{{{amount}}}]\n")
        assert "the file of radii has 2 spheres" in found
    assert load(tmp_path, f"{BOX}{sets}zones: [{{n_particles: 2}}]\n").zones[0].n_particles == 2


def test_reading_a_scene_loads_nothing_heavy(tmp_path: Path) -> None:
    (tmp_path / "scene.yaml").write_text(BOX + SETS)
    code = (
        "import sys; from pathlib import Path; from packgen.scene import load_scene;"
        "load_scene(Path(sys.argv[1]));"
        "print([name for name in ('torch', 'trimesh', 'scipy', 'numba', 'meshio') if name in sys.modules])"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "scene.yaml")]
    assert subprocess.run(command, capture_output=True, text=True, check=True).stdout == "[]\n"
