"""Claims on sets whose sizes are those of the voids: which algorithms take them, and in which zones."""

from __future__ import annotations

from pathlib import Path

import pytest

from packgen.arrange.dispersed.params import Params
from tests.scene.texts import BOX, load, problems

FREE = "particle_sets:\n  - {radius_distribution: free, radius_min: 10 mm, radius_max: 0.5}\n"
BOTH = FREE + "  - {name: drawn, radius_distribution: constant, radius: 0.1}\n"
SIZING = BOX + "algorithm: DISPERSED\n"


@pytest.fixture
def sizing_zones(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let an algorithm size the spheres of zones."""
    monkeypatch.setattr(Params, "free_sizes", "zones", raising=False)


def test_an_algorithm_that_sizes_no_spheres_refuses_them_in_one_line(tmp_path: Path) -> None:
    for algorithm in ("COLLECTIVE_ARRANGEMENT", "ADAM", "DISPERSED", "JAMMED"):
        (line,) = problems(tmp_path, BOX + FREE + f"algorithm: {algorithm}\n")
        assert line.startswith("scene.yaml:3:27: particle_sets[0].radius_distribution: found 'free'")
        assert f"{algorithm} sizes no spheres by their voids" in line
        assert "VOID_FILLING" in line


@pytest.mark.usefixtures("sizing_zones")
def test_the_only_set_has_every_zone_to_itself(tmp_path: Path) -> None:
    scene = load(tmp_path, SIZING + FREE)
    assert [zone.set_proportions for zone in scene.zones] == [(1.0,)]


@pytest.mark.usefixtures("sizing_zones")
def test_it_takes_what_others_leave_in_a_zone_of_its_own(tmp_path: Path) -> None:
    zones = "zones:\n  - {set_proportions: [0, 1], n_particles: 9}\n  - {set_proportions: [1, 0]}\n"
    assert len(load(tmp_path, SIZING + BOTH + zones).zones) == 2
    (line,) = problems(tmp_path, SIZING + BOTH + "zones: [{set_proportions: [0.5, 0.5]}]\n")
    assert "zones[0].set_proportions: found a share of 0.5 of a set of free sizes, expected a zone of" in line
    (line,) = problems(tmp_path, SIZING + BOTH)
    assert "particle_sets[0]: found no zone for free sizes, expected one" in line


@pytest.mark.usefixtures("sizing_zones")
def test_a_volume_or_mass_of_unknown_sizes_is_refused(tmp_path: Path) -> None:
    for amount in ("volume: 0.1", "mass: 100"):
        (line,) = problems(tmp_path, SIZING + FREE + f"zones: [{{{amount}}}]\n")
        assert f"zones[0].{amount.split(':')[0]}: found" in line
        assert "nobody knows sizes before" in line


def test_where_the_settings_place_it_no_zone_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Params, "free_sizes", "fill", raising=False)
    assert load(tmp_path, SIZING + BOTH).zones[0].set_proportions == (0.0, 1.0)
    (line,) = problems(tmp_path, SIZING + BOTH + "zones: [{set_proportions: [0.5, 0.5]}]\n")
    assert "zones[0].set_proportions: found a share of 0.5 of a set of free sizes" in line
    assert "expected a share of 0" in line
