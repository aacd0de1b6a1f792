from __future__ import annotations

import numpy as np
import pytest

from packgen.check.wall_contacts import wall_contacts
from packgen.geometry import Ball, Cone, Mesh, Polyhedron
from tests.beds import BOX_FACES, box_container, box_surface, make_container

UNIT = box_surface([0, 0, 0], [1, 1, 1])
AXES = np.concatenate([np.eye(3), -np.eye(3)])


def found(container, position, radius=0.1, gap=1e-3):
    """The contacts as a sorted list of (sphere, direction)."""
    position = np.asarray(position, float).reshape(-1, 3)
    sphere, normal, away = wall_contacts(container, position, np.full(len(position), radius), gap)
    assert (away <= radius * (1.0 + gap)).all()
    return sorted((int(one), *np.round(each, 9) + 0.0) for one, each in zip(sphere, normal, strict=True))


SHAPES = [
    box_container([0, 0, 0], [1, 1, 1]),
    make_container(Polyhedron(AXES, np.array([1.0, 1, 1, 0, 0, 0]), UNIT), UNIT, 1.0),
    make_container(Mesh(UNIT), UNIT, 1.0),
]


@pytest.mark.parametrize("container", SHAPES, ids=["box", "polyhedron", "mesh"])
def test_a_sphere_in_a_corner_touches_three_walls_and_one_in_the_middle_none(container):
    assert found(container, [[0.1, 0.1, 0.1], [0.5, 0.5, 0.5], [0.9, 0.5, 0.4]]) == [
        (0, -1, 0, 0),
        (0, 0, -1, 0),
        (0, 0, 0, -1),
        (2, 1, 0, 0),
    ]


@pytest.mark.parametrize("container", SHAPES, ids=["box", "polyhedron", "mesh"])
def test_a_wall_is_touched_up_to_the_gap(container):
    assert found(container, [0.5, 0.5, 0.10005]) == [(0, 0, 0, -1)]
    assert found(container, [0.5, 0.5, 0.1002]) == []
    assert found(container, [0.5, 0.5, 0.0999]) == [(0, 0, 0, -1)]


def test_a_seam_is_no_wall():
    periodic = box_container([0, 0, 0], [1, 1, 1], (True, True, False))
    assert found(periodic, [0.1, 0.1, 0.1]) == [(0, 0, 0, -1)]
    assert found(box_container([0, 0, 0], [1, 1, 1], (True, True, True)), [0.1, 0.1, 0.1]) == []


def test_a_cones_side_pushes_across_it():
    cone = Cone(np.zeros(3), np.array([0, 0, 1.0]), 2.0, 0.0, 2.0)  # 45 degrees
    container = make_container(cone, box_surface([-2, -2, 0], [2, 2, 2]), 1.0)
    half = np.sqrt(0.5)
    height = 1.0
    across = height - 0.1 / half
    assert found(container, [across, 0, height]) == [(0, round(half, 9), 0, round(-half, 9))]
    assert found(container, [0, 0, 1.9]) == [(0, 0, 0, 1)]


def test_a_ball_pushes_inwards():
    container = make_container(Ball(np.ones(3), 1.0), box_surface([0, 0, 0], [2, 2, 2]), 1.0)
    assert found(container, [1, 1, 0.1]) == [(0, 0, 0, -1)]
    assert found(container, [1, 1, 1]) == []


def test_triangles_that_meet_in_a_plane_or_an_edge_are_one_contact():
    # The middle of the floor lies on the diagonal of its two triangles.
    assert len(BOX_FACES) == 12
    assert found(SHAPES[2], [[0.5, 0.5, 0.1], [0.5, 0.503, 0.1]]) == [(0, 0, 0, -1), (1, 0, 0, -1)]
