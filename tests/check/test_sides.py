"""Which zones stand free, in beds made by hand: a lattice in a location, in a wider container."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.check.sides import free_standing_zones
from packgen.geometry import Ball, Box, Cone, Mesh, Slice
from tests.beds import box_container, box_surface, make_bed

R = 0.1
TILT = np.array([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]])


def block(counts, corner=(0.0, 0.0, 0.0)):
    """Spheres that touch, so many along x, y and z, in a box from a corner."""
    steps = [R * (2.0 * np.arange(count) + 1.0) for count in counts]
    return np.array(corner) + np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 3)


def bed_of(*blocks, container, **changes):
    zone = np.repeat(np.arange(len(blocks), dtype=np.int32), [len(each) for each in blocks])
    return make_bed(np.concatenate(blocks), R, container, zone_index=zone, **changes)


COLUMN = Box([0, 0, 0], [1, 1, 2])
WIDE = box_container([0, 0, 0], [4, 1, 2])


def test_a_column_in_a_wider_vessel_stands_free_on_the_side_where_nothing_is():
    bed = bed_of(block([5, 5, 10]), container=WIDE)
    (found,) = free_standing_zones(bed, [(COLUMN,)])
    assert found.zone == 0
    # One of four sides, without the two lowest layers, which would fall no farther than two diameters.
    assert found.free / found.looked_at == pytest.approx(0.25 * 0.75, abs=0.08)
    assert 2.0 * R * 3 < found.fall < 2.0 * R * 9


def test_a_column_in_the_middle_stands_free_on_two_sides():
    bed = bed_of(block([5, 5, 10], (1.5, 0, 0)), container=WIDE)
    (found,) = free_standing_zones(bed, [(Box([1.5, 0, 0], [2.5, 1, 2]),)])
    # Spheres in its corners lean against a wall as well, and may count as held.
    assert 6 / 16 * 0.65 < found.free / found.looked_at < 10 / 16 * 0.75


@pytest.mark.parametrize(
    "shape",
    [
        Box([1.5, 1.5, 0], [2.5, 2.5, 2]),
        Mesh(box_surface([1.5, 1.5, 0], [2.5, 2.5, 2])),
        Cone([2.0, 2.0, 0.0], [0, 0, 1], 2.0, 0.5, 0.5),
        Ball([2.0, 2.0, 1.0], 1.0),
    ],
    ids=["box", "mesh", "cylinder", "ball"],
)
def test_any_form_of_location_stands_free_all_around_in_a_wide_vessel(shape):
    spheres = block([5, 5, 10], (1.5, 1.5, 0))
    if isinstance(shape, Cone | Ball):  # rings that touch the round side
        angle = 2.0 * np.pi * np.arange(12) / 12
        height = np.arange(0.1, 2.0, 0.2)
        across = (
            np.full(10, 0.4) if isinstance(shape, Cone) else np.sqrt(0.81 - np.minimum(height - 1, 0.9) ** 2)
        )
        ring = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * across[:, None, None]
        spheres = np.concatenate(
            [
                np.column_stack([2.0 + each, np.full(12, level)])
                for each, level in zip(ring, height, strict=True)
            ]
        )
    bed = bed_of(spheres, container=box_container([0, 0, 0], [4, 4, 2]))
    (found,) = free_standing_zones(bed, [(shape,)])
    assert found.free / found.looked_at > 0.5


def test_what_is_filled_beside_a_zone_holds_it_as_high_as_it_is():
    first, beside = block([5, 5, 10]), Box([1, 0, 0], [4, 1, 2])
    for layers, free in ((10, False), (9, False), (8, False), (3, True)):
        bed = bed_of(first, block([15, 5, layers], (1, 0, 0)), container=WIDE)
        found = free_standing_zones(bed, [(COLUMN,), (beside,)])
        assert [each.zone for each in found] == ([0] if free else [])


def test_a_gap_too_narrow_to_be_filled_is_no_free_side():
    for width, free in ((0.9 * 2.0 * R, False), (3.0 * 2.0 * R, True)):
        bed = bed_of(block([5, 5, 10]), container=box_container([0, 0, 0], [1 + width, 1, 2]))
        assert bool(free_standing_zones(bed, [(COLUMN,)])) == free


def test_a_few_large_spheres_do_not_make_a_wide_gap_narrow():
    radius = np.full(250, R)
    radius[125] = 0.19  # of a sphere somewhere inside: its size alone counts here
    bed = make_bed(block([5, 5, 10]), radius, box_container([0, 0, 0], [1.5, 1, 2]))
    assert len(free_standing_zones(bed, [(COLUMN,)])) == 1


@pytest.mark.parametrize(
    "shape",
    [
        None,
        Box([0, 0, 0], [4, 1, 2]),
        Box([-1, -1, -1], [5, 2, 3]),
        Slice(np.array([0.0, 0.0, 1.0]), 0.0, 2.0, centers_only=True),
        Slice(np.array([0.0, 1.0, 0.0]), 0.0, 1.0, centers_only=False),
        Mesh(box_surface([0, 0, 0], [4, 1, 2])),
    ],
    ids=["none", "container", "larger", "layer", "wall to wall", "mesh"],
)
def test_the_containers_walls_hold_the_sides(shape):
    bed = bed_of(block([20, 5, 10]), container=WIDE)
    assert free_standing_zones(bed, [() if shape is None else (shape,)]) == ()


def test_a_slice_along_gravity_stands_free():
    bed = bed_of(block([5, 5, 10]), container=WIDE)
    (found,) = free_standing_zones(bed, [(Slice(np.array([1.0, 0, 0]), 0.0, 1.0, centers_only=False),)])
    assert found.free >= 30


@pytest.mark.parametrize("layers", [1, 2])
def test_a_zone_of_one_or_two_layers_needs_no_side(layers):
    bed = bed_of(block([5, 5, layers]), container=WIDE)
    assert free_standing_zones(bed, [(COLUMN,)]) == ()


def test_a_heap_flatter_than_spheres_lie_needs_no_side_and_a_steep_one_does():
    for height, free in ((0.7, False), (4.0, True)):
        cone = Cone([2.0, 2.0, 0.0], [0, 0, 1], height, 2.0, 0.0)
        grid = block([20, 20, int(height / (2 * R))])
        slant = np.hypot(1.0, 2.0 / height)
        depth = (2.0 * (1.0 - grid[:, 2] / height) - np.linalg.norm(grid[:, :2] - 2.0, axis=1)) / slant
        bed = bed_of(grid[depth > R], container=box_container([-2, -2, 0], [6, 6, 5]))
        assert bool(free_standing_zones(bed, [(cone,)])) == free


def test_sides_are_those_along_gravity_in_whatever_direction_it_points():
    # Gravity along x: the column lies, and its former top is a side.
    bed = bed_of(block([5, 5, 5]), container=box_container([0, 0, 0], [1, 1, 4]), gravity=[9.81, 0, 0])
    (found,) = free_standing_zones(bed, [(Box([0, 0, 0], [1, 1, 1]),)])
    assert found.free / found.looked_at == pytest.approx(0.25 * 0.6, abs=0.08)
    # Tilted by 37 degrees: the column's high side has nothing beside it.
    bed = bed_of(block([5, 5, 10]), container=WIDE, gravity=TILT @ [0.0, 0.0, -9.81])
    assert [each.zone for each in free_standing_zones(bed, [(Box([0, 0, 0], [1, 1, 2]),)])] == [0]
    full = bed_of(block([20, 5, 10]), container=WIDE, gravity=TILT @ [0.0, 0.0, -9.81])
    assert free_standing_zones(full, [(Box([0, 0, 0], [4, 1, 2]),)]) == ()


def test_images_beyond_a_seam_hold_a_zone():
    periodic = box_container([0, 0, 0], [4, 1, 2], periodic=(True, False, False))
    whole = bed_of(block([20, 5, 10]), container=periodic)
    assert free_standing_zones(whole, [(Box([0, 0, 0], [4, 1, 2]),)]) == ()
    part = bed_of(block([5, 5, 10]), container=periodic)
    (found,) = free_standing_zones(part, [(COLUMN,)])
    assert found.free / found.looked_at == pytest.approx(0.5 * 0.75, abs=0.1)
    # Across a seam: the same column, half of it at either end of the box.
    shifted = block([5, 5, 10]) - np.array([0.5, 0.0, 0.0])
    across = bed_of(np.mod(shifted, [4.0, 9.0, 9.0]), container=periodic)
    (same,) = free_standing_zones(across, [(Box([-0.5, 0, 0], [0.5, 1, 2]),)])
    assert (same.free, same.looked_at) == (found.free, found.looked_at)
    two = bed_of(block([5, 5, 10]), block([15, 5, 10], (1, 0, 0)), container=periodic)
    assert free_standing_zones(two, [(COLUMN,), (Box([1, 0, 0], [4, 1, 2]),)]) == ()


def test_without_gravity_nothing_falls_out():
    bed = bed_of(block([5, 5, 10]), container=WIDE, gravity=np.zeros(3))
    assert free_standing_zones(bed, [(COLUMN,)]) == ()
