# ruff: noqa: E501 (each row of the tables of faults stays on one line)
"""Claims on scene files that are wrong: every fault with its place, the value found, and what was expected."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.scene.texts import BOX, SETS, load, problems


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


def test_a_name_that_no_terminal_can_show_is_escaped(tmp_path: Path) -> None:
    text = f'{BOX}materials: {{"\\x1f": null}}\nwall_material: iron\n{SETS}'
    assert any(each.endswith(r"one of the materials: \x1f") for each in problems(tmp_path, text))


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
    ("algorithm: JAMMED\nzones: [{solid_fraction: 0.5}]", "zones[0].solid_fraction: found 0.5, expected none: not supported yet by JAMMED"),
    ("algorithm: ADAM\nzones: [{porosity: 0.5}]", "zones[0].porosity: found 0.5, expected none: not supported yet by ADAM; leave it out, or take"),
    ("zones: [{gap: 0.1}]", "zones[0].gap: found 0.1, expected none: not supported yet by COLLECTIVE_ARRANGEMENT; leave it out"),
    ("algorithm: DISPERSED\nzones: [{solid_fraction: 1}]", "zones[0].solid_fraction: found 1, expected a number greater than 0 and below 1"),
    ("algorithm: DISPERSED\nzones: [{porosity: '40 %'}]", "zones[0].porosity: found '40 %', expected a number"),
    ("algorithm: DISPERSED\nzones: [{void_ratio: {value: 0.7, of: bed}}]", "void_ratio.of: found 'bed', expected one of core, filled"),
    ("algorithm: DISPERSED\nzones: [{solid_fraction: 0.3, void_ratio: 2}]", "zones[0].void_ratio: found solid_fraction and void_ratio, expected at most one of"),
    ("algorithm: DISPERSED\nzones: [{solid_fraction: 0.3, mass: 2}]", "zones[0].solid_fraction: found solid_fraction beside mass, expected one of both: DISPERSED spreads"),
    ("algorithm: DISPERSED\nzones: [{gap: -1}]", "zones[0].gap: found -1, expected a number of at least 0"),
    ("algorithm: DISPERSED\nzones: [{gap: 2 kg}]", "zones[0].gap: found '2 kg', expected"),
    ("algorithm: DISPERSED\nparams: {batch_size: 5}", "params.batch_size: found an unknown key"),
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
            "radius_min: found an unknown key, expected one of density, material, name, orientation, radius",
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


def test_a_file_of_radii_serves_one_zone(tmp_path: Path) -> None:
    (tmp_path / "radii.txt").write_text("0.1\n0.2\n")
    sets = "particle_sets: [{radius_distribution: file, path: radii.txt}]\n"
    (found,) = problems(tmp_path, f"{BOX}{sets}zones: [{{n_particles: 1}}, {{n_particles: 1}}]\n")
    assert "a file of radii used by zones[0], zones[1], expected one zone" in found


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (SET.replace("0.1", "1e-300") % "", "a length of at least 1e-12 m"),
        (SET % ", density: 1e300", "a density of at most 1e"),
    ],
)
def test_numbers_that_no_bed_has_are_refused(tmp_path: Path, text: str, said: str) -> None:
    (found,) = problems(tmp_path, f"{BOX}particle_sets: [{text}]\n")
    assert said in found


def test_a_fault_at_one_key_of_a_set_or_zone_hides_none_of_the_others(tmp_path: Path) -> None:
    text = f"""\
{BOX}
particle_sets:
  - {{radius_distribution: uniform, radius_min: 0.05, radius_max: 0.02, density: -1, materal: ore}}
  - {{radius_distribution: discrete, radii: [0.1, 0.2], fractions: [0.3, 0.3], name: 7}}
  - {{radius_distribution: uniform, radius_min: 0.05, density: -1}}
zones:
  - {{volume: 1, mass: 2, set_proportions: [1, 0, 0], proportions_by: size}}
"""
    found = [each.split(": ")[1] for each in problems(tmp_path, text)]
    assert found == [
        "particle_sets[0].radius_max", "particle_sets[0].density", "particle_sets[0].materal",
        "particle_sets[1].fractions", "particle_sets[1].name",
        "particle_sets[2].radius_max", "particle_sets[2].density",
        "zones[0].mass", "zones[0].proportions_by",
    ]  # fmt: skip


def test_a_fault_inside_one_list_of_a_law_hides_none_of_the_other_list(tmp_path: Path) -> None:
    text = f"""\
{BOX}
particle_sets:
  - {{radius_distribution: discrete, radii: [0.02, -0.1, 0.03], fractions: [0.5, 0.9, 0.1]}}
  - {{radius_distribution: sieve, diameters: [0.01, x, 0.03], passing: [0.4, 0.2, 1.0]}}
  - {{radius_distribution: sieve, diameters: [0.03, 0.01, 0.02], passing: [1.0, 0.7, -0.4]}}
  - {{radius_distribution: sieve, diameters: [0.03, -0.02, 0.01], passing: [1.0, 0.7, 0.4]}}
"""
    found = [each.split(": ")[1] for each in problems(tmp_path, text)]
    assert found == [
        "particle_sets[0].radii[1]", "particle_sets[0].fractions",
        "particle_sets[1].diameters[1]", "particle_sets[1].passing[1]",
        "particle_sets[2].diameters[2]", "particle_sets[2].passing[2]",
        "particle_sets[3].diameters[1]",
    ]  # fmt: skip
