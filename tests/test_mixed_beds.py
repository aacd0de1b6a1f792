"""Beds of sizes far apart: every height has its share of each, and they are denser than equal spheres."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.measure import contacts, solid_fraction
from tests.scenes import box, constant, run_scene, uniform

LARGE = 0.03
WIDTH = 20.0 * LARGE


def two_sizes(tmp_path, ratio, fine, count):
    """A column of two sizes; ``fine``: share of the small ones in the volume."""
    solid = 4.0 / 3.0 * np.pi * LARGE**3 / (1.0 - fine + fine * ratio**3)
    height = count * solid / (0.5 * WIDTH**2) + 10.0 * LARGE
    zone = {"n_particles": count, "set_proportions": [1.0 - fine, fine], "proportions_by": "volume"}
    container = box([0] * 3, [WIDTH, WIDTH, height])
    return run_scene(tmp_path, container, [constant(LARGE), constant(LARGE / ratio)], zones=[zone]).bed


def shares(bed, slabs):
    """The share of the large spheres in each of some slabs, those at the floor and the free top left out."""
    bottom, radius = bed.position[:, 2] - bed.radius, bed.radius
    edges = np.linspace(2.0 * LARGE, np.quantile(bed.position[:, 2], 0.9), slabs + 1)
    deep = np.clip(edges[:, None] - bottom, 0.0, 2.0 * radius)
    below = np.pi / 3.0 * deep**2 * (3.0 * radius - deep)
    solid = np.diff(below, axis=0)
    return solid[:, bed.set_index == 0].sum(axis=1) / solid.sum(axis=1)


@pytest.mark.physics
@pytest.mark.parametrize(
    ("ratio", "count", "fine", "core", "off"),
    [  # 20 seeds each: the core's solid fraction, and the share of the slab that is farthest off
        (3.0, 10_000, 0.3, 0.65, 0.05),  # 0.663 to 0.689, by 0.005 to 0.034
        (5.0, 30_000, 0.3, 0.67, 0.12),  # 0.683 to 0.718, by 0.044 to 0.093
        (5.0, 30_000, 0.5, 0.67, 0.10),  # 0.686 to 0.720, by 0.026 to 0.073
    ],
)
def test_two_sizes_are_mixed_at_every_height_and_fill_each_others_voids(
    tmp_path, ratio, count, fine, core, off
):
    bed = two_sizes(tmp_path, ratio, fine, count)
    assert bed.count == count
    assert solid_fraction(bed).core > core
    assert contacts(bed)[-1].none < 0.015  # 20 seeds: at most 0.0099.
    assert np.abs(shares(bed, 4) - (1.0 - fine)).max() < off


def test_the_last_sphere_of_broad_sizes_finds_a_place_in_a_nearly_empty_vessel(tmp_path):
    # To the last digit a random scene whose lowest places were all inside large spheres in the end.
    coarse = uniform(0.01681448277873684, 0.033197089027122914)
    fine = uniform(0.0031669941060677477, 0.01239712135768745)
    sets = [{"name": name, "material": "smooth", **each} for name, each in (("a", coarse), ("b", fine))]
    zone = {
        "volume": 0.007021599805755572,
        "set_proportions": [0.6970355207905582, 0.30296447920944186],
        "proportions_by": "volume",
    }
    vessel = box([0] * 3, [0.41242555388431906, 0.3207853208823834, 0.7158983877124545])
    result = run_scene(
        tmp_path, vessel, sets, zones=[zone], materials={"smooth": {"friction": 0.05}}, seed=157
    )
    assert result.zones[0].placed == result.zones[0].asked > 850  # 20 seeds: 864 to 867.
