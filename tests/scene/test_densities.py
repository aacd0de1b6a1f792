"""Claims on how a scene says how dense a zone is, and how far apart its spheres are."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.scene.texts import BOX, SETS, load, problems

HEAD = BOX + SETS + "algorithm: DISPERSED\n"


@pytest.mark.parametrize(
    ("said", "fraction"),
    [("solid_fraction: 0.4", 0.4), ("porosity: 0.6", 0.4), ("void_ratio: 1.5", 0.4)],
)
def test_three_keys_say_the_same_of_all_of_a_zone_or_of_its_core(
    tmp_path: Path, said: str, fraction: float
) -> None:
    zone = load(tmp_path, HEAD + f"zones: [{{{said}}}]").zones[0]
    assert zone.fraction is not None
    assert zone.fraction.value == pytest.approx(fraction)
    assert zone.fraction.of == "filled"
    key, value = said.split(": ")
    zone = load(tmp_path, HEAD + f"zones: [{{{key}: {{value: {value}, of: core}}}}]").zones[0]
    assert zone.fraction is not None
    assert zone.fraction.value == pytest.approx(fraction)
    assert zone.fraction.of == "core"


def test_a_gap_is_a_number_of_radii_or_a_length_with_its_unit(tmp_path: Path) -> None:
    zones = load(tmp_path, HEAD + "zones: [{gap: 0.05}, {gap: 2 mm}, {}]").zones
    gaps = [None if zone.gap is None else (zone.gap.radii, zone.gap.length) for zone in zones]
    assert gaps == [(0.05, 0.0), (0.0, 0.002), None]


def test_dispersed_beds_have_no_gravity(tmp_path: Path) -> None:
    assert load(tmp_path, HEAD + "gravity: 9.81").gravity == 0.0
    assert load(tmp_path, BOX + SETS).gravity == 9.81


def test_settings_that_shaped_the_bed_can_be_read_again(tmp_path: Path) -> None:
    kept = load(tmp_path, HEAD + "zones: [{porosity: 0.6, gap: 2 mm}]").model_dump()["zones"][0]
    assert kept["porosity"] == {"value": 0.6, "of": "filled"}
    assert kept["gap"] == {"radii": 0.0, "length": 0.002}


def test_faults_of_densities_are_told_with_all_others(tmp_path: Path) -> None:
    found = problems(
        tmp_path,
        BOX
        + SETS
        + "seed: -1\nalgorithm: JAMMED\nzones:\n  - {solid_fraction: 0.3}\n  - {gap: 1, mass: -1}\n",
    )
    starts = [each.split(": found")[0].split(": ")[1] for each in found]
    assert starts == ["seed", "zones[0].solid_fraction", "zones[1].gap", "zones[1].mass"]
