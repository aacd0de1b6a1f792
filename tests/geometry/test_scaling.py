"""Claims on scaled containers: every length is, the fixed point is not, and the check agrees."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from packgen.check import wall_clearance
from packgen.geometry.scaling import fixed_point, scaled_container
from tests import container_meshes as meshes
from tests.scenes import box, constant, read_scene

CONTAINERS = {
    "box": box([1, 2, 3], [2, 4, 6]),
    "periodic": {**box([1, 2, 3], [2, 4, 6]), "periodic": ["x"]},
    "cylinder": {"cylinder": {"radius": 0.5, "height": 2.0, "base": [1, 2, 3], "axis": "y"}},
    "cone": {"cone": {"radius_bottom": 0.2, "radius_top": 1.0, "height": 2.0, "base": [1, 2, 3]}},
    "sphere": {"sphere": {"radius": 1.5, "center": [1, 2, 3]}},
    "convex mesh": "icosahedron",
    "mesh": "torus",
}


@pytest.mark.parametrize("name", CONTAINERS)
def test_distances_from_walls_are_scaled_about_the_fixed_point(name, tmp_path):
    spec = CONTAINERS[name]
    if isinstance(spec, str):
        mesh = meshes.torus() if spec == "torus" else trimesh.creation.icosahedron()
        spec = {"path": meshes.saved(mesh, tmp_path)}
    _, vessel = read_scene(tmp_path, spec, constant(0.05))
    larger, still = scaled_container(vessel, 1.7), fixed_point(vessel)
    assert fixed_point(larger) == pytest.approx(still)
    assert larger.volume == pytest.approx(1.7**3 * vessel.volume)
    assert larger.bounds - still == pytest.approx(1.7 * (vessel.bounds - still))
    assert larger.periodic == vessel.periodic
    low, high = vessel.bounds
    points = np.random.default_rng(0).uniform(low, high, (200, 3))
    reach = np.full(200, 10.0)
    before = wall_clearance(vessel, points, reach)
    after = wall_clearance(larger, still + 1.7 * (points - still), 1.7 * reach)
    assert after == pytest.approx(1.7 * before, abs=1e-9)
    corner = vessel.surface.vertices
    assert larger.surface.vertices - still == pytest.approx(1.7 * (corner - still))
