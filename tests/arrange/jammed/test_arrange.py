"""Claims on jammed beds: radii as drawn, no overlap, nothing can move; by the check and by own programmes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_array

from packgen.check import check_bed, near_pairs, wall_clearance
from packgen.errors import PackingError
from packgen.measure.close_packing import close_packing_fraction
from packgen.programmes.solve import Programme, solve
from tests import container_meshes as meshes
from tests.scenes import box, constant, run_scene, uniform

CUBE = box([0, 0, 0], [1, 1, 1])
PERIODIC = {**CUBE, "periodic": ["x", "y", "z"]}
VESSELS = {
    "box": box([1, 2, 3], [2, 3, 4]),
    "slab": {**CUBE, "periodic": ["x", "y"]},
    "cylinder": {"cylinder": {"radius": 0.5, "height": 1.0, "axis": "y", "base": [1, 2, 3]}},
    "cone": {"cone": {"radius_bottom": 0.2, "radius_top": 0.6, "height": 1.0}},
    "sphere": {"sphere": {"radius": 0.6, "center": [1, 2, 3]}},
}


def jammed(folder, container, sets, zone, *, seed=0, **params):
    return run_scene(folder, container, sets, algorithm="JAMMED", zones=[zone], seed=seed, params=params)


def fraction(result):
    return float((4.0 / 3.0 * np.pi * result.bed.radius**3).sum()) / result.bed.container.volume


def growth_possible(bed, reach):
    """How much all radii could grow by moves of ``reach`` radii, to first order; by rows of its own."""
    period = bed.container.period
    pairs = list(near_pairs(bed.position, bed.radius, gap_fraction=4 * reach, period=period))
    first = np.concatenate([each.first for each in pairs])
    second = np.concatenate([each.second for each in pairs])
    way = bed.position[first] - bed.position[second]
    for axis, along in enumerate(period):
        if along is not None:
            way[:, axis] -= along * np.round(way[:, axis] / along)
    distance = np.linalg.norm(way, axis=1)
    count, number, apart = bed.count, np.arange(len(first)), bed.radius[first] + bed.radius[second]
    unit = way / distance[:, None]
    axes = np.arange(3)
    row = np.concatenate([np.repeat(number, 3), np.repeat(number, 3), number])
    ends = [(3 * each[:, None] + axes).ravel() for each in (first, second)]
    column = np.concatenate([*ends, np.full(len(number), 3 * count)])
    value = np.concatenate([-unit.ravel(), unit.ravel(), apart])
    most, gain = np.full(3 * count + 1, reach * float(bed.radius.mean())), np.zeros(3 * count + 1)
    gain[-1], most[-1] = 1.0, 1.0
    least = -most
    most[:3] = least[:3] = 0.0
    rows = coo_array((value, (row, column)), (len(number), 3 * count + 1)).tocsr()
    return solve(Programme(gain, rows, distance - apart, None, least, most)).objective


def test_a_periodic_bed_is_isostatic_and_its_proof_holds(tmp_path):
    result = jammed(tmp_path, PERIODIC, constant(0.05), {"n_particles": 200})
    bed, proof = result.bed, result.jamming
    assert bed.count == 200
    assert (bed.radius == 0.05).all()
    assert proof.certificate == "programme"
    assert proof.proven
    # 24 seeds: all of them, fraction 0.634 to 0.642, rattlers 0 to 0.03.
    assert proof.isostatic_excess == 0
    held = round((1.0 - proof.rattlers) * 200)
    assert proof.contacts == 3 * (held - 1) + 1
    assert proof.force_residual < 1e-10
    assert proof.overlap_max < 1e-11
    assert proof.gap_max < 1e-9
    assert 0.628 < fraction(result) < 0.648
    assert check_bed(bed).overlap_max < 1e-11
    assert proof.extent == pytest.approx(bed.container.bounds[1] - bed.container.bounds[0])
    assert proof.extent == pytest.approx([proof.factor] * 3)
    period = bed.container.period
    pairs = list(near_pairs(bed.position, bed.radius, gap_fraction=1e-9, period=period))
    touching = np.concatenate([np.stack([each.first, each.second]) for each in pairs], axis=1)
    # Rattlers may lie at a neighbour, too.
    assert proof.contacts <= touching.shape[1] <= proof.contacts + 3 * (200 - held)
    assert growth_possible(bed, 1e-3) < 1e-9


def test_a_bed_with_more_room_is_not_jammed_by_the_same_programme(tmp_path):
    from dataclasses import replace

    from packgen.geometry.scaling import scaled_container

    bed = jammed(tmp_path, PERIODIC, constant(0.05), {"n_particles": 100}).bed
    wider = replace(bed, position=1.001 * bed.position, container=scaled_container(bed.container, 1.001))
    assert growth_possible(wider, 1e-2) == pytest.approx(1e-3, rel=0.2)


@pytest.mark.parametrize("name", VESSELS)
def test_every_container_jams_and_keeps_its_shape(name, tmp_path):
    result = jammed(tmp_path, VESSELS[name], constant(0.05), {"n_particles": 100})
    proof = result.jamming
    assert result.bed.count == 100
    assert proof.overlap_max < 1e-11
    assert proof.gap_max < 1e-6
    # 24 seeds each: 0.52 to 0.55, slabs to 0.64; cones hold fewer.
    assert 0.48 < fraction(result) < 0.66
    ratio = np.array(proof.extent) / np.array(proof.extent_asked)
    assert ratio == pytest.approx([proof.factor] * 3)
    assert proof.rattlers < 0.2
    clearance = wall_clearance(result.bed.container, result.bed.position, 2.0 * result.bed.radius)
    assert (clearance >= 0.05 * (1.0 - 1e-11)).all()
    assert (clearance <= 0.05 * (1.0 + 1e-6)).sum() > 20


@pytest.mark.parametrize("name", ["torus", "icosahedron"])
def test_a_mesh_jams_and_is_scaled(name, tmp_path):
    import trimesh

    mesh = meshes.torus() if name == "torus" else trimesh.creation.icosahedron()
    container = {"path": meshes.saved(mesh, tmp_path)}
    result = jammed(tmp_path, container, constant(0.1), {"n_particles": 60})
    assert result.jamming.overlap_max < 1e-11
    assert result.jamming.factor != 1.0
    assert 0.35 < fraction(result) < 0.6  # 20 seeds: 0.487 +- 0.003 and 0.539 +- 0.005
    corners = result.bed.container.surface.vertices
    assert corners.max(axis=0) - corners.min(axis=0) == pytest.approx(result.jamming.extent)


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("name", ["box", "cylinder", "sphere"])
def test_few_spheres_jam_in_walls(name, count, tmp_path):
    result = jammed(tmp_path, VESSELS[name], constant(0.05), {"n_particles": count})
    closed = {("box", 1): np.pi / 6.0, ("sphere", 1): 1.0, ("cylinder", 1): 2.0 / 3.0, ("sphere", 2): 0.25}
    if (name, count) in closed:
        assert fraction(result) == pytest.approx(closed[name, count], abs=1e-6)
    if (name, count) == ("box", 2):
        side = result.jamming.extent[0] / 0.05
        assert side == pytest.approx(2.0 + 2.0 / np.sqrt(3.0), abs=1e-6)
    assert result.bed.count == count


@pytest.mark.parametrize("count", [1, 3])
def test_few_spheres_between_plane_walls_are_proven_to_be_jammed(count, tmp_path):
    proof = jammed(tmp_path, VESSELS["box"], constant(0.05), {"n_particles": count}).jamming
    assert proof.proven
    assert proof.force_residual < 1e-9
    assert proof.gap_max < 1e-12


@pytest.mark.parametrize("count", [1, 2, 5])
def test_too_few_spheres_for_a_periodic_box_are_refused_with_the_number_that_is_enough(count, tmp_path):
    with pytest.raises(
        PackingError, match=r"becomes 0\.\d+ m long along x, expected at least 0\.2 m.*about 10"
    ):
        jammed(tmp_path, PERIODIC, constant(0.05), {"n_particles": count})


def test_a_narrow_periodic_box_holds_spheres_that_meet_no_image_twice(tmp_path):
    result = jammed(tmp_path, PERIODIC, constant(0.05), {"n_particles": 12})
    assert min(result.jamming.extent) >= 0.2
    assert result.jamming.proven


def test_sizes_1_to_30_jam_together(tmp_path):
    sets = [constant(0.3), constant(0.01)]
    zone = {"n_particles": 2500, "set_proportions": [0.004, 0.996]}
    result = jammed(tmp_path, CUBE, sets, zone, certificate=False)
    assert (result.bed.radius == 0.3).sum() == 10
    assert (result.bed.radius == 0.01).sum() == 2490


def test_a_tube_of_one_and_a_half_diameters_is_filled(tmp_path):
    tube = {"cylinder": {"radius": 0.075, "height": 2.0}}
    result = jammed(tmp_path, tube, constant(0.05), {}, adjust="count")
    assert result.jamming.factor == 1.0
    # A zigzag that touches itself and the wall fills 0.47, one file of spheres 0.30. 20 seeds: 0.326 each.
    assert 0.30 < fraction(result) < 0.47


@pytest.mark.parametrize("name", VESSELS)
def test_a_container_that_stays_gets_the_number_that_it_holds(name, tmp_path):
    result = jammed(tmp_path, VESSELS[name], constant(0.06), {}, adjust="count", certificate=False)
    proof = result.jamming
    assert proof.adjusted == "count"
    assert proof.factor == 1.0
    assert proof.extent == proof.extent_asked
    # At most what was left to spare, and the volume of a sphere or two. 20 seeds each: 0.004 +- 0.004, in the
    # cone up to 0.018, and fractions of 0.565 to 0.621.
    assert 0.0 <= proof.slack < 0.04
    assert fraction(result) > 0.5


def test_a_location_is_filled_where_the_container_stays(tmp_path):
    zone = {"location": {"slice": {"axis": "z", "min_bound": 0.2, "max_bound": 0.8}}}
    bed = jammed(tmp_path, CUBE, constant(0.05), zone, adjust="count", certificate=False).bed
    assert bed.position[:, 2].min() >= 0.25 * (1.0 - 1e-9)
    assert bed.position[:, 2].max() <= 0.75 * (1.0 + 1e-9)
    assert bed.count * 4.0 / 3.0 * np.pi * 0.05**3 / 0.6 > 0.54  # 20 seeds: 0.579 +- 0.002


REFUSED = {
    "two zones": ([{"n_particles": 50}, {"n_particles": 50}], {}, "found 2 zones, expected one"),
    "location": (
        [{"n_particles": 50, "location": {"sphere": {"radius": 0.4, "center": [0.5, 0.5, 0.5]}}}], {},
        r"found a location, expected none.*adjust: count",
    ),
    "amount": ([{"n_particles": 50}], {"adjust": "count"}, "found 50 spheres asked for, expected no amount"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_jammed_is_refused(name, tmp_path):
    zones, params, message = REFUSED[name]
    with pytest.raises(PackingError, match=message):
        run_scene(tmp_path, CUBE, constant(0.05), algorithm="JAMMED", zones=zones, params=params)


def test_the_same_seed_makes_the_same_bed_and_another_one_another(tmp_path):
    one, same, other = (
        jammed(tmp_path, PERIODIC, uniform(0.03, 0.06), {"n_particles": 60}, seed=seed).bed
        for seed in (3, 3, 4)
    )
    assert (one.position == same.position).all()
    assert (one.radius == same.radius).all()
    assert (one.container.bounds == same.container.bounds).all()
    assert one.position.shape == other.position.shape
    assert not (one.position == other.position).all()


def test_the_digits_of_a_length_do_not_matter(tmp_path):
    far = {**box([1000, -1000, 500], [1001, -999, 501]), "periodic": ["x", "y", "z"]}
    result = jammed(tmp_path, far, constant(0.05), {"n_particles": 60})
    assert result.jamming.overlap_max < 1e-9
    assert 0.58 < fraction(result) < 0.72  # 20 seeds: 0.642 +- 0.012, up to 0.669


@pytest.mark.slow
@pytest.mark.physics
def test_a_higher_start_makes_a_denser_bed_of_random_close_packing(tmp_path):
    # 20 seeds each of 2,500 spheres: 0.6370 +- 0.0007 and 0.6405 +- 0.0006, 0.0035 +- 0.0011 apart.
    def mean(start):
        zone = {"n_particles": 2500}
        beds = [
            jammed(tmp_path, PERIODIC, constant(0.05), zone, seed=seed, phi_start=start) for seed in range(2)
        ]
        return np.mean([fraction(each) for each in beds])

    loose, dense = mean(0.65), mean(0.68)
    assert loose < dense
    assert loose == pytest.approx(0.637, abs=0.003)
    assert dense == pytest.approx(0.6405, abs=0.003)


LAWS = {
    "1:1.4": ([constant(0.05), constant(0.07)], {"set_proportions": [0.5, 0.5]}, 0.17),
    "1:2": ([constant(0.05), constant(0.1)], {"set_proportions": [0.5, 0.5]}, 0.33),
    "1:5": (
        [constant(0.02), constant(0.1)], {"set_proportions": [0.2, 0.8], "proportions_by": "volume"}, None,
    ),
    "lognormal 0.3": ({"radius_distribution": "lognormal", "radius_median": 0.05, "sigma": 0.3}, {}, 0.31),
    "lognormal 0.5": ({"radius_distribution": "lognormal", "radius_median": 0.03, "sigma": 0.5}, {}, None),
    "sieve": (
        {"radius_distribution": "sieve", "diameters": [0.02, 0.04, 0.08, 0.2], "passing": [0, 0.3, 0.6, 1]},
        {}, None,
    ),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.physics
@pytest.mark.parametrize("name", LAWS)
def test_mixtures_are_as_dense_as_random_close_packing_has_them(name, tmp_path):
    sets, shares, narrow = LAWS[name]
    container = {**box([0, 0, 0], [2, 2, 2]), "periodic": ["x", "y", "z"]}
    result = jammed(tmp_path, container, sets, {"n_particles": 4000, **shares})
    radius = result.bed.radius
    assert fraction(result) < close_packing_fraction(radius) + 0.005
    assert fraction(result) > close_packing_fraction(radius) - 0.03
    if narrow:
        # Desmond and Weeks, Phys. Rev. E 90 (2014) 022204: simulated packings of sizes that differ little.
        spread = radius.std() / radius.mean()
        skew = ((radius - radius.mean()) ** 3).mean() / radius.std() ** 3
        assert spread == pytest.approx(narrow, abs=0.05)
        assert fraction(result) > 0.634 + 0.0658 * spread + 0.0857 * skew * spread**2 - 0.002


@pytest.mark.slow
@pytest.mark.physics
def test_spheres_that_change_places_pack_more_densely(tmp_path):
    sets, zone = uniform(0.03, 0.09), {"n_particles": 1000}
    gains = [
        fraction(jammed(tmp_path, PERIODIC, sets, zone, seed=seed, certificate=False, swap=True))
        - fraction(jammed(tmp_path, PERIODIC, sets, zone, seed=seed, certificate=False))
        for seed in range(3)
    ]
    assert min(gains) > 0.005
