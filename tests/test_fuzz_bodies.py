"""What the fuzzer knows of bodies, meshes and size laws, held against points and packgen."""

from __future__ import annotations

import json

import numpy as np
import pytest
import trimesh

from tests.fuzz.laws import random_law
from tests.fuzz.shapes import CLOSED, OPEN_TOPPED, random_mesh, random_primitive
from tests.fuzz.solids import Box, Cone, Hull, Solidmesh


def test_bodies_know_how_far_a_point_is_inside():
    box = trimesh.creation.box(extents=[2.0, 2.0, 2.0])
    mesh = Solidmesh(np.asarray(box.vertices), np.asarray(box.faces), np.zeros(12, bool))
    point = np.array([[0.0, 0.0, 0.0], [0.9, 0.0, 0.0], [0.0, -0.9, 0.5], [1.5, 0.0, 0.0]])
    for body in (Box(-np.ones(3), np.ones(3)), mesh, Hull(mesh.vertices)):
        assert body.clearance(point) == pytest.approx([1.0, 0.1, 0.1, -0.5])
    cone = Cone(np.zeros(3), np.array([1.0, 0.0, 0.0]), 1.0, 0.0, 1.0)  # half its angle is 45 degrees
    assert cone.clearance(np.array([[0.5, 0.0, 0.0], [0.5, 0.7, 0.0]])) == pytest.approx(
        [0.5**1.5, -0.2 * 0.5**0.5]
    )
    assert cone.volume == pytest.approx(np.pi / 3.0)
    open_sided = Box(np.zeros(3), np.ones(3), (True, True, False))
    assert open_sided.clearance(np.array([[0.0, -1.0, 0.25]])) == pytest.approx([0.25])


@pytest.mark.parametrize("maker", range(len(OPEN_TOPPED) + len(CLOSED)))
def test_random_meshes_are_closed_and_agree_with_points(maker, monkeypatch):
    chosen = [*OPEN_TOPPED, *CLOSED][maker]
    monkeypatch.setattr("tests.fuzz.shapes.OPEN_TOPPED", [chosen])
    monkeypatch.setattr("tests.fuzz.shapes.CLOSED", [])
    rng = np.random.default_rng(0)
    mesh = random_mesh(rng, np.array([0.0, 0.0, 1.0]), open_top=maker < len(OPEN_TOPPED))
    assert trimesh.Trimesh(mesh.vertices, mesh.faces).is_watertight
    assert mesh.lid.any() == (maker < len(OPEN_TOPPED))
    low, high = mesh.bounds
    share = (mesh.clearance(low + rng.random((1000, 3)) * (high - low)) > 0.0).mean()
    assert share * np.prod(high - low) == pytest.approx(mesh.volume, rel=0.2)


def test_random_primitives_have_the_volume_that_points_find():
    rng = np.random.default_rng(5)
    for _ in range(12):
        body = random_primitive(rng)
        low, high = body.bounds
        share = (body.clearance(low + rng.random((4000, 3)) * (high - low)) > 0.0).mean()
        assert share * np.prod(high - low) == pytest.approx(body.volume, rel=0.15)


def test_laws_have_the_mean_volume_of_packgens(tmp_path):
    from packgen.scene import load_scene

    rng = np.random.default_rng(1)
    for number in range(40):
        law = random_law(rng, 0.1, float(rng.choice([0.1, 0.2, 1.5])), tmp_path, f"radii_{number}")
        spec = {"container": Box(np.zeros(3), np.ones(3)).spec(), "particle_sets": [law.spec]}
        (tmp_path / "scene.yaml").write_text(json.dumps(spec))
        own = load_scene(tmp_path / "scene.yaml").particle_sets[0].distribution
        assert law.mean_volume == pytest.approx(own.mean_volume(), rel=3e-3), law.spec
        assert (law.low, law.high) == pytest.approx(own.radius_bounds, rel=1e-12)
