"""Is a mesh the walls of a vessel, or what is within?"""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from packgen.container.thick_walls import held_volume, steel_remark
from packgen.geometry import Surface
from tests import container_meshes as meshes
from tests.beds import box_surface

UP = np.array([0.0, 0.0, 1.0])
CUP = [(0.0, 0.0), (1.1, 0.0), (1.1, 2.0), (1.0, 2.0), (1.0, 0.1), (0.0, 0.1)]  # radius, height


def surface_of(mesh):
    return Surface(np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int64))


def remark(mesh, up=UP):
    return steel_remark(surface_of(mesh), abs(mesh.volume), mesh.convex_hull.volume, up)


@pytest.mark.parametrize("turn", [None, [1, 0, 0], [1, 1, 1]], ids=str)
def test_a_cup_with_thick_walls_is_told_whichever_way_is_up(turn):
    cup, up = meshes.revolved(CUP), UP
    if turn is not None:
        matrix = trimesh.transformations.rotation_matrix(2.0, turn)
        cup.apply_transform(matrix)
        up = matrix[:3, :3] @ up
    assert held_volume(surface_of(cup), up) == pytest.approx(np.pi * 1.9, rel=0.1)
    assert "export its inner surface alone" in remark(cup, up)


def test_a_shell_within_a_shell_is_told_too():
    outer, inner = (
        meshes.revolved([(0, 0), (1.1, 0), (1.1, 2), (0, 2)]),
        meshes.revolved([(0, 0.1), (1, 0.1), (1, 1.9), (0, 1.9)]),
    )
    inner.invert()
    assert "a hollow of about" in remark(meshes.joined(outer, inner))


@pytest.mark.parametrize(
    "mesh", [lambda: meshes.u_bend(open_top=False), meshes.torus, lambda: meshes.hopper(open_top=False)]
)
def test_vessels_themselves_are_not(mesh):
    assert remark(mesh()) is None
    assert steel_remark(box_surface([0, 0, 0], [1, 1, 1]), 1.0, 1.0, UP) is None
