"""The JSON Schema of scenes: it takes what packgen takes, and refuses wrong keys and values."""

from __future__ import annotations

import json

import pytest

from packgen.arrange.registry import BUILTIN
from packgen.scene import load_scene
from packgen.scene.schema import scene_schema
from packgen.scene.yamlmarks import parse_yaml, read_yaml
from tests.scene.json_schema import faults
from tests.snippets import ROOT

SCHEMA = scene_schema()
EXAMPLES = sorted((ROOT / "examples").glob("*.yaml"))
WHOLE = """
container: {box: {min: [0, 0, 0], max: [1, "100 cm", 1]}, periodic: [x, y]}
gravity_axis: -z
gravity: 9.81
seed: 3
algorithm: COLLECTIVE_ARRANGEMENT
params: {tolerance: null, tile: auto, optimizer: projection}
particle_sets:
  - {radius_distribution: sieve, diameters: [4 mm, 8mm, 1e-2], passing: [0, 0.4, 1], density: 2.6 g/cm³}
  - {name: b, radius_distribution: normal, radius_mean: 3e3 µm, radius_std_dev: 0.001, radius_min: null}
materials: {stone: {friction: 0.3, youngs_modulus: 10 MPa}}
wall_material: stone
zones:
  - {n_particles: 3, location: {slice: {axis: 2, min_bound: 0, max_bound: 50 cm}}, set_proportions: [1, 0]}
  - {volume: 2 l, set_proportions: [0.5, 0.5], proportions_by: mass}
validation:
"""
DISPERSED = """
algorithm: DISPERSED
container: {sphere: {radius: 1}}
particle_sets: [{radius_distribution: constant, radius: 0.05}]
zones: [{porosity: {value: 0.7, of: core}, gap: 1 mm}, {solid_fraction: 0.3, gap: 0.1}]
"""


def wrong(text: str) -> list[str]:
    return faults(parse_yaml(text, "scene").data, SCHEMA, SCHEMA)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.name)
def test_every_example_is_valid(path):
    assert faults(read_yaml(path).data, SCHEMA, SCHEMA) == []


@pytest.mark.parametrize("text", [WHOLE, DISPERSED])
def test_every_way_to_write_a_value_is_valid(text):
    assert wrong(text) == []


@pytest.mark.parametrize(
    ("said", "instead", "place"),
    [
        ("n_particles: 3", "n_particels: 3", ".zones"),
        ("n_particles: 3", "n_particles: 0", ".zones"),
        ("seed: 3", "seed: 3.5", ".seed"),
        ("gravity: 9.81", "gravity: 0", ".gravity"),
        ("gravity_axis: -z", "gravity_axis: up", ".gravity_axis"),
        ("periodic: [x, y]", "periodic: [x, x]", ".container.periodic"),
        ("4 mm", "4 furlongs", ".particle_sets[0]"),
        ("0.4, 1]", "0.4, 2]", ".particle_sets[0]"),
        ("radius_distribution: sieve", "radius_distribution: seive", ".particle_sets[0]"),
        ("friction: 0.3", "friction: -1", ".materials"),
        ("optimizer: projection", "optimizer: adams", ".params"),
        ("tile: auto", "phi_start: 0.66", ".params"),
        ("axis: 2", "axis: 3", ".zones"),
        ("seed: 3", "sede: 3", ".sede"),
    ],
)
def test_what_packgen_refuses_in_one_value_the_schema_refuses_at_its_place(tmp_path, said, instead, place):
    assert said in WHOLE
    text = WHOLE.replace(said, instead)
    found = wrong(text)
    assert any(each.startswith(place) for each in found), found
    path = tmp_path / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match="expected"):
        load_scene(path)


def test_each_algorithm_has_its_own_settings():
    assert {f"params.{name}" for name in BUILTIN} <= set(SCHEMA["$defs"])
    assert wrong(DISPERSED + "params: {phi_start: 0.66}\n")
    assert not wrong(DISPERSED.replace("DISPERSED", "JAMMED") + "params: {phi_start: 0.66, swap: true}\n")


def test_every_key_of_the_top_says_what_it_means():
    assert all(each["description"] for each in SCHEMA["properties"].values())
    text = json.dumps(SCHEMA)
    assert "Attributes:" not in text
    assert "None" not in text
