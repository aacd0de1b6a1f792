"""Bodies from where their spheres are now."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from packgen.bodies import (
    Bodies,
    body_centres,
    in_one_piece,
    members_of,
    moved_bodies,
    quaternions,
    rotations,
)
from tests.clump_beds import bodies_at, lattice_of_clumps, random_turns


def test_quaternions_and_rotations_are_each_others_way_back():
    turn = np.concatenate([random_turns(50), np.eye(4), [[0.5, -0.5, 0.5, 0.5]]])
    turn = np.where(turn[:, :1] < 0, -turn, turn)
    assert np.abs(quaternions(rotations(turn)) - turn).max() < 1e-15
    theirs = np.roll(Rotation.from_matrix(rotations(turn)).as_quat(canonical=True), 1, axis=1)
    assert np.abs(np.abs((quaternions(rotations(turn)) * theirs).sum(axis=1)) - 1).max() < 1e-14


def test_bodies_that_moved_and_turned_are_found_from_their_spheres():
    bodies = bodies_at(np.arange(18.0).reshape(6, 3), [0, 1, 1, -1, 0, 1])
    after = bodies_at(np.arange(18.0).reshape(6, 3)[::-1], [0, 1, 1, -1, 0, 1], seed=9)
    position, _, owner = members_of(after)
    found = moved_bodies(bodies, position, owner)
    assert np.abs(found.position - after.position).max() < 1e-14
    # A pair turns about its axis as it likes: its spheres are what counts.
    assert np.abs(members_of(found)[0] - position).max() < 1e-14


def test_bodies_on_a_seam_are_put_together_before():
    bed = lattice_of_clumps(singles=True, periodic=(True, False, True))
    joined = in_one_piece(bed.position, bed.body_index, bed.container.period)
    apart = body_centres(bed.bodies, joined, bed.body_index) - bed.bodies.position
    size = bed.container.bounds[1] - bed.container.bounds[0]
    assert np.abs(apart - size * np.rint(apart / size)).max() < 1e-15
    assert isinstance(moved_bodies(bed.bodies, joined, bed.body_index), Bodies)
