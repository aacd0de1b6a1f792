"""packgen from Python, by the names that it offers itself."""

from __future__ import annotations

import numpy as np
import pytest

from packgen import build_report, check_bed, load_container, load_scene, pack

SCENE = """\
container: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
params: {optimizer: OPTIMIZER}
particle_sets: [{radius_distribution: uniform, radius_min: 0.08, radius_max: 0.12}]
zones: [{n_particles: 30}]
"""


@pytest.mark.parametrize("optimizer", ["projection", pytest.param("adam", marks=pytest.mark.slow)])
def test_neither_bed_nor_report_depends_on_the_threads(tmp_path, optimizer):
    path = tmp_path / "box.yaml"
    path.write_text(SCENE.replace("OPTIMIZER", optimizer))
    scene = load_scene(path)
    container = load_container(scene)
    one, two = (pack(scene, container, threads=threads).bed for threads in (1, 2))
    assert one.count == 30
    assert np.array_equal(one.position, two.position)
    assert np.array_equal(one.radius, two.radius)
    assert build_report(one, threads=1).as_json() == build_report(two, threads=3).as_json()
    assert check_bed(one).within_tolerance
