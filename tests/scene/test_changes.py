"""Values in place of a scene's: the same checks and words as those of the file, with another place."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.errors import SceneError
from packgen.scene import load_scene
from tests.seeds import raised

SCENE = """
container: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
particle_sets:
  - {name: fine, radius_distribution: constant, radius: 0.05}
  - {name: coarse, radius_distribution: constant, radius: 0.1}
zones:
  - {n_particles: 20, set_proportions: [0.5, 0.5]}
  - {n_particles: 10, set_proportions: [1, 0]}
"""


@pytest.fixture
def path(tmp_path):
    (tmp_path / "box.yaml").write_text(SCENE)
    return tmp_path / "box.yaml"


def faults_of(source, *changes):
    with pytest.raises(SceneError) as caught:
        load_scene(source, changes)
    return list(caught.value.problems)


def test_values_are_yaml_and_go_where_their_path_says(path):
    scene = load_scene(
        path,
        [
            "zones[1].n_particles=500",
            "particle_sets[0].radius=20 mm",
            "container={cylinder: {radius: 1, height: 2}}",
            "materials.glass.friction=0.1",
            "params.tolerance=null",
            "seed = 3",
        ],
    )
    assert [zone.n_particles for zone in scene.zones] == [20, 500]
    assert scene.particle_sets[0].distribution.radius_bounds == (0.02, 0.02)
    assert scene.container.cylinder.height == 2.0
    assert scene.materials[0].friction == 0.1
    assert (scene.tolerance, scene.seed) == (None, raised(3))


def test_the_last_change_of_a_place_counts_and_later_ones_build_on_it(path):
    scene = load_scene(path, ["zones=[{}]", "zones[0].n_particles=5", "zones[0].n_particles=7"])
    assert [zone.n_particles for zone in scene.zones] == [7]


def test_the_only_zone_of_a_scene_without_zones_can_be_given(tmp_path):
    path = tmp_path / "box.yaml"
    path.write_text(SCENE.partition("zones:")[0])
    assert [zone.n_particles for zone in load_scene(path, ["zones[0].n_particles=4"]).zones] == [4]


def test_a_change_of_an_alias_leaves_its_anchor_alone(tmp_path):
    path = tmp_path / "box.yaml"
    path.write_text(SCENE.replace("  - {n_particles: 20", "  - &a {n_particles: 20") + "  - *a\n")
    scene = load_scene(path, ["zones[2].n_particles=5"])
    assert [zone.n_particles for zone in scene.zones] == [20, 10, 5]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("zones[0].n_particles=-5", "--set zones[0].n_particles: found -5, expected a whole number from 1"),
        ("zones[0].n_particels=5", "--set zones[0].n_particels: found an unknown key, expected one of"),
        ("zones[0].n_particels=5", "did you mean n_particles?"),
        ("zone.x=5", "--set zone.x: zone: found an unknown key"),
        ("particle_sets[0].radius=5 furlongs", "--set particle_sets[0].radius: found '5 furlongs'"),
        (
            "zones[0].set_proportions=[1, 1]",
            "--set zones[0].set_proportions: found [1.0, 1.0], expected numbers",
        ),
        ("zones[0]={n_particles: 0}", "--set zones[0]: zones[0].n_particles: found 0, expected a whole"),
        ("zones[2].mass=1", "--set zones[2].mass: found index 2, expected 0 to 1: zones has 2 items"),
        (
            "zones.mass=1",
            "--set zones.mass: found the key mass of a list, expected an index, such as zones[0].mass",
        ),
        ("container[0]=1", "--set container[0]: found an index of container, which is no list"),
        ("zones[0].n_particles.x=1", "--set zones[0].n_particles.x: found 20 at zones[0].n_particles"),
        ("seed", "--set: found 'seed', expected KEY=VALUE, such as --set zones[0].n_particles=500"),
        ("=3", "--set: found '=3', expected KEY=VALUE"),
        ("zones[0=3", "--set: found 'zones[0=3', expected KEY=VALUE"),
        ("zones=[1, 2", "--set zones: found '[1, 2', expected a value as YAML has it"),
        ("seed=1\n---\n2", "--set seed: found '1\\n---\\n2', expected a value as YAML has it"),
    ],
)
def test_a_fault_names_the_option_and_the_path_once(path, change, said):
    lines = faults_of(path, change)
    assert any(said in line for line in lines), lines
    assert all("\n" not in line for line in lines)


def test_all_faults_of_options_and_file_come_at_once(path):
    path.write_text(SCENE.replace("radius: 0.1", "radius: -1"))
    lines = faults_of(path, "seed=x", "zones[7].mass=1", "gravity=0", "nonsense")
    assert len(lines) == 5
    assert sum("--set" in line for line in lines) == 4
    assert sum("box.yaml:5:" in line for line in lines) == 1


def test_faults_that_several_values_have_together_name_the_option(path):
    assert faults_of(path, "zones[1].set_proportions=[1]") == [
        "--set zones[1].set_proportions: found 1 number, expected 2, one for each of particle_sets"
    ]


def test_a_mapping_is_a_scene_as_its_file_is(path):
    scene = load_scene(
        {
            "container": {"box": {"min": np.zeros(3), "max": (1, 1, 1)}},
            "particle_sets": [{"radius_distribution": "constant", "radius": np.float64(0.05)}],
            "zones": [{"n_particles": np.int64(20)}],
        }
    )
    assert scene.zones[0].n_particles == 20
    assert scene.path.name == "scene"


def test_faults_of_a_mapping_name_the_path():
    lines = faults_of({"container": {"box": {"min": [0, 0, 0], "max": [1, 1, 1]}}, "particle_sets": []})
    assert lines == ["scene: particle_sets: found [], expected a list of at least one"]
