from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from packgen.bed import Material
from packgen.measure import standing
from packgen.measure.standing import BLOCK_SIZE, BLOCKS
from tests.beds import box_container, cubic_lattice, fcc_lattice, make_bed

EDGE = 2.0 * np.sqrt(2.0) * 0.1  # of a cubic cell of four touching spheres


def fcc_bed(cells=3, sides=(True, True, False), floor=0.25 * EDGE - 0.1, **changes):
    """A face-centred stack that lies on its floor, wrapped around at its sides."""
    width = cells * EDGE
    container = box_container([0, 0, floor], [width, width, 9.0], sides)
    return make_bed(fcc_lattice(cells, 0.1), 0.1 * (1.0 - 1e-9), container, **changes)


def test_a_crystal_on_a_floor_stands_without_friction():
    found = standing(fcc_bed())
    assert found.friction_least == 0.0
    assert found.stands
    assert found.falling == 0
    assert found.spheres == 108
    assert found.blocks == 0


def test_a_lattice_in_a_box_stands_without_friction():
    bed = make_bed(cubic_lattice(4, 0.1), 0.1, box_container([0, 0, 0], [0.8, 0.8, 2.0]))
    assert standing(bed).friction_least == 0.0


def test_spheres_in_one_place_have_no_contact_that_carries_them():
    centres = cubic_lattice(3, 0.1)
    bed = make_bed([*centres, centres[-1]], 0.1, box_container([0, 0, 0], [0.6, 0.6, 2.0]))
    found = standing(bed)
    assert found.stands
    assert found.friction_least == 0.0


def test_a_bed_without_its_floor_falls():
    found = standing(fcc_bed(floor=-1.0))
    assert found.not_carried == pytest.approx(1.0, abs=1e-6)
    assert found.friction_least is None
    assert not found.stands
    assert found.falling == 108


def test_a_floating_sphere_is_counted_and_the_others_stand():
    bed = fcc_bed()
    position = np.concatenate([bed.position, [[0.4, 0.4, 5.0]]])
    found = standing(make_bed(position, bed.radius[0], bed.container))
    assert found.falling == 1
    assert found.not_carried == pytest.approx(1 / 109, abs=1e-3)
    assert found.stands


def test_a_bed_shaken_out_of_its_contacts_does_not_stand():
    bed = fcc_bed()
    spread = replace(bed, position=bed.position * [1, 1, 1.03])
    assert not standing(spread).stands


@pytest.mark.parametrize("slope", [0.2, 0.4])
def test_a_slope_stands_from_about_the_tangent_of_its_angle_on(slope):
    # The spheres of a layer that slides downhill as a whole are held by the floor's friction alone.
    tilted = fcc_bed(gravity=np.array([9.81 * np.sin(slope), 0.0, -9.81 * np.cos(slope)]))
    assert standing(tilted).friction_least == pytest.approx(np.tan(slope), rel=0.1)


def test_walls_have_their_own_friction():
    gravity = 9.81 * np.array([np.sin(0.3), 0.0, -np.cos(0.3)])
    materials = Material("ore", friction=0.9), Material("ice", friction=0.05)
    bed = fcc_bed(gravity=gravity, materials=materials)
    assert standing(bed).stands
    assert not standing(replace(bed, wall_material="ice")).stands


@pytest.mark.parametrize("shift", [0.05, 0.31])
def test_seams_may_lie_anywhere(shift):
    gravity = 9.81 * np.array([np.sin(0.3), 0.0, -np.cos(0.3)])
    bed = fcc_bed(gravity=gravity)
    moved = bed.position + np.array([shift, 0.5 * shift, 0.0])
    moved[:, :2] %= 3 * EDGE
    here, there = standing(bed), standing(replace(bed, position=moved))
    assert there.not_carried == pytest.approx(here.not_carried, abs=1e-4)
    assert there.friction_least == pytest.approx(here.friction_least, abs=0.02)


def test_gravity_may_point_anywhere():
    bed = fcc_bed(gravity=np.array([0.5, 0.0, -9.8]))
    low, high = bed.container.bounds
    turned = make_bed(
        bed.position[:, [2, 0, 1]],
        bed.radius,
        box_container(low[[2, 0, 1]], high[[2, 0, 1]], (False, True, True)),
        gravity=np.array([-9.8, 0.5, 0.0]),
    )
    assert standing(turned).friction_least == pytest.approx(standing(bed).friction_least, abs=0.011)


def test_blocks_of_a_large_bed_are_looked_at():
    bed = fcc_bed(cells=8)
    found = standing(bed)
    assert found.blocks == BLOCKS
    assert BLOCK_SIZE < found.spheres <= BLOCKS * BLOCK_SIZE
    assert found.friction_least == 0.0
    apart = standing(replace(bed, radius=bed.radius * 0.98))
    assert apart.not_carried == pytest.approx(1.0)
    assert not apart.stands


def test_blocks_never_ask_for_more_than_the_whole_does():
    bed = fcc_bed(cells=5, gravity=np.array([1.5, 0.0, -9.7]))
    holes = np.random.default_rng(3).permutation(bed.count) < 60
    bed = make_bed(bed.position[~holes], bed.radius[0], bed.container, gravity=bed.gravity)
    whole, blocks = standing(bed), standing(bed, whole_max=10)
    assert blocks.blocks == BLOCKS
    assert blocks.friction_least <= whole.friction_least + 0.02


def test_beds_that_rest_on_nothing_are_not_asked():
    bed = fcc_bed()
    assert standing(replace(bed, gravity=np.zeros(3))) is None
    assert standing(make_bed(np.empty((0, 3)), 0.1, bed.container)) is None
    assert standing(fcc_bed(sides=(True, True, True))) is None
    assert standing(replace(bed, body_index=np.zeros(bed.count, np.int32))) is None


def test_beds_of_unknown_weight_friction_or_walls_are_not_asked():
    bed = fcc_bed()
    sets = tuple(replace(each, density=math.nan) for each in bed.particle_sets)
    for unknown in (
        replace(bed, particle_sets=sets),
        replace(bed, materials=()),
        replace(bed, container=replace(bed.container, walls_known=False)),
    ):
        assert standing(unknown) is None
