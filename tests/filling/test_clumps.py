"""Beds of rigid clumps: what a scene asks for is what the bed has."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.bodies import SINGLE, members_of
from packgen.check import check_bed
from packgen.errors import PackingError
from packgen.filling.pack import PackResult, pack
from packgen.measure import contacts

BOX = {"box": {"min": [0, 0, 0], "max": [0.1, 0.1, 0.2]}}
DIMER = {
    "name": "dimer",
    "radius_distribution": "uniform",
    "radius_min": 0.009,
    "radius_max": 0.011,
    "shape": {"dumbbell": {"radius": 0.5, "distance": 0.9}},
}
TRIMER = {
    "name": "trimer",
    "radius_distribution": "constant",
    "radius": 0.01,
    "shape": {"ring": {"radius": 1}, "spheres": 3},
}
SPHERE = {"name": "sphere", "radius_distribution": "constant", "radius": 0.01}


def packed(sets: list, count: int, container: dict = BOX, **keys: object) -> PackResult:
    zones = [{"n_particles": count}]
    return pack({"container": container, "particle_sets": sets, "zones": zones} | keys)


@pytest.fixture(scope="module")
def mixture() -> PackResult:
    return packed([DIMER, TRIMER, SPHERE], 60)


def assert_whole(result: PackResult) -> None:
    """Hold a bed of bodies against the check, and its spheres against their bodies."""
    bed = result.bed
    assert check_bed(bed).within_tolerance
    assert bed.bodies is not None
    position, radius, owner = members_of(bed.bodies)
    apart = position - bed.position
    for axis, period in enumerate(bed.container.period):
        if period is not None:
            apart[:, axis] -= period * np.rint(apart[:, axis] / period)
    assert np.abs(apart).max() < 1e-12
    assert np.array_equal(owner, bed.body_index)
    assert np.abs(radius - bed.radius).max() < 1e-15
    assert np.abs(np.linalg.norm(bed.bodies.orientation, axis=1) - 1.0).max() < 1e-15


def test_clumps_and_spheres_come_to_rest_without_overlap_as_rigid_bodies(mixture):
    assert_whole(mixture)
    assert [(zone.asked, zone.placed) for zone in mixture.zones] == [(60, 60)]
    assert np.bincount(mixture.bed.bodies.template_index + 1).tolist() == [20, 20, 20]


def test_the_law_draws_the_radius_of_the_sphere_of_a_clumps_volume(mixture):
    bodies = mixture.bed.bodies
    size, kind = bodies.equivalent_radius, bodies.template_index
    assert np.allclose(size[kind == 1], 0.01, rtol=1e-12)
    assert np.allclose(size[kind == SINGLE], 0.01, rtol=1e-12)
    assert size[kind == 0].min() >= 0.009
    assert size[kind == 0].max() <= 0.011
    assert np.ptp(size[kind == 0]) > 0.0015  # 20 seeds: 0.00191 +- 0.00003


def test_bodies_rest_across_the_seams_of_a_periodic_box():
    container = {"box": {"min": [0, 0, 0], "max": [0.08, 0.08, 0.2]}, "periodic": ["x", "y"]}
    result = packed([DIMER, TRIMER], 40, container)
    assert_whole(result)
    assert result.zones[0].placed == 40
    spread = np.abs(members_of(result.bed.bodies)[0] - result.bed.position).max(axis=0)
    assert (spread[:2] > 0.07).all()  # some bodies have spheres on both sides


def test_a_bed_does_not_depend_on_threads_but_on_the_seed():
    beds = [packed([DIMER], 20, seed=seed).bed for seed in (0, 1)]
    scene = {"container": BOX, "particle_sets": [DIMER], "zones": [{"n_particles": 20}]}
    again = pack(scene, threads=2).bed
    assert np.array_equal(again.position, beds[0].position)
    assert np.array_equal(again.bodies.orientation, beds[0].bodies.orientation)
    assert not np.array_equal(beds[1].position, beds[0].position)


def test_clumps_of_one_sphere_are_the_bed_of_spheres(tmp_path):
    (tmp_path / "one.csv").write_text("0 0 0 2\n", encoding="utf-8")
    one = {**SPHERE, "shape": {"spheres": str(tmp_path / "one.csv")}}
    beds = [packed([each], 60).bed for each in (one, SPHERE)]
    assert np.array_equal(beds[0].position, beds[1].position)
    assert beds[0].bodies is None


def test_amounts_are_those_of_bodies_not_of_their_spheres():
    result = pack({"container": BOX, "particle_sets": [DIMER], "zones": [{"mass": 0.3}]})
    mass = 2500.0 * float(result.bed.bodies.volume.sum())
    assert result.zones[0].placed == len(result.bed.bodies)
    assert mass == pytest.approx(0.3, abs=0.5 * 2500.0 * 4.19 * 0.011**3)


def test_spheres_fill_a_zone_between_zones_of_clumps():
    zones = [{"n_particles": 12, "set_proportions": shares} for shares in ([1, 0], [0, 1], [1, 0])]
    result = pack({"container": BOX, "particle_sets": [DIMER, SPHERE], "zones": zones})
    assert_whole(result)
    assert [zone.placed for zone in result.zones] == [12, 12, 12]


def test_clumps_wider_than_the_vessel_are_refused_before_the_run():
    ring = {**SPHERE, "radius": 0.04, "shape": {"ring": {"radius": 1}, "spheres": 12}}
    with pytest.raises(
        PackingError, match=r"particle_sets\[0\]: found clumps up to 0.1\d+ m long, wider than"
    ):
        packed([ring], 3)


def test_a_box_without_a_floor_is_refused():
    container = {"box": {"min": [0, 0, 0], "max": [0.1, 0.1, 0.1]}, "periodic": ["x", "y", "z"]}
    with pytest.raises(PackingError, match="wraps around along gravity, expected a floor: not supported yet"):
        packed([DIMER], 3, container)


def test_a_bed_of_clumps_is_not_divided_into_tiles():
    with pytest.raises(PackingError, match="found a clump, expected none: not supported yet with --workers"):
        packed([DIMER], 3, params={"tile": 30})


@pytest.mark.physics
def test_a_dimer_rests_on_more_than_the_four_others_that_friction_needs():
    dimers = {"radius_distribution": "constant", "radius": 1.0}
    dimers["shape"] = {"dumbbell": {"radius": 1.0, "distance": 1.6}}
    bed = packed([dimers], 500, {"cylinder": {"radius": 8, "height": 40}}).bed
    assert contacts(bed, (1e-3,))[0].mean > 4.25  # 20 seeds: 4.90 +- 0.11, from 4.67 on


@pytest.mark.slow
def test_clumps_of_sizes_one_to_ten_and_of_many_spheres_keep_their_promises():
    broad = {**DIMER, "radius_distribution": "uniform", "radius_min": 0.002, "radius_max": 0.02}
    result = pack({"container": BOX, "particle_sets": [broad], "zones": [{"volume": 4e-4}]})
    assert_whole(result)
    assert result.zones[0].placed == result.zones[0].asked
    many = {**SPHERE, "shape": {"rod": {"radius": 1, "length": 8}, "spheres": 200}}
    assert_whole(packed([many], 20))


def test_members_inside_each_other_add_nothing_and_pack(tmp_path):
    bare = "x,y,z,r\n-0.5,0,0,1\n0.5,0,0,1\n"
    beds = []
    for name, more in (("bare.csv", ""), ("nested.csv", "0,0,0,0.8\n-0.5,0,0,1\n0.4,0,0,0.9\n")):
        (tmp_path / name).write_text(bare + more, encoding="utf-8")
        beds.append(packed([{**SPHERE, "shape": {"spheres": str(tmp_path / name)}}], 30))
        assert_whole(beds[-1])
        assert beds[-1].zones[0].placed == 30
    bare_one, nested = (each.bed.bodies.templates[0] for each in beds)
    assert nested.volume == pytest.approx(bare_one.volume, rel=1e-12)
    assert nested.inertia == pytest.approx(bare_one.inertia, rel=1e-12, abs=1e-12 * bare_one.inertia.max())


def test_a_clump_of_a_thousand_spheres_is_packed_as_any_other(tmp_path):
    # A shell of small spheres around a large one, by the golden angle.
    place = (np.arange(999) + 0.5) / 999
    turn, across = np.pi * (1.0 + 5.0**0.5) * np.arange(999), 2.0 * np.sqrt(place * (1.0 - place))
    shell = np.column_stack([across * np.cos(turn), across * np.sin(turn), 1.6 * (1.0 - 2.0 * place)])
    rows = np.vstack([[0.0, 0.0, 0.0, 0.95], np.column_stack([shell, np.full(999, 0.1)])])
    np.savetxt(tmp_path / "shell.txt", rows)
    result = packed([{**SPHERE, "shape": {"spheres": str(tmp_path / "shell.txt")}}], 8)
    assert_whole(result)
    assert (result.bed.count, len(result.bed.bodies)) == (8000, 8)
