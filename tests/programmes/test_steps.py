"""Claims on the largest step of spheres: against closed forms, lattices, and brute force."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.programmes.solve import NoSolutionError, Programme, solve
from packgen.programmes.steps import PairRows, Pins, WallRows, largest_step
from tests.programmes.lattices import FIRST_STILL, NO_WALLS, cubic_close_packing, forces_left, rows_of

NO_PAIRS = PairRows(np.empty(0, np.int64), np.empty(0, np.int64), np.empty((0, 3)), np.empty(0))
NO_PINS = Pins(np.empty(0, np.int64), np.empty((0, 3)))


def walls_of(center, radius, low, high):
    """The six walls of a box round each sphere."""
    rows = [
        (i, side * (center[i, axis] - bound) - radius[i], side * np.eye(3)[axis], radius[i])
        for i in range(len(center))
        for axis in range(3)
        for side, bound in ((1.0, low[axis]), (-1.0, high[axis]))
    ]
    sphere, gap, normal, own = zip(*rows, strict=True)
    return WallRows(np.array(sphere), np.array(gap), np.array(normal), np.array(own))


def grown_to_the_end(center, radius, low, high, pairs=lambda _c, _r: NO_PAIRS):
    """Step after step until nothing grows."""
    for _ in range(60):
        step = largest_step(
            len(center), pairs(center, radius), walls_of(center, radius, low, high), NO_PINS, 0.1
        )
        center, radius = center + step.move, radius * np.sqrt(1.0 + step.gain)
        if step.gain < 1e-12:
            break
    return center, radius, step


def test_a_sphere_in_a_box_grows_to_half_its_least_side():
    center, radius, step = grown_to_the_end(
        np.array([[0.3, 0.4, 0.7]]), np.array([0.1]), np.zeros(3), np.array([1.0, 1.2, 2.0])
    )
    assert radius[0] == pytest.approx(0.5, abs=1e-9)
    assert center[0, 0] == pytest.approx(0.5, abs=1e-9)
    assert step.wall_force[:2] == pytest.approx(step.wall_force[0])
    assert step.wall_force[2:] == pytest.approx(0.0, abs=1e-9)


def test_two_spheres_in_a_cube_grow_until_they_lie_on_its_diagonal():
    def pair(center, radius):
        return PairRows(np.array([0]), np.array([1]), center[[0]] - center[[1]], radius[[0]] + radius[[1]])

    start = np.array([[0.3, 0.35, 0.4], [0.7, 0.6, 0.65]])
    _, radius, step = grown_to_the_end(start, np.full(2, 0.1), np.zeros(3), np.ones(3), pair)
    # The distance sqrt(3) (1 - 2 r) of the centres is 2 r.
    assert radius == pytest.approx(np.sqrt(3.0) / (2.0 + 2.0 * np.sqrt(3.0)), abs=1e-8)
    wall = step.wall_force[step.wall_force > 1e-9]
    assert len(wall) == 6
    assert wall == pytest.approx(step.pair_force[0] / np.sqrt(3.0), rel=1e-6)


@pytest.mark.parametrize("strain", [0.0, 0.05], ids=["cell fixed", "cell free"])
def test_a_close_packing_is_jammed_and_its_forces_balance(strain):
    center, cell = cubic_close_packing(2)
    pairs = rows_of(center, cell, np.full(len(center), 0.5), 0.1)
    step = largest_step(len(center), pairs, NO_WALLS, FIRST_STILL, 0.05, strain)
    assert abs(step.gain) < 1e-9
    assert np.abs(forces_left(len(center), pairs, step.pair_force)).max() < 1e-9 * step.pair_force.max()


def test_a_loose_packing_grows_and_no_step_makes_an_overlap():
    center, cell = cubic_close_packing(2, 1.1)
    center = center + np.random.default_rng(0).uniform(-0.03, 0.03, center.shape)
    radius = np.full(len(center), 0.5)
    step = largest_step(len(center), rows_of(center, cell, radius, 0.6), NO_WALLS, FIRST_STILL, 0.1)
    assert step.gain > 0.1
    assert (step.move[0] == 0.0).all()
    grown = radius * np.sqrt(1.0 + step.gain)
    after = rows_of(center + step.move, cell, grown, 0.2)
    assert (np.linalg.norm(after.separation, axis=1) >= after.apart * (1.0 - 1e-9)).all()


def test_a_cell_that_is_free_to_change_shape_lets_lines_of_touching_spheres_grow():
    axis = np.arange(3.0)
    center = np.stack(np.meshgrid(axis, axis, 1.2 * axis, indexing="ij"), axis=-1).reshape(-1, 3)
    cell, radius = np.array([3.0, 3.0, 3.6]), np.full(27, 0.5)
    pairs = rows_of(center, cell, radius, 0.5)
    fixed = largest_step(27, pairs, NO_WALLS, FIRST_STILL, 0.05)
    free = largest_step(27, pairs, NO_WALLS, FIRST_STILL, 0.05, 0.05)
    assert abs(fixed.gain) < 1e-9
    # The z axis gives what it can, and x and y take half of it each: 1 + 2 e is what a line's rows allow.
    assert np.diag(free.strain) == pytest.approx([0.025, 0.025, -0.05], abs=1e-6)
    assert free.gain == pytest.approx(0.05, abs=1e-6)
    assert np.trace(free.strain) == pytest.approx(0.0, abs=1e-12)


def test_duals_are_what_a_wider_row_gains():
    gain, rows, most = (
        np.array([1.0, 2.0]),
        np.array([[1.0, 1.0], [1.0, 3.0], [1.0, 0.0]]),
        np.array([4.0, 6, 9]),
    )
    from scipy.sparse import csr_array

    def solved(bound):
        return solve(Programme(gain, csr_array(rows), bound, None, np.zeros(2), np.full(2, np.inf)))

    first = solved(most)
    assert first.objective == pytest.approx(5.0)
    for row in range(3):
        wider = most + 0.01 * (np.arange(3) == row)
        assert solved(wider).objective - 5.0 == pytest.approx(0.01 * first.dual[row], abs=1e-9)


def test_a_programme_without_a_solution_says_so():
    from scipy.sparse import csr_array

    impossible = Programme(
        np.ones(1), csr_array(np.array([[1.0]])), np.array([-1.0]), None, np.zeros(1), np.ones(1)
    )
    with pytest.raises(NoSolutionError, match="1 columns"):
        solve(impossible)
