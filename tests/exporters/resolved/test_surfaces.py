from __future__ import annotations

import numpy as np
import pytest

from exporters.resolved import surfaces
from exporters.resolved.treatment import meeting_owners
from tests.exporters.resolved_cases import shells


@pytest.mark.parametrize("error", [0.2, 0.05, 0.02, 0.003])
def test_no_coarser_icosphere_would_do(error):
    chosen = surfaces.subdivisions_for(error)
    assert surfaces.chord_error(chosen) <= error
    assert chosen == 0 or surfaces.chord_error(chosen - 1) > error


@pytest.mark.parametrize("seed", range(6))
def test_cut_spheres_are_closed_and_inside_of_their_planes_within_the_chord_error(seed):
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=(seed + 1, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    plane = rng.uniform(0.7, 0.999, seed + 1)
    (body,) = shells(surfaces.cut_sphere(normal, plane, 0.03))
    assert (body @ normal.T <= plane + 1e-9).all()
    assert np.linalg.norm(body, axis=2).max() <= 1 + 1e-12
    across = np.cross(body[:, 1] - body[:, 0], body[:, 2] - body[:, 0])
    across /= np.linalg.norm(across, axis=1)[:, None]
    distance = np.einsum("fi,fi->f", across, body[:, 0])
    curved = (across @ normal.T).max(axis=1) < 1 - 1e-9
    assert distance[curved].min() >= 1 - 0.03
    assert (np.linalg.norm(body, axis=2) >= plane.min() - 1e-12).all()


def test_features_meet_where_their_angles_add_up_to_more_than_is_between():
    direction = np.array([[1.0, 0, 0], [0, 1, 0], [1, 0, 0], [0.6, 0.8, 0], [0, 0, 1]])
    owner = np.array([0, 0, 3, 3, 3])
    assert meeting_owners(owner, direction, np.full(5, np.radians(30))).tolist() == [3]
    assert meeting_owners(owner, direction, np.full(5, np.radians(25))).tolist() == []
