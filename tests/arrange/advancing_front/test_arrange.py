"""Claims on beds of a front: contacts, radii, containers, order; by the check and closed forms alone."""

from __future__ import annotations

import json

import numpy as np
import pytest

from packgen.bed import Bed
from packgen.check import check_bed
from packgen.errors import PackingError
from packgen.filling.pack import pack
from packgen.measure import core_of, solid_fraction
from packgen.measure.order import local_order
from tests import container_meshes as meshes
from tests.arrange.advancing_front.contacts import contact_counts
from tests.scenes import box, constant, read_scene, run_scene, uniform

CUBE = box([0] * 3, [1] * 3)
VESSELS = {
    "box": CUBE,
    "cylinder": {"cylinder": {"radius": 0.5, "height": 1.0}},
    "sphere": {"sphere": {"radius": 0.6}},
    "cone": {"cone": {"radius_bottom": 0.1, "radius_top": 0.6, "height": 1.0}},
    "periodic": {**CUBE, "periodic": ["x", "y"]},
}
SIZES = {"equal": constant(0.06), "mixed": uniform(0.03, 0.08)}
RULES = ("lowest", "nearest")


def front(folder, container, sets, zone=None, rule="lowest", **keys):
    params = {"rule": rule, **keys.pop("params", {})}
    return run_scene(
        folder, container, sets, algorithm="ADVANCING_FRONT", params=params, zones=[zone or {}], **keys
    )


def fraction(bed: Bed) -> float:
    return float((4.0 / 3.0 * np.pi * bed.radius**3).sum()) / bed.container.volume


@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("sizes", SIZES)
@pytest.mark.parametrize("vessel", VESSELS)
def test_every_sphere_touches_three_others_or_walls_to_rounding(tmp_path, vessel, sizes, rule):
    bed = front(tmp_path, VESSELS[vessel], SIZES[sizes], rule=rule).bed
    assert contact_counts(bed).min() >= 3
    check = check_bed(bed)
    assert max(check.overlap_max, check.wall_overlap_max) * bed.radius.min() <= 1.0e-14
    # 20 seeds each: 0.482 to 0.607. Widest are spheres, the lowest first: 0.523 +- 0.017, from 0.487 on.
    assert fraction(bed) > 0.43


@pytest.mark.parametrize("rule", RULES)
def test_radii_are_exactly_those_drawn(tmp_path, rule):
    radius = np.random.default_rng(3).uniform(0.03, 0.08, 300)
    np.savetxt(tmp_path / "radii.txt", radius, fmt="%.17g")
    sets = {"radius_distribution": "file", "path": "radii.txt"}
    result = front(tmp_path, CUBE, sets, rule=rule)
    assert result.zones[0].left_over == 0
    assert sorted(result.bed.radius) == sorted(radius)


@pytest.mark.parametrize("rule", RULES)
def test_large_and_small_spheres_wait_for_each_other_no_longer_than_a_layer(tmp_path, rule):
    bed = front(tmp_path, box([0] * 3, [1, 1, 2]), uniform(0.02, 0.06), {"n_particles": 2500}, rule).bed
    way = bed.position[:, 2] if rule == "lowest" else np.linalg.norm(bed.position, axis=1)
    order = np.argsort(way)[250:-250]  # away from the start and the free surface
    means = [part.mean() for part in np.array_split(bed.radius[order], 5)]
    assert np.ptp(means) < 0.13 * np.mean(means)  # 20 seeds: 0.023 +- 0.009 and 0.043 +- 0.012, up to 0.073


def test_a_bed_until_full_keeps_the_law(tmp_path):
    bed = front(tmp_path, CUBE, uniform(0.02, 0.06)).bed
    expected = np.sort(bed.radius)
    law = 0.02 + 0.04 * (np.arange(bed.count) + 0.5) / bed.count
    # 20 seeds: 0.0155 +- 0.0020 of the law's width, up to 0.018; draws that wait take 0.02 of it at most.
    assert np.abs(expected - law).max() < 0.02 * 0.04 + 0.04 * 40 / bed.count


def test_two_sizes_have_their_shares(tmp_path):
    result = front(
        tmp_path, CUBE, [constant(0.025), constant(0.06)], {"n_particles": 900, "set_proportions": [0.9, 0.1]}
    )
    assert np.bincount(result.bed.set_index).tolist() == [810, 90]
    assert contact_counts(result.bed).min() >= 3


@pytest.mark.parametrize("rule", RULES)
def test_beds_are_dense_and_no_crystals(tmp_path, rule):
    bed = front(tmp_path, CUBE, constant(0.035), rule=rule).bed
    # 20 seeds: 0.605 +- 0.002 and 0.614 +- 0.001; crystals 0.002 +- 0.001 and 0.004 +- 0.002, up to 0.008.
    assert solid_fraction(bed).core > 0.58
    assert local_order(bed, core_of(bed)).crystal < 0.05


def test_broad_sizes_are_denser_than_equal_ones(tmp_path):
    found = [
        solid_fraction(front(tmp_path, CUBE, sizes).bed).core
        for sizes in (constant(0.04), uniform(0.015, 0.075))
    ]
    assert found[1] > found[0] + 0.01  # 20 seeds: 0.647 +- 0.004 and 0.606 +- 0.001


