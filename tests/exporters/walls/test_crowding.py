"""Room for the facets near one sphere: LIGGGHTS stops where it is too small."""

from __future__ import annotations

import numpy as np
import pytest

from exporters.walls.crowding import NEIGHBORS_USUAL, PAGE_USUAL, neighbor_room
from exporters.walls.facets import wall_facets
from tests.scenes import box, constant, read_scene


def facets_of(container, tmp_path):
    return wall_facets(read_scene(tmp_path, container, constant(0.01))[1])


@pytest.mark.parametrize("radius", [0.02, 0.1, 0.3, 0.9])
def test_no_sphere_has_more_facets_near_it_than_there_is_room_for(tmp_path, radius):
    facets = facets_of({"sphere": {"radius": 1.0}}, tmp_path)
    skin, rng = 0.5 * radius, np.random.default_rng(1)
    direction = rng.normal(size=(50, 3))
    center = (1.0 - radius) * direction / np.linalg.norm(direction, axis=1)[:, None]
    corner = np.linalg.norm(facets.triangles[None] - center[:, None, None], axis=3).min(axis=2)
    near = (corner < radius + skin).sum(axis=1).max()
    one, page = neighbor_room(facets, radius, skin)
    assert near <= one <= max(len(facets.triangles), NEIGHBORS_USUAL)
    assert page >= max(10 * one, PAGE_USUAL)


def test_small_spheres_and_coarse_walls_leave_the_room_as_it_is(tmp_path):
    facets = facets_of({"sphere": {"radius": 1.0}}, tmp_path)
    assert neighbor_room(facets, 0.01, 0.005) == (NEIGHBORS_USUAL, PAGE_USUAL)
    assert neighbor_room(facets_of(box([0, 0, 0], [1, 1, 1]), tmp_path), 0.5, 0.2)[0] == NEIGHBORS_USUAL
    assert neighbor_room(None, 0.5, 0.2) == (NEIGHBORS_USUAL, PAGE_USUAL)
