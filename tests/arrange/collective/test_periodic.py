"""Periodic boxes: beds along one, two and three axes, with a floor and without, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

import exporters
from packgen.errors import PackingError
from packgen.filling.pack import pack
from packgen.measure import solid_fraction
from tests.beds import make_bed
from tests.scenes import assert_sound, box, constant, read_scene, run_scene

RADIUS = 0.05
LOGNORMAL = {"radius_distribution": "lognormal", "radius_median": RADIUS, "sigma": 0.25,
             "radius_min": 0.027, "radius_max": 0.093}  # fmt: skip
SIZES = {"constant": constant(RADIUS), "lognormal": LOGNORMAL}
# Solid fraction of the core of a bed 32 radii wide, and how far one bed may be off: four standard deviations.
CORES = {  # 21 seeds each
    "constant": {"x": (0.6145, 0.007), "xy": (0.6157, 0.007), "xyz": (0.6100, 0.005)},  # +- 0.0017, 16, 12
    "lognormal": {"x": (0.6273, 0.0125), "xy": (0.6280, 0.0125), "xyz": (0.6240, 0.010)},  # +- 0.0031, 30, 25
}


def periodic_box(axes, low=(0, 0, 0), high=(1, 1, 1)):
    return box(low, high) | {"periodic": list(axes)}


def slab_fractions(bed, axis, count):
    """Solid fraction of slabs across a periodic axis, the first one around the seam; caps exact."""
    low, high = bed.container.bounds[:, axis]
    center = np.concatenate([bed.position[:, axis] + shift for shift in (low - high, 0.0, high - low)])
    radius = np.tile(bed.radius, 3)
    edges = np.linspace(low, high, count + 1) - 0.5 * (high - low) / count
    depth = np.clip(edges[:, None] - center + radius, 0.0, 2.0 * radius)
    below = (math.pi / 3.0 * depth**2 * (3.0 * radius - depth)).sum(axis=1)
    return np.diff(below) / (bed.container.volume / count)


@pytest.mark.parametrize("sizes", SIZES.values(), ids=SIZES)
@pytest.mark.parametrize("axes", ["x", "y", "xy", "xyz", "z", "xz"])
def test_beds_in_periodic_boxes_are_sound_and_lie_within_the_period(tmp_path, axes, sizes):
    high = np.array([0.7, 0.8, 0.9])
    result = run_scene(tmp_path, periodic_box(axes, high=high), sizes)  # sound by the independent check
    bed = result.bed
    wraps = np.array([axis in axes for axis in "xyz"])
    assert (bed.position[:, wraps] >= 0.0).all()
    assert (bed.position[:, wraps] < high[wraps]).all()
    beyond = (bed.position + bed.radius[:, None] > high) | (bed.position < bed.radius[:, None])
    assert beyond[:, wraps].any(axis=0).all(), "no wall keeps spheres off the seam"
    assert not beyond[:, ~wraps].any()
    assert bed.endless == ("z" in axes)
    solid = 4.0 / 3.0 * math.pi * (bed.radius**3).sum() / high.prod()
    # 20 seeds of each case: at least 0.550, with walls along x and z and equal spheres 0.557 +- 0.003.
    assert solid > 0.54


@pytest.mark.parametrize("gravity", ["x", "-y", [0.0, -1.0, -1.0]])
def test_gravity_may_point_anywhere_across_the_periodic_axes(tmp_path, gravity):
    axes = "yz" if gravity == "x" else "x"
    bed = run_scene(tmp_path, periodic_box(axes), constant(0.08), gravity_axis=gravity).bed
    assert bed.count > 235  # 20 seeds along each: 269, 254, 248, all +- 3
    assert not bed.endless


def test_gravity_askew_to_a_periodic_axis_makes_a_level_bed_and_stays_in_the_decks(tmp_path):
    zones = [{"n_particles": 150}]
    slope = [math.sin(0.4), 0.0, -math.cos(0.4)]
    bed = run_scene(tmp_path, periodic_box("x"), constant(0.06), gravity_axis=slope, zones=zones).bed
    assert bed.down == pytest.approx([0, 0, -1])
    assert bed.acceleration == pytest.approx(9.81 * np.array(slope))
    left, right = (bed.position[half, 2] for half in (bed.position[:, 0] < 0.5, bed.position[:, 0] >= 0.5))
    # 20 seeds: 0.003 +- 0.019
    assert np.quantile(left, 0.9) == pytest.approx(np.quantile(right, 0.9), abs=0.08)


def test_an_endless_bed_holds_exactly_what_it_is_asked_for_while_that_fits(tmp_path):
    zones = [{"n_particles": 320}]
    result = run_scene(tmp_path, periodic_box("xyz"), LOGNORMAL, zones=zones)
    assert result.zones[0].placed == 320
    dense = run_scene(tmp_path, periodic_box("xyz"), constant(RADIUS), zones=[{"volume": 0.62}])
    assert dense.zones[0].left_over == 0
    assert dense.bed.count == round(0.62 / (4.0 / 3.0 * math.pi * RADIUS**3))


def test_an_endless_bed_asked_for_too_many_spheres_is_full_and_returns_the_rest(tmp_path):
    result = run_scene(tmp_path, periodic_box("xyz"), constant(0.08), zones=[{"n_particles": 308}])
    # 20 seeds: 0.628 +- 0.004
    assert 0.61 < result.bed.count * 4.0 / 3.0 * math.pi * 0.08**3 < 0.645
    assert result.zones[0].left_over == 308 - result.bed.count


def test_layers_of_an_endless_bed_interlock_across_its_seam(tmp_path):
    halves = [{"slice": {"axis": "z", "min_bound": low, "max_bound": low + 0.5}} for low in (0.0, 0.5)]
    zones = [
        {"location": half, "set_proportions": shares}
        for half, shares in zip(halves, ([1, 0], [0, 1]), strict=True)
    ]
    bed = run_scene(tmp_path, periodic_box("xyz"), [constant(0.06), constant(0.06)], zones=zones).bed
    lower, upper = (bed.position[bed.zone_index == zone, 2] for zone in (0, 1))
    for height, middle in ((lower, 0.25), (upper, 0.75)):
        away = (height - middle + 0.5) % 1.0 - 0.5  # a centre in the seam is at 0.0 for either layer
        assert np.abs(away).max() <= 0.25 + 1e-7
    # The second zone has to fit the first one's rough surfaces on either side, 4 diameters apart.
    assert 0.79 * len(lower) < len(upper) <= len(lower)  # 20 seeds: 0.87 +- 0.02
    assert lower.min() < 0.05, "centres lie up to the seam, spheres beyond it"


def test_a_location_does_not_wrap_around_with_its_spheres(tmp_path):
    ball = {"sphere": {"center": [0.0, 0.5, 0.5], "radius": 0.4}}
    bed = run_scene(tmp_path, periodic_box("x"), constant(0.05), zones=[{"location": ball}]).bed
    assert bed.count > 140  # 20 seeds: 152 +- 2
    assert np.linalg.norm(bed.position - [0.0, 0.5, 0.5], axis=1).max() <= 0.35 + 1e-7


def test_the_same_seed_gives_the_same_periodic_bed(tmp_path):
    for axes in ("xy", "xyz"):
        first, again = (
            run_scene(tmp_path, periodic_box(axes), constant(0.08), seed=3).bed.position for _ in range(2)
        )
        assert np.array_equal(first, again)


def test_boxes_too_narrow_for_their_period_and_adam_are_refused_at_once(tmp_path):
    container = periodic_box("xy", high=(0.3, 1, 1))
    scene, vessel = read_scene(tmp_path, container, constant(0.08), params={"optimizer": "adam"})
    with pytest.raises(PackingError) as caught:
        pack(scene, vessel)
    narrow, adam = str(caught.value).splitlines()
    assert "scene.yaml:" in narrow
    assert "container.periodic: found a box of 0.3 m along x, expected at least 0.32 m" in narrow
    assert "params.optimizer: found adam, expected projection in a periodic box" in adam


@pytest.mark.physics
@pytest.mark.parametrize("sizes", SIZES)
@pytest.mark.parametrize("axes", ["x", "xy", "xyz"])
def test_the_seam_is_as_dense_as_the_middle(tmp_path, axes, sizes):
    found = []
    core, scatter = CORES[sizes][axes]
    for seed in range(3):
        container = periodic_box(axes, high=(1.6, 1.6, 1.6))
        result = pack(*read_scene(tmp_path, container, SIZES[sizes], seed=seed))
        assert_sound(result)
        assert solid_fraction(result.bed).core == pytest.approx(core, abs=scatter)
        found += [slab_fractions(result.bed, axis, 16) for axis in range(3) if "xyz"[axis] in axes]
    found = np.array(found)
    scatter = found.std() / math.sqrt(len(found))
    assert found.mean(axis=0)[0] == pytest.approx(found.mean(), abs=4.0 * scatter)
    assert 4.0 * scatter < 0.02  # 21 seeds, three a time: 0.004 along three axes to 0.015 along one


SPLINTER = """OFF
4 4 0
0.02 0.02 0.02
0.18 0.18 0.18
0.104 0.096 0.1
0.1 0.104 0.096
3 0 1 2
3 0 2 3
3 0 3 1
3 1 3 2
"""


def test_a_zone_thinner_than_its_spheres_in_an_endless_box_stays_empty(tmp_path):
    (tmp_path / "splinter.off").write_text(SPLINTER)
    vessel = {**box([0, 0, 0], [0.2, 0.2, 0.2]), "periodic": ["y", "z"]}
    zones = [{"n_particles": 50}, {"n_particles": 1, "location": {"path": "splinter.off"}}]
    result = run_scene(tmp_path, vessel, constant(0.0085), gravity_axis="z", zones=zones)
    assert [zone.placed for zone in result.zones] == [50, 0]


@pytest.mark.parametrize("low", [0.0, 0.1])
@pytest.mark.parametrize(("first", "last"), [(0.25, 1.0), (0.0, 0.5)])
def test_a_zone_that_ends_at_a_periodic_side_has_its_centres_within_or_on_the_other_side(
    tmp_path, low, first, last
):
    ends = {"axis": "x", "min_bound": low + first, "max_bound": low + last}
    vessel = periodic_box("x", [low] * 3, [low + 1.0] * 3)
    zones = [{"location": {"slice": ends}}]
    result = run_scene(tmp_path, vessel, constant(0.08), gravity_axis="x", zones=zones)
    position, (least, most) = result.bed.position, result.bed.container.bounds
    along = position[:, 0]
    assert (along >= least[0]).all()
    assert (along < most[0]).all()  # where solvers want it: decks have the digits of the bed
    slack = result.bed.tolerance * 0.08
    within = (along >= low + first - slack) & (along <= low + last + slack)
    # A centre on the upper side, or beyond it by the tolerance, is the same point at the lower one.
    on_upper_side = along + 1.0 <= low + last + slack
    on_lower_side = along - 1.0 >= low + first - slack
    assert (within | on_upper_side | on_lower_side).all()


def test_decks_write_a_centre_at_a_side_with_all_its_digits(tmp_path):
    _, vessel = read_scene(tmp_path, periodic_box("xyz"), constant(0.1))
    last = np.nextafter(1.0, 0.0)
    bed = make_bed(np.array([[0.0, 0.5, 0.5], [last, 0.75, 0.5], [0.5, 0.0, last]]), 0.1, vessel)
    for name, file, columns in (
        ("liggghts", "bed.data", slice(4, 7)), ("lammps", "bed.data", slice(4, 7)),
        ("yade", "bed.txt", slice(0, 3)), ("csv", "bed.csv", slice(1, 4)),
    ):  # fmt: skip
        folder = tmp_path / name
        folder.mkdir()
        exporter = exporters.get(name)
        exporter.write(bed, folder, exporter.Options())
        rows = [line.replace(",", " ").split() for line in (folder / file).read_text().split("\n")[-4:-1]]
        assert np.array_equal(np.array(rows)[:, columns].astype(float), bed.position), name
