"""What is said of a packed bed: to users of Python and of the command line alike."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np
import pytest

from packgen.bed import ParticleSet
from packgen.filling.pack import pack
from packgen.filling.remarks import remarks
from packgen.supply.fitting import SumFit
from tests.beds import box_container, make_bed
from tests.scenes import box, constant, read_scene, run_scene

CUBE = box([0, 0, 0], [1, 1, 1])
HALVES = {"set_proportions": [0.5, 0.5]}


@dataclass(frozen=True)
class Zone:
    asked: int | None
    placed: int
    counts: tuple[int, ...] | None = None
    fit: SumFit | None = None
    locations: tuple[object, ...] = ()


def said(folder, counts, radii=(0.01, 0.01), *, asked=None, drawn=None, fit=None, **zone):
    """Remarks on a zone of so many spheres of each set on the floor of a cube."""
    scene, _ = read_scene(folder, CUBE, [constant(radius) for radius in radii], zones=[HALVES | zone])
    index = np.repeat(np.arange(len(counts), dtype=np.int32), counts)
    position = np.column_stack([np.linspace(0.1, 0.9, len(index)), *[np.full(len(index), 0.5)] * 2])
    sets = tuple(ParticleSet(each.name, each.density, "ore") for each in scene.particle_sets)
    bed = make_bed(
        position,
        np.array(radii)[index],
        box_container([0, 0, 0], [1, 1, 1]),
        set_index=index,
        particle_sets=sets,
    )
    return remarks(scene, bed, [Zone(asked, len(index), drawn, fit)])


@pytest.mark.parametrize(
    ("counts", "fair"),
    [
        ((4, 3), True), ((3, 4), True), ((5, 2), False), ((2, 5), False), ((3, 3), True), ((4, 2), False),
        ((1, 0), True), ((2, 0), False), ((500, 500), True), ((505, 495), True), ((510, 490), False),
    ],
)  # fmt: skip
@pytest.mark.parametrize("complete", [False, True])
def test_counts_are_held_against_what_whole_spheres_allow_however_few(tmp_path, counts, fair, complete):
    lines = said(tmp_path, counts, asked=sum(counts) if complete else sum(counts) + 1)
    assert bool(lines) != fair
    if lines:
        assert re.search(
            r"scene\.yaml:\d+:\d+: zones\[0\]: found shares .* by number, expected 0\.500", lines[0]
        )
        assert ("less room" in lines[0]) != complete


@pytest.mark.parametrize(
    ("counts", "amount", "fair"),
    [
        # One large sphere weighs as much as eight small ones.
        ((3, 24), {}, True), ((3, 17), {}, True), ((3, 36), {}, False), ((4, 20), {}, False),
        ((3, 24), {"mass": 1.0}, True), ((3, 21), {"mass": 1.0}, True), ((3, 15), {"mass": 1.0}, False),
        ((0, 3), {}, True), ((0, 30), {}, False), ((300, 2400), {}, True), ((300, 2500), {}, False),
    ],
)  # fmt: skip
def test_masses_are_held_against_a_sphere_of_each_set(tmp_path, counts, amount, fair):
    lines = said(tmp_path, counts, (0.02, 0.01), proportions_by="mass", **amount)
    assert bool(lines) != fair


def test_a_few_spheres_of_a_broad_law_are_judged_by_their_number(tmp_path):
    # Of the law's spheres large ones came: the mass is off, but the counts are those of the shares.
    broad = {"radius_distribution": "lognormal", "radius_median": 0.01, "sigma": 0.8}
    scene, vessel = read_scene(
        tmp_path,
        CUBE,
        [broad, constant(0.02)],
        zones=[HALVES | {"n_particles": 12, "proportions_by": "mass"}],
    )
    assert pack(scene, vessel).warnings == ()


def test_a_share_too_small_for_a_sphere_is_told(tmp_path):
    (line,) = said(tmp_path, (1, 0), asked=1, drawn=(1, 0), n_particles=1)
    assert re.search(
        r"scene\.yaml:\d+:\d+: zones\[0\]: found no sphere of set_1, expected a share of 0\.5", line
    )


def test_a_sum_that_whole_spheres_do_not_meet_is_told_with_what_it_came_to(tmp_path):
    keys = {"zones": [{"mass": 580.0, **HALVES}]}
    result = run_scene(tmp_path, box([0, 0, 0], [1, 1, 1]), [
        constant(0.1) | {"density": 3500}, constant(0.03) | {"density": 3500}
    ], **keys)  # fmt: skip
    assert np.bincount(result.bed.set_index).tolist() == [39, 38]
    (line,) = result.warnings
    assert re.search(
        r"scene\.yaml:\d+:\d+: zones\[0\]: found 586\.812 kg, asked 580 kg, 6\.81 kg too much", line
    )
    met = SumFit("mass", 580.0, 580.1, 0.2, True)
    assert said(tmp_path, (4, 4), fit=met) == ()
    missed = SumFit("volume", 1.0, 0.5, 0.1)
    assert "asked 1 m3, 0.5 m3 too little" in said(tmp_path, (4, 4), fit=missed)[0]


def test_python_is_told_of_zones_that_nothing_holds(tmp_path):
    wide = box([0, 0, 0], [0.4, 0.1, 0.2])
    column = {"location": {"box": {"min": [0.0, 0.0, 0.0], "max": [0.1, 0.1, 0.2]}}}
    beside = {"location": {"box": {"min": [0.1, 0.0, 0.0], "max": [0.4, 0.1, 0.2]}}}
    alone = run_scene(tmp_path, wide, constant(0.01), zones=[column]).warnings
    assert len(alone) == 1
    assert re.search(r"zones\[0\]: nothing holds \d+% of its side: .* add a wall", alone[0])
    assert run_scene(tmp_path, wide, constant(0.01), zones=[column, beside]).warnings == ()
    raised = {"location": {"box": {"min": [0.0, 0.0, 0.1], "max": [0.4, 0.1, 0.2]}}}
    (line,) = run_scene(tmp_path, wide, constant(0.01), zones=[raised]).warnings
    assert "nothing holds it up" in line


def test_what_is_told_before_the_run_is_among_the_warnings_too(tmp_path, monkeypatch):
    def with_a_doubt(scene, container, warn):
        warn("these units look odd")
        return ((),)

    monkeypatch.setattr("packgen.filling.prepared.checked_locations", with_a_doubt)
    scene, vessel = read_scene(tmp_path, CUBE, constant(0.1), zones=[{"n_particles": 5}])
    told: list[str] = []
    assert pack(scene, vessel, warn=told.append).warnings == tuple(told) == ("these units look odd",)
