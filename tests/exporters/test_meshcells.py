"""Spheres in the cells of a mesh: closed forms against the library, which they leave the rest to."""

from __future__ import annotations

import numpy as np
import overlap
import pytest

from exporters.meshcells import closed_forms, mesh_volumes, planes_of

BOX = np.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float
)
WEDGE = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
TETRA = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
TURN = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
TURN *= np.sign(np.linalg.det(TURN))
SHEAR = np.array([[1.0, 0.3, 0.1], [0.0, 1.2, -0.2], [0.0, 0.0, 0.8]])
CELLS = {
    "box": ("hexahedron", BOX),
    "turned box": ("hexahedron", BOX @ TURN + 7.0),
    "sheared box": ("hexahedron", BOX @ SHEAR),
    "wedge": ("wedge", WEDGE @ TURN),
    "tetrahedron": ("tetra", TETRA @ SHEAR),
}
ELEMENT = {"hexahedron": overlap.Hexahedron, "wedge": overlap.Wedge, "tetra": overlap.Tetrahedron}


def spheres(corners, count=3000):
    """Spheres of many sizes in and around a cell."""
    rng = np.random.default_rng(0)
    position = rng.uniform(corners.min(axis=0) - 0.3, corners.max(axis=0) + 0.3, (count, 3))
    return position, 0.7 * rng.random(count) ** 2


def shares(name):
    """Volumes by closed forms of the spheres around a cell, with centres and radii."""
    kind, corners = CELLS[name]
    position, radius = spheres(corners)
    one = np.zeros(len(radius), np.int64)
    return closed_forms(position, radius, planes_of(kind, corners[None]), one), position, radius


@pytest.mark.parametrize("name", CELLS)
def test_closed_forms_are_what_the_library_finds(name):
    share, position, radius = shares(name)
    kind, corners = CELLS[name]
    body = ELEMENT[kind](corners)
    known = np.flatnonzero(~np.isnan(share))
    found = [overlap.overlap_volume(overlap.Sphere(position[each], radius[each]), body) for each in known]
    np.testing.assert_allclose(share[known], found, atol=1e-9)
    assert (share[known] > 0.0).sum() > 10


def test_in_boxes_the_library_is_left_the_spheres_that_opposite_faces_cut():
    share, position, radius = shares("turned box")
    inside = (position - 7.0) @ TURN.T
    opposite = ((inside < radius[:, None]) & (inside > 1.0 - radius[:, None])).any(axis=1)
    assert not np.isnan(share[~opposite]).any()
    assert np.isnan(share).any()


def test_a_cell_with_a_warped_face_is_refused():
    warped = BOX + 0.1 * (np.arange(8) == 6)[:, None]
    with pytest.raises(ValueError, match="face"):
        mesh_volumes(*spheres(warped, 3), "hexahedron", warped[None])


@pytest.mark.parametrize("name", CELLS)
def test_the_volume_of_a_cell_is_the_librarys(name):
    kind, corners = CELLS[name]
    _, volume = mesh_volumes(*spheres(corners, 3), kind, corners[None])
    assert volume[0] == pytest.approx(ELEMENT[kind](corners).volume, rel=1e-12)
