"""The walls near a point: none that it is behind is missing, wherever the point is."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.space.feature_kernels import wall_gap
from packgen.arrange.space.map_kernels import WallList, least_gap
from packgen.arrange.space.walls import no_walls, wall_table, walls_in_reach
from packgen.geometry import Ball, Cone, Polyhedron, Surface
from packgen.geometry.bounds import shape_bounds

UP = np.array([0.0, 0.0, 1.0])
SPLINTER = np.array([[0.0, 0.5, 0.9], [-1.0, -0.7, 0.7], [0.9, -0.5, -0.4], [0.8, -0.2, -0.5]])
FACES = np.array([[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]])


def splinter():
    corners = SPLINTER[FACES]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal *= np.sign(((corners.mean(axis=1) - SPLINTER.mean(axis=0)) * normal).sum(axis=1))[:, None]
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return Polyhedron(normal, (normal * corners[:, 0]).sum(axis=1), Surface(SPLINTER, FACES))


@pytest.mark.parametrize("far", [1.0, 3.0, 1e6])
@pytest.mark.parametrize(
    "shape",
    [splinter(), Cone(np.zeros(3), UP, 2.0, 0.0, 0.4), Ball(np.zeros(3), 0.7)],
    ids=["splinter", "cone", "ball"],
)
def test_a_sphere_beyond_the_vessel_meets_every_wall_that_it_is_behind(shape, far):
    radius, rng = 0.04, np.random.default_rng(1)
    bounds = np.array(shape_bounds(shape))
    table = wall_table([shape], bounds, radius)
    position = bounds.mean(axis=0) + far * (rng.random((400, 3)) - 0.5) * 4.0
    features, ball = table.features, np.column_stack([position, np.full(len(position), radius)])
    gap = np.stack(
        [
            [wall_gap(kind, row, *center, radius)[0] for center in position]
            for kind, row in zip(features.kind, features.row, strict=True)
        ]
    )
    least = least_gap(position, radius, features, table.near)
    np.testing.assert_array_equal(least[least < 0.01], gap.min(axis=0)[least < 0.01])
    np.testing.assert_array_equal(least < 0.01, gap.min(axis=0) < 0.01)
    listed = WallList(*walls_in_reach(ball, np.full(len(ball), 0.01), table, no_walls()))
    owner = np.repeat(np.arange(len(ball)), np.diff(listed.begin))
    pairs = sorted(zip(listed.item[: listed.begin[-1]], owner, strict=True))
    assert pairs == list(zip(*np.nonzero(gap < 0.01), strict=True))
