"""ADAM in vessels that are not convex: what slips through a wall is thrown out."""

from __future__ import annotations

import pytest

from packgen.check import check_bed
from packgen.filling.pack import pack
from tests import container_meshes as meshes
from tests.scenes import constant, read_scene


def packed(folder, mesh, radius, count, n_epoch=100):
    params = {"optimizer": "adam", "tolerance": None, "n_epoch": n_epoch, "batch_size": 20}
    container = {"path": meshes.saved(mesh, folder)}
    keys = {"zones": [{"n_particles": count}], "params": params, "seed": 0}
    return pack(*read_scene(folder, container, constant(radius), **keys))


def test_without_a_tolerance_no_sphere_is_left_outside_a_vessel_that_is_not_convex(tmp_path):
    result = packed(tmp_path, meshes.l_box(open_top=False), 0.15, 20)
    (zone,) = result.zones
    assert zone.placed + zone.left_over == 20
    assert zone.placed > 10
    assert check_bed(result.bed).outside_count == 0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mesh", "radius"),
    [(meshes.l_box(open_top=False), 0.15), (meshes.hopper(open_top=False), 0.08), (meshes.torus(), 0.12)],
    ids=["l_box", "hopper", "torus"],
)
def test_no_vessel_has_spheres_outside(tmp_path, mesh, radius):
    result = packed(tmp_path, mesh, radius, 40)
    assert check_bed(result.bed).outside_count == 0
    assert result.bed.count > 30
