"""A bed from Python: from a file or a mapping, saved, loaded, and shown in a notebook."""

from __future__ import annotations

import html
import re
from pathlib import Path

import numpy as np
import pytest

import packgen
from packgen import Bed, load_container, load_scene, pack
from packgen.errors import ExportError, SceneError
from packgen.page import spheres_of, view_data
from tests.beds import box_container, cubic_lattice, make_bed

SCENE = {
    "container": {"box": {"min": [0, 0, 0], "max": [1, 1, 1]}},
    "seed": 3,
    "particle_sets": [{"radius_distribution": "constant", "radius": 0.1}],
    "zones": [{"n_particles": 40}],
}


@pytest.fixture(scope="module")
def packed():
    return pack(SCENE)


def test_a_mapping_and_its_file_give_the_same_bed(packed, tmp_path):
    path = tmp_path / "scene.yaml"
    path.write_text(str(SCENE).replace("'", ""))
    for source in (path, str(path)):
        np.testing.assert_array_equal(pack(source).bed.position, packed.bed.position)
    scene = load_scene(path)
    np.testing.assert_array_equal(pack(scene, load_container(scene)).bed.position, packed.bed.position)


def test_faults_of_a_mapping_are_those_of_a_scene():
    with pytest.raises(SceneError, match="scene: seed: found -1, expected a whole number"):
        pack({**SCENE, "seed": -1})


def test_a_bed_is_saved_and_loaded_with_all_that_is_known(packed, tmp_path):
    bed = packed.bed
    bed.save(str(tmp_path / "mine.npz"))
    again = packgen.Bed.load(tmp_path / "mine.npz")
    for name in ("position", "radius", "set_index", "zone_index", "batch_index", "gravity"):
        np.testing.assert_array_equal(getattr(again, name), getattr(bed, name))
    assert (again.particle_sets, again.materials) == (bed.particle_sets, bed.materials)
    np.testing.assert_array_equal(again.container.bounds, bed.container.bounds)


def test_a_bed_is_saved_under_a_name_that_is_read_again(packed, tmp_path):
    with pytest.raises(ExportError, match=r"mine: expected a name that ends in \.npz"):
        packed.bed.save(tmp_path / "mine")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_jammed_bed_is_loaded_in_the_cell_that_it_has(tmp_path):
    cell = {"box": {"min": [0, 0, 0], "max": [1, 1, 1]}, "periodic": ["x", "y", "z"]}
    bed = pack({**SCENE, "container": cell, "algorithm": "JAMMED"}).bed
    assert bed.container.bounds[1, 0] < 0.95
    bed.save(tmp_path / "bed.npz")
    np.testing.assert_allclose(Bed.load(tmp_path / "bed.npz").container.bounds, bed.container.bounds)


def test_a_notebook_shows_verdict_and_page(packed):
    text = packed._repr_html_()
    assert "✔ complete; 40 spheres, solid fraction 0." in text
    page = html.unescape(re.search(r'srcdoc="([^"]*)"', text)[1])
    assert page.startswith("<!doctype html>")
    assert "<title>scene, bed: complete" in page or "<title>scene: complete" in page
    assert '"outlines":' in page


def test_a_notebook_says_what_a_bed_missed():
    position = cubic_lattice(3, 0.1)
    position[0, 2] += 0.01
    text = make_bed(position, 0.1, box_container([0, 0, 0], [1, 1, 1]))._repr_html_()
    assert "✘ missed: " in text


def test_the_view_has_the_containers_outline_around_the_bed(packed):
    view = view_data(spheres_of(packed.bed))
    assert [each["name"] for each in view["outlines"]] == ["container"]
    # The box reaches higher than the bed, and no farther to its sides than the spheres' free way.
    assert view["frame"]["half"][2] == pytest.approx(0.5)
    assert view["frame"]["middle"][2] > 0.1


def test_walls_that_are_not_known_have_no_outline(tmp_path):
    path = Path(tmp_path, "spheres.csv")
    path.write_text("x,y,z,r\n0,0,0,1\n3,0,0,1\n")
    assert "outlines" not in view_data(spheres_of(packgen.read_bed(path)))
