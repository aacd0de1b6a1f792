"""Claims on sets of clumps in a scene file: what they may say, what is wrong, and what the sizes mean."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from packgen.errors import SceneError
from packgen.scene import Scene, load_scene

HEAD = "container: {box: {min: [0, 0, 0], max: [1, 1, 1]}}\n"
CONSTANT = "radius_distribution: constant, radius: 0.1"
RING = "ring: {radius: 1}, spheres: 12"


def scene(folder: Path, more: str, line: str = "") -> Scene:
    path = folder / "scene.yaml"
    path.write_text(f"{HEAD}{line}\nparticle_sets: [{{{CONSTANT}{more}}}]\n", encoding="utf-8")
    (folder / "bad.csv").write_text("1 2 3\n", encoding="utf-8")
    (folder / "two.csv").write_text("x,y,z,r\n-0.4,0,0,0.5\n0.4,0,0,0.5\n", encoding="utf-8")
    return load_scene(path)


FAULTS = [
    (", shape: ring", "shape: found 'ring', expected a mapping of keys"),
    (", shape: {}", "shape: found none of them, expected exactly one of spheres with a file, mesh, dumbbell"),
    (", shape: {spheres: 7}", "shape: found none of them, expected exactly one of"),
    (", shape: {spheres: 0, ring: {radius: 1}}", "spheres: found 0, expected the path of a file of spheres"),
    (", shape: {spheres: no.csv}", "shape.spheres: found 'no.csv', expected a file that exists"),
    (", shape: {spheres: bad.csv}", "shape: found '1 2 3' in"),
    (", shape: {mesh: no.stl, spheres: 30}", "shape.mesh: found 'no.stl', expected a file that exists"),
    (", shape: {dumbell: {radius: 1}}", "shape.dumbell: found an unknown key, expected one of best_fit"),
    (", shape: {dumbbell: {radius: 1}}", "shape.dumbbell.distance: found nothing, expected this key"),
    (", shape: {rod: {radius: -1, length: 3}}", "shape.rod.radius: found -1, expected a number"),
    (", shape: {rod: {radius: 2, length: 3}}", "shape: found length=3 in rod, expected more than two radii"),
    (", shape: {ring: {radius: 1}, rod: {radius: 1, length: 3}}", "ring: found rod and ring, expected"),
    (", shape: {ring: {radius: 1}, spheres: 2}", "shape: found spheres=2 in ring, expected at least 3"),
    (", shape: {ring: {radius: 1}, equal: true}", "shape.equal: found true, expected this key only"),
    (", shape: {cube: {side: 1, edge: 0.2}}", "shape.cube: found no number of spheres, expected"),
    (", size: sieve", "size: found sieve, expected this key only beside shape"),
    (", orientation: aligned", "orientation: found aligned, expected this key only beside shape"),
    (f", shape: {{{RING}}}, size: mesh", "size: found 'mesh', expected one of equivalent, sieve"),
    (f", shape: {{{RING}}}, orientation: up", "orientation: found 'up', expected random, aligned, x, y, z"),
    (f", shape: {{{RING}}}, orientation: [0, 0, 0]", "orientation: found [0, 0, 0], expected random"),
]  # fmt: skip


@pytest.mark.parametrize(("more", "words"), FAULTS, ids=[more for more, _ in FAULTS])
def test_what_is_wrong_with_a_shape_is_one_line_with_its_place(tmp_path, more, words):
    with pytest.raises(SceneError) as caught:
        scene(tmp_path, more)
    (found,) = caught.value.problems
    assert found.startswith("scene.yaml:") or str(tmp_path) in found
    assert "particle_sets[0]." in found
    assert words in found


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("algorithm: JAMMED", "particle_sets[0].shape: found a clump, expected none: not supported yet"),
        ("params: {optimizer: adam}", "found a clump, expected none: not supported yet by ADAM; leave it"),
        ("zones: [{solid_fraction: 0.5}]", "zones[0].solid_fraction: found 0.5, expected none: not"),
        ("zones: [{porosity: 0.4}]", "zones[0].porosity: found 0.4, expected none"),
        ("start_from: two.csv", "start_from: found two.csv, expected none: not supported yet with clumps"),
        ("params: {batch_size: 100}", "params.batch_size: found 100, expected none: not supported yet"),
    ],
)  # fmt: skip
def test_what_does_not_take_clumps_is_refused_by_name(tmp_path, line, words):
    scene(tmp_path, f", shape: {{{RING}}}")
    with pytest.raises(SceneError) as caught:
        scene(tmp_path, f", shape: {{{RING}}}", line)
    assert any(words in each for each in caught.value.problems)


def test_a_file_of_spheres_is_the_shape(tmp_path):
    form = scene(tmp_path, ", shape: {spheres: two.csv}, orientation: z").particle_sets[0].form
    assert np.allclose(form.template.spheres, [[-0.4, 0.0, 0.0, 0.5], [0.4, 0.0, 0.0, 0.5]], atol=1e-12)
    assert form.orientation == (0.0, 0.0, 1.0)


def test_the_radius_is_that_of_the_sphere_of_a_clumps_volume(tmp_path):
    each = scene(tmp_path, ", shape: {spheres: two.csv}").particle_sets[0]
    assert each.distribution.radius_bounds == (0.1, 0.1)


def test_a_sieve_size_is_the_side_of_the_hole_that_the_clump_passes(tmp_path):
    each = scene(tmp_path, ", shape: {spheres: two.csv}, size: sieve").particle_sets[0]
    # Endways a dumbbell passes where its spheres do.
    scale = each.distribution.radius_bounds[0] / each.template.equivalent_radius
    assert scale * 0.5 == pytest.approx(0.1, rel=1e-4)


def test_a_clump_of_one_sphere_is_a_sphere(tmp_path):
    (tmp_path / "one.csv").write_text("0 0 0 3\n", encoding="utf-8")
    assert scene(tmp_path, ", shape: {spheres: one.csv}, size: sieve").particle_sets[0].form is None


def test_mass_and_volume_count_no_place_twice(tmp_path):
    each = scene(tmp_path, ", shape: {spheres: two.csv}").particle_sets[0]
    assert each.distribution.mean_volume() == pytest.approx(4.0 / 3.0 * np.pi * 1e-3)
    assert each.template.volume < 2.0 * np.pi / 6.0