def test_spheres_of_the_lowest_rule_lie_where_their_contacts_bear_them(tmp_path):
    # Without friction three contacts below or beside a sphere's centre bear it: none may hang.
    bed = front(tmp_path, CUBE, uniform(0.04, 0.08)).bed
    support = np.zeros(bed.count, bool)
    for i in range(bed.count):
        way = bed.position - bed.position[i]
        touching = np.abs(np.linalg.norm(way, axis=1) - bed.radius - bed.radius[i]) < 1e-12
        support[i] = (touching & (way[:, 2] < 0.0)).any() or bed.position[i, 2] - bed.radius[i] < 1e-12
    assert support.mean() > 0.99  # 20 seeds: 0.9998 +- 0.0006, from 0.998 on


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tank", "hopper", "u_bend", "torus"])
@pytest.mark.parametrize("rule", RULES)
def test_vessels_that_are_not_convex_are_filled_to_their_walls(tmp_path, name, rule):
    mesh = meshes.torus() if name == "torus" else getattr(meshes, name)(open_top=True)
    radius = 0.03 * float(mesh.extents.max())
    bed = front(tmp_path, {"path": meshes.saved(mesh, tmp_path)}, constant(radius), rule=rule).bed
    check = check_bed(bed)
    assert check.outside_count == 0
    assert max(check.overlap_max, check.wall_overlap_max) * radius <= 1.0e-14 * float(mesh.extents.max())
    assert fraction(bed) > 0.40


def test_the_same_seed_makes_the_same_bed(tmp_path):
    beds = [front(tmp_path, CUBE, SIZES["mixed"], seed=seed).bed for seed in (4, 4, 5)]
    assert np.array_equal(beds[0].position, beds[1].position)
    assert not np.array_equal(beds[0].position[:50], beds[2].position[:50])


def test_a_zone_on_another_one_rests_on_its_spheres(tmp_path):
    zones = [
        {"n_particles": 150},
        {"n_particles": 150, "location": {"slice": {"axis": "z", "min_bound": 0.1, "max_bound": 1.0}}},
    ]
    result = run_scene(
        tmp_path, CUBE, SIZES["mixed"], algorithm="ADVANCING_FRONT", zones=zones, params={"rule": "lowest"}
    )
    assert [zone.placed for zone in result.zones] == [150, 150]
    # The side of a zone across gravity is a wall for centres.
    count = contact_counts(result.bed) + (np.abs(result.bed.position[:, 2] - 0.1) < 1e-12)
    assert count[150:].min() >= 3


def test_a_front_goes_on_from_a_bed_that_is_there(tmp_path):
    old = tmp_path / "old.csv"
    old.write_text("x,y,z,radius\n0.5,0.5,0.2,0.2\n0.2,0.2,0.1,0.1\n")
    scene, vessel = read_scene(
        tmp_path, CUBE, constant(0.06), algorithm="ADVANCING_FRONT", start_from={"path": "old.csv"},
        zones=[{"n_particles": 200}],
    )  # fmt: skip
    result = pack(scene, vessel)
    assert result.zones[-1].placed == 200
    assert np.array_equal(result.bed.position[:2], [[0.5, 0.5, 0.2], [0.2, 0.2, 0.1]])
    assert check_bed(result.bed).within_tolerance


@pytest.mark.parametrize("count", [1, 2, 3])
def test_a_few_spheres_lie_on_the_floor(tmp_path, count):
    bed = front(tmp_path, CUBE, constant(0.1), {"n_particles": count}).bed
    assert bed.count == count
    assert np.allclose(bed.position[:, 2], 0.1, atol=1e-12)


@pytest.mark.parametrize("width", [0.061, 0.06001])  # of 40 seeds 4 and 40 have no point by chance
@pytest.mark.parametrize("seed", [0, 5])
def test_a_tube_hardly_wider_than_a_sphere_holds_a_column(tmp_path, width, seed):
    tube = {"cylinder": {"radius": width, "height": 1.0}}
    bed = front(tmp_path, tube, constant(0.06), seed=seed).bed
    assert bed.count == 8
    gaps = np.linalg.norm(np.diff(bed.position[np.argsort(bed.position[:, 2])], axis=0), axis=1) - 0.12
    assert np.abs(gaps).max() < 1e-12


@pytest.mark.parametrize("seed", [0, 6, 8])  # in the last two small spheres begin far from all others
def test_a_tenfold_range_of_sizes_is_placed(tmp_path, seed):
    result = front(tmp_path, box([0] * 3, [1, 1, 1]), uniform(0.01, 0.1), {"volume": 0.4}, seed=seed)
    assert result.zones[0].left_over == 0
    assert contact_counts(result.bed).min() >= 3


def test_too_many_are_told_and_none_is_shrunk(tmp_path):
    scene, vessel = read_scene(
        tmp_path, CUBE, constant(0.1), algorithm="ADVANCING_FRONT", zones=[{"n_particles": 140}]
    )
    result = pack(scene, vessel)
    assert 0 < result.zones[0].placed < 140
    assert result.zones[0].left_over == 140 - result.zones[0].placed
    assert (result.bed.radius == 0.1).all()


def test_a_lowest_place_needs_a_floor(tmp_path):
    scene, vessel = read_scene(
        tmp_path, {**CUBE, "periodic": ["x", "y", "z"]}, constant(0.1), algorithm="ADVANCING_FRONT",
        params={"rule": "lowest"}, zones=[{}],
    )  # fmt: skip
    with pytest.raises(PackingError, match=r"wraps around along gravity, expected a floor"):
        pack(scene, vessel)


def test_progress_is_told_until_the_last_sphere(tmp_path):
    scene, vessel = read_scene(
        tmp_path, CUBE, constant(0.06), algorithm="ADVANCING_FRONT", zones=[{"n_particles": 100}]
    )
    heard = []
    pack(scene, vessel, on_progress=heard.append)
    assert heard[-1].placed == heard[-1].total == 100
    assert json.dumps(heard[-1].stage) == '"front"'
