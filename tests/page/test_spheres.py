from __future__ import annotations

import base64

import numpy as np
import pytest

from packgen.page.spheres import Spheres, faithful_part, view_data
from tests.beds import cubic_lattice


def spheres(position, radius, up=(0.0, 0.0, 1.0)):
    count = len(position)
    index = np.arange(count, dtype=np.int32)
    return Spheres(position, np.full(count, radius), index, index, index, np.array(up))


def shown(view):
    return np.frombuffer(base64.b64decode(view["sphere"]), dtype="<f4").reshape(-1, 4)


def test_all_spheres_of_a_small_bed_are_shown_around_its_middle():
    position = cubic_lattice(4, 0.5)
    view = view_data(spheres(position, 0.5))
    assert (view["count"], view["shown"]) == (64, 64)
    assert view["half"] == pytest.approx([2.0, 2.0, 2.0])
    assert shown(view)[:, :3] == pytest.approx(position - 2.0)
    assert shown(view)[:, 3] == pytest.approx(0.5)


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 1, 0), (0, 0.6, 0.8)])
def test_up_is_up_in_the_view_and_nothing_is_mirrored(up):
    up = np.array(up, dtype=float)
    position = np.random.default_rng(0).normal(size=(20, 3))
    turned = shown(view_data(spheres(position, 0.1, up)))[:, :3].astype(float)
    assert np.ptp(turned[:, 2] - position @ up) < 1e-5
    edges, seen = position[1:4] - position[0], turned[1:4] - turned[0]
    assert np.linalg.det(seen) == pytest.approx(np.linalg.det(edges), rel=1e-4)


def test_a_part_has_every_sphere_of_the_cut_and_of_the_outside():
    count = 24
    position = cubic_lattice(count, 0.5)
    position = position - 0.5 * count + [0.0, 0.25, 0.0]
    part = faithful_part(position, np.full(len(position), 0.5), 6000)
    assert len(part) == len(set(part.tolist())) == 6000
    place = np.round(position - [0.0, 0.25, 0.0] + 0.5 * count - 0.5).astype(int)
    outside = np.flatnonzero((place == 0).any(axis=1) | (place == count - 1).any(axis=1))
    cut = np.flatnonzero(np.abs(position[:, 1]) < 0.5)
    assert len(cut) == count**2
    assert set(cut.tolist()) <= set(part.tolist())
    assert set(outside.tolist()) <= set(part.tolist())


def test_a_page_of_a_million_spheres_stays_small():
    view = view_data(spheres(cubic_lattice(100, 0.01), 0.01))
    assert view["count"] == 1_000_000
    assert view["shown"] < 100_000
    assert len(view["sphere"]) + len(view["label"]) < 4_500_000


def test_a_sphere_without_a_place_is_counted_but_not_shown():
    view = view_data(spheres(np.array([[0.5, 0.5, 0.5], [np.nan, 0.0, 0.0]]), 0.1))
    assert (view["count"], view["shown"]) == (2, 1)
    assert np.isfinite(shown(view)).all()
