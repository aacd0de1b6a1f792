"""What share of a body's mass each of its spheres stands for."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.bodies import SINGLE, Bodies, Template, UnbalancedError, member_shares, sphere_shares
from packgen.clumps import template_of_spheres


@pytest.fixture(scope="module")
def bent():
    spheres = [[0.0, 0, 0, 1.0], [1.1, 0.1, 0, 0.6], [0.3, 1.2, 0.2, 0.9], [0.2, 0.1, 0.9, 0.4]]
    return template_of_spheres("bent", np.array(spheres))


def test_shares_have_the_bodys_mass_and_its_centre_where_the_spheres_own_masses_have_not(bent):
    volume = bent.spheres[:, 3] ** 3
    assert np.abs(volume @ bent.spheres[:, :3] / volume.sum()).max() > 0.01
    shares = member_shares(bent)
    assert (shares > 0).all()
    assert shares.sum() == pytest.approx(1.0, abs=1e-15)
    assert np.abs(shares @ bent.spheres[:, :3]).max() < 1e-12


def test_equal_spheres_in_a_row_have_equal_shares():
    pair = template_of_spheres("pair", np.array([[-0.8, 0, 0, 1.0], [0.8, 0, 0, 1.0]]))
    assert member_shares(pair).tolist() == pytest.approx([0.5, 0.5])


def test_a_body_whose_centre_is_beyond_its_spheres_has_none():
    away = Template("away", np.array([[1.0, 0, 0, 1.0], [2.0, 0, 0, 1.0]]), 4.0, np.eye(3), np.zeros(3))
    with pytest.raises(UnbalancedError, match=r"away.*more spheres"):
        member_shares(away)


def test_spheres_of_many_bodies_have_those_of_their_templates(bent):
    bodies = Bodies((bent,), np.array([SINGLE, 0], np.int32), np.ones(2), np.zeros((2, 3)), np.eye(4)[[0, 0]])
    assert sphere_shares(bodies).tolist() == [1.0, *member_shares(bent).tolist()]
