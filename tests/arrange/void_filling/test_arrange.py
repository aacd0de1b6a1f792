"""Claims on beds made by VOID_FILLING: what ends them, what is kept, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from packgen import pack
from packgen.check import check_bed
from packgen.distributions import UNIT_VOLUME
from packgen.errors import PackgenError
from packgen.filling.pack import PackResult
from packgen.report import build_report
from tests.arrange.void_filling.shapes import UNIT_CUBE, farthest_left, hollow

CUBE = {"box": {"min": [0, 0, 0], "max": [1, 1, 1]}}
FREE = {"name": "free", "radius_distribution": "free", "radius_min": 0.05}
DRAWN = {"name": "drawn", "radius_distribution": "uniform", "radius_min": 0.08, "radius_max": 0.12}


def filled(**keys: Any) -> PackResult:
    scene = {"container": CUBE, "algorithm": "VOID_FILLING", "particle_sets": [FREE]} | keys
    return pack(scene)


def solid(result: PackResult) -> float:
    return float(UNIT_VOLUME * (result.bed.radius**3).sum())


def missed(result: PackResult) -> tuple[str, ...]:
    return build_report(result.bed, zones=result.zones).faults()


def test_a_number_of_spheres_a_coverage_or_the_least_radius_ends_it() -> None:
    assert filled(zones=[{"n_particles": 9}]).bed.count == 9
    covered = filled(params={"coverage": 0.65})
    assert solid(covered) >= 0.65 > solid(covered) - UNIT_VOLUME * covered.bed.radius[-1] ** 3
    full = filled()
    assert 0.05 <= full.bed.radius.min() < 0.06
    assert full.bed.count > 33
    assert missed(covered) == missed(full) == ()
    for each in (covered, full):
        assert check_bed(each.bed).overlap_max == check_bed(each.bed).wall_overlap_max == 0.0


def test_a_coverage_or_number_that_the_least_radius_forbids_is_reported() -> None:
    (line,) = missed(filled(params={"coverage": 0.9}))
    assert "asked 0.9000: it is looser" in line
    (line,) = missed(filled(zones=[{"n_particles": 900}]))
    assert "of 900 spheres placed" in line


def test_no_free_sphere_is_larger_than_the_largest_radius() -> None:
    result = filled(particle_sets=[FREE | {"radius_max": 0.2}], zones=[{"n_particles": 40}])
    radius = result.bed.radius
    assert radius.max() == 0.2
    assert np.count_nonzero(radius == 0.2) >= 8
    assert check_bed(result.bed).overlap_max == 0.0
    full = filled(particle_sets=[FREE | {"radius_max": 0.2}]).bed
    left = hollow(UNIT_CUBE, np.column_stack([full.position, full.radius]))
    assert farthest_left(left, np.array([[0.0] * 3, [1.0] * 3]), 50_000) < 0.05


def test_drawn_radii_are_kept_and_what_finds_no_place_is_reported() -> None:
    result = filled(particle_sets=[DRAWN], zones=[{"n_particles": 90}])
    assert missed(result) == ()
    assert check_bed(result.bed).overlap_max == check_bed(result.bed).wall_overlap_max == 0.0
    assert np.diff(result.bed.radius).max() <= 0.0
    many = filled(particle_sets=[DRAWN], zones=[{"n_particles": 130}])
    assert f"{many.bed.count} of 130 spheres placed" in missed(many)[0]


def test_free_spheres_fill_what_a_zone_of_drawn_ones_leaves() -> None:
    zones = [
        {"n_particles": 60, "set_proportions": [0, 1]},
        {"n_particles": 40, "set_proportions": [1, 0]},
    ]
    result = filled(particle_sets=[FREE | {"radius_min": 0.01}, DRAWN], zones=zones)
    bed = result.bed
    assert np.bincount(bed.zone_index).tolist() == [60, 40]
    assert np.diff(bed.radius[60:]).max() <= 1e-12
    assert check_bed(bed).overlap_max == 0.0


def test_a_periodic_box_has_no_seam() -> None:
    container = {"box": {"min": [0, 0, 0], "max": [1, 1, 1]}, "periodic": ["x", "y", "z"]}
    result = filled(container=container, zones=[{"n_particles": 60}])
    assert result.bed.radius.max() == pytest.approx(0.25)
    assert check_bed(result.bed).overlap_max == 0.0
    assert solid(result) > 0.6


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"particle_sets": [FREE | {"radius_min": 0.6}]}, "not one sphere fits"),
        ({"particle_sets": [FREE | {"radius_min": 1e-5}]}, "give n_particles"),
        (
            {
                "params": {"coverage": 0.5},
                "zones": [{"location": {"slice": {"axis": "z", "min_bound": 0, "max_bound": 0.5}}}],
            },
            "coverage is that of the whole container",
        ),
        ({"params": {"coverage": 1.5}}, "params.coverage"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(keys: dict[str, Any], words: str) -> None:
    with pytest.raises(PackgenError) as caught:
        filled(**keys)
    (line,) = str(caught.value).splitlines()
    assert words in line


def test_a_slit_takes_what_fits_between_its_walls() -> None:
    slit = {"box": {"min": [0, 0, 0], "max": [1, 1, 0.1]}}
    result = filled(container=slit, particle_sets=[FREE | {"radius_min": 0.045}])
    assert result.bed.radius.max() == pytest.approx(0.05)
    assert result.bed.count > 20
    assert math.isclose(result.bed.position[0, 2], 0.05, rel_tol=1e-9)
