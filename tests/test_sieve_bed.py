"""A bed of eight sieves over a decade of sizes."""

import math

import numpy as np
import pytest

from packgen.distributions import Sieve
from tests.scenes import box, run_scene

DIAMETERS = np.geomspace(0.01, 0.1, 8)
PASSING = [0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0]
COUNT = 100_000


@pytest.mark.slow
def test_a_bed_of_eight_sieves_over_a_decade_has_the_mass_fractions_asked_for(tmp_path):
    sizes = {
        "radius_distribution": "sieve",
        "diameters": [float(each) for each in DIAMETERS],
        "passing": PASSING,
    }
    solid = COUNT * Sieve(DIAMETERS, np.array(PASSING)).mean_volume()
    width = math.cbrt(solid / 0.6)
    # higher than the bed will be: its top is free
    bed = run_scene(
        tmp_path, box([0] * 3, [width, width, 1.3 * width]), sizes, zones=[{"n_particles": COUNT}]
    ).bed
    assert bed.count == COUNT
    mass = bed.radius**3
    reached = [mass[2.0 * bed.radius <= each].sum() / mass.sum() for each in DIAMETERS]
    np.testing.assert_allclose(reached, PASSING, rtol=0, atol=1e-3)  # 20 seeds: at most 0.00023 off.
