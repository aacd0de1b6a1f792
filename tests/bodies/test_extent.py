"""Claims on how wide bodies are."""

import numpy as np
import pytest

from packgen.bodies import fits_within, sieve_size

SMALL = 1e-9
CUBE = np.array([[x, y, z, SMALL] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
ANGLE = 2.0 * np.pi * np.arange(100) / 100
HOOP = np.column_stack([np.cos(ANGLE), np.sin(ANGLE), 0.0 * ANGLE, np.full(100, 0.1)])


@pytest.mark.parametrize(
    ("spheres", "side"),
    [
        (np.array([[1.0, 2.0, 3.0, 0.5]]), 1.0),
        (np.array([[-0.4, 0.0, 0.0, 0.5], [0.4, 0.0, 0.0, 0.5]]), 1.0),
        (CUBE, 1.0),
        # Edgeways, slantwise: the centres' circle is a line of length 2 there, with round ends.
        (HOOP, np.sqrt(2.0) + 0.2),
    ],
)
def test_a_sieve_lets_a_body_pass_where_its_least_projection_does(spheres, side):
    assert side * (1.0 - 1e-3) <= sieve_size(spheres) <= side * (1.0 + 1e-4)


def test_a_body_fits_where_one_orientation_does():
    assert fits_within(HOOP, np.array([2.2, 0.21, 2.2]))
    assert not fits_within(HOOP, np.array([2.1, 0.21, 2.1]))
    assert fits_within(HOOP, np.array([np.inf, 0.21, 2.2]))
    assert not fits_within(CUBE, np.array([0.98, 1.1, 1.1]))
