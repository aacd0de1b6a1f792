from __future__ import annotations

import base64
import json
from dataclasses import replace

import numpy as np
import pytest

from packgen.page.spheres import Spheres, faithful_part, view_data
from tests.beds import cubic_lattice


def spheres(position, radius, up=(0.0, 0.0, 1.0)):
    count = len(position)
    none, each = np.zeros(count, dtype=np.int32), np.arange(count, dtype=np.int32)
    return Spheres(position, np.full(count, radius), none, none, each, np.array(up))


def shown(view):
    """Centres and radii as the page draws them, (N, 4)."""
    place = np.frombuffer(base64.b64decode(view["place"]), dtype="<u2").reshape(-1, 3)
    size = np.frombuffer(base64.b64decode(view["size"]), dtype="u1")
    radius = view["radius_min"] * (view["radius_max"] / view["radius_min"]) ** (size / 255)
    return np.column_stack([np.array(view["span"]) * (place / 32767.5 - 1), radius])


def ordered(position):
    """Points in the order of their coordinates."""
    return position[np.lexsort(np.round(position, 3).T)]


def test_all_spheres_of_a_small_bed_are_shown_around_its_middle():
    position = cubic_lattice(4, 0.5)
    view = view_data(spheres(position, 0.5))
    assert (view["count"], view["shown"]) == (64, 64)
    assert view["half"] == pytest.approx([2.0, 2.0, 2.0])
    np.testing.assert_allclose(ordered(shown(view)[:, :3]), ordered(position - 2.0), atol=1e-4)
    assert shown(view)[:, 3] == pytest.approx(0.5)


def test_labels_and_sizes_stay_with_their_spheres():
    rng = np.random.default_rng(0)
    count = 300
    radius = rng.uniform(0.01, 0.1, count)
    group, zone, batch = (rng.integers(0, top, count).astype(np.int32) for top in (2, 3, 9))
    position = np.column_stack([group, zone, batch]) + 0.01 * rng.normal(size=(count, 3))
    view = view_data(Spheres(position, radius, group, zone, batch, np.array([0.0, 0.0, 1.0])))
    rows = np.repeat([each[1:] for each in view["labels"]], [each[0] for each in view["labels"]], axis=0)
    middle = 0.5 * ((position - radius[:, None]).min(axis=0) + (position + radius[:, None]).max(axis=0))
    found = shown(view)
    np.testing.assert_array_equal(np.round(found[:, :3] + middle), rows)
    nearest = np.linalg.norm(found[:, None, :3] + middle - position[None], axis=2).argmin(axis=1)
    np.testing.assert_allclose(found[:, 3], radius[nearest], rtol=0.01)


def test_spheres_that_may_be_seen_come_first():
    count = 20
    view = view_data(spheres(cubic_lattice(count, 0.5), 0.5))
    found = shown(view)[:, :3]
    depth = (0.5 * count - np.abs(found)).min(axis=1)  # below the nearest face
    assert 0 < view["outer"] < len(found)
    assert depth[view["outer"] :].min() > 2.0


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, 1, 0), (0, 0.6, 0.8)])
def test_up_is_up_in_the_view_and_nothing_is_mirrored(up):
    up = np.array(up, dtype=float)
    position = np.random.default_rng(0).normal(size=(20, 3))
    radius = np.linspace(0.1, 0.2, 20)  # tells which is which
    index = np.zeros(20, dtype=np.int32)
    found = shown(view_data(Spheres(position, radius, index, index, index, up)))
    turned = found[np.argsort(found[:, 3]), :3]
    assert np.ptp(turned[:, 2] - position @ up) < 1e-3
    edges, seen = position[1:4] - position[0], turned[1:4] - turned[0]
    assert np.linalg.det(seen) == pytest.approx(np.linalg.det(edges), rel=1e-2)


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
    assert view["shown"] == 480_000
    assert len(json.dumps(view)) < 4_700_000


def test_a_sphere_without_a_place_is_counted_but_not_shown():
    view = view_data(spheres(np.array([[0.5, 0.5, 0.5], [np.nan, 0.0, 0.0]]), 0.1))
    assert (view["count"], view["shown"]) == (2, 1)
    assert np.isfinite(shown(view)).all()


def test_spheres_of_a_body_have_one_colour_and_neighbours_in_the_list_another():
    position = cubic_lattice(4, 0.5)
    body = np.repeat(np.arange(32, dtype=np.int32), 2)
    view = view_data(replace(spheres(position, 0.5), body_index=body))
    colour = np.frombuffer(base64.b64decode(view["body"]), dtype="u1")
    apart = np.linalg.norm(shown(view)[:, None, :3] + 2.0 - position[None], axis=2)
    np.testing.assert_array_equal(colour, body[apart.argmin(axis=1)] % 8)
    assert "body" not in view_data(spheres(position, 0.5))


def test_a_cut_takes_each_body_by_its_middle_and_parts_across_a_seam_by_their_own_places():
    grid = 2.0 * np.stack(np.meshgrid(*[np.arange(4.0)] * 3, indexing="ij"), axis=-1).reshape(-1, 1, 3)
    position = (grid + np.array([[0.0, -0.4, 0.1], [0.2, 0.6, 0.0]])).reshape(-1, 3)
    body = np.repeat(np.arange(64, dtype=np.int32), 2)
    own, middle = position[:, 1].copy(), np.repeat(position.reshape(-1, 2, 3).mean(axis=1)[:, 1], 2)
    body[-1] = 0  # the first body has a third sphere far away, and its last one lost a sphere
    middle[[0, 1, -2, -1]] = own[[0, 1, -2, -1]]
    view = view_data(replace(spheres(position, 0.3), body_index=body))
    depth = view["span"][1] * (np.frombuffer(base64.b64decode(view["depth"]), dtype="<u2") / 32767.5 - 1)
    centre = 0.5 * (position.min(axis=0) + position.max(axis=0))
    nearest = np.linalg.norm(shown(view)[:, None, :3] + centre - position[None], axis=2).argmin(axis=1)
    np.testing.assert_allclose(depth + centre[1], middle[nearest], atol=1e-3)


def test_a_part_has_the_bodies_that_a_cut_in_half_lays_open():
    count = 24
    position = cubic_lattice(count, 0.5) - 0.5 * count + [0.0, 0.25, 0.0]
    row = np.round(position[:, 1] - position[:, 1].min()).astype(int)
    depth = position[:, 1].min() + 2.0 * (row // 2) + 0.5  # of pairs, one sphere behind the other
    part = faithful_part(position, np.full(len(position), 0.5), 6000, depth)
    first = np.flatnonzero(depth == depth[depth >= 0.0].min())
    front = first[position[first, 1] < depth[first]]
    assert len(front) == count**2
    assert set(front.tolist()) <= set(part.tolist())
