"""A container less the inside of a closed mesh."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.container.inner_wall import with_inner_wall
from packgen.container.topology import boundary_edges
from packgen.geometry import Cone, Mesh, Polyhedron, Surface
from tests.beds import box_container, box_surface, make_container


def block(low, high):
    """A closed mesh with the faces of a box."""
    surface = box_surface(low, high)
    return make_container(Mesh(surface), surface, float(np.prod(np.subtract(high, low))))


def enclosed(surface):
    a, b, c = np.moveaxis(surface.vertices[surface.faces], 1, 0)
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def test_a_mesh_within_takes_exactly_its_volume_off():
    carved, told = with_inner_wall(box_container((0, 0, 0), (4, 4, 4)), block((1, 1, 1), (2, 3, 2)))
    assert carved.volume == 64.0 - 2.0
    assert enclosed(carved.shape.surface) == pytest.approx(62.0)
    assert enclosed(carved.surface) == pytest.approx(62.0)
    assert told == "walls: vessel, and vessel as an inner wall"


def test_a_mesh_that_reaches_out_takes_what_is_inside_off_roughly():
    carved, told = with_inner_wall(box_container((0, 0, 0), (4, 4, 4)), block((1, 1, 1), (2, 2, 9)))
    assert carved.volume == pytest.approx(64.0 - 3.0, abs=0.1)
    assert carved.bounds.tolist() == [[0, 0, 0], [4, 4, 9]]
    assert ", of whose volume 0.3" in told


def test_a_mesh_beside_is_left_out():
    box = box_container((0, 0, 0), (4, 4, 4))
    assert with_inner_wall(box, block((5, 0, 0), (6, 1, 1))) == (box, "walls: vessel; vessel is beside it")


def test_an_open_top_stays_open():
    box = box_surface((0, 0, 0), (4, 4, 4))
    lid = (box.vertices[box.faces][:, :, 2] == 4).all(axis=1)
    walls = Surface(box.vertices, box.faces[~lid])
    normal = np.concatenate([np.eye(3), -np.eye(3)])
    shape = Polyhedron(normal, np.array([4.0, 4, 4, 0, 0, 0]), walls)
    carved, _ = with_inner_wall(make_container(shape, walls, 64.0), block((1, 1, 1), (2, 2, 2)))
    assert carved.volume == 63.0
    assert len(boundary_edges(carved.surface)) == 4
    assert len(boundary_edges(carved.shape.surface)) == 0


def test_what_was_round_is_said_to_be_facets_now():
    cone = Cone(np.zeros(3), np.array([0.0, 0.0, 1.0]), 4.0, 2.0, 2.0)
    box = box_surface((-2, -2, 0), (2, 2, 4))
    carved, told = with_inner_wall(make_container(cone, box, 16 * np.pi), block((-1, -1, 1), (1, 1, 2)))
    assert told.endswith("what is round is facets now, up to 1.9e-05 m outside the true wall")
    corner = np.linalg.norm(carved.surface.vertices[:, :2], axis=1).max() - 2.0
    assert corner == pytest.approx(1.9e-5, rel=0.01)
