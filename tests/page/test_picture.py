"""Still pictures, drawn without a display."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest

from packgen.bed import ParticleSet
from packgen.errors import PackgenError
from packgen.page import PICTURES, picture_folder, write_pictures
from packgen.page.render import _seen
from packgen.page.spheres import depth_of_bodies
from tests.page.test_report_page import lattice_folder


def coloured(path):
    """Pixels of a picture that are not grey, (height, width), bool."""
    from matplotlib.image import imread

    return np.ptp(imread(path)[..., :3], axis=-1) > 0.1


def test_the_half_picture_keeps_or_drops_whole_clumps():
    rng = np.random.default_rng(1)
    centre = rng.uniform(-5.0, 5.0, (200, 3))
    offset = np.array([0.0, 0.6, 0.0])
    position = np.concatenate([centre - offset, centre + offset])
    body = np.tile(np.arange(200, dtype=np.int32), 2)
    seen = _seen(position, np.ones(400), depth_of_bodies(position, body), half=True)
    kept = np.bincount(body[seen], minlength=200)
    assert kept.tolist() == np.where(centre[:, 1] >= 0.0, 2, 0).tolist()


@pytest.mark.slow
def test_pictures_show_the_bed_at_true_size_and_are_listed(tmp_path, monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    sets = tuple(ParticleSet(name, 2500.0, "ore") for name in "ab")
    index = (np.arange(125) % 2).astype(np.int32)
    folder = lattice_folder(tmp_path, particle_sets=sets, set_index=index)
    whole, half = map(coloured, picture_folder(folder))
    listed = json.loads((folder / "report.json").read_text())["files"]
    assert set(PICTURES) <= set(listed)
    assert not [path for path in folder.iterdir() if "unfinished" in path.name]
    # Both are five spheres wide, and the half has lost the front of its top.
    assert whole.any(axis=0).sum() == pytest.approx(half.any(axis=0).sum(), abs=3)
    assert half.sum() < whole.sum()


@pytest.mark.slow
def test_equal_spheres_of_one_batch_have_the_colour_of_their_set(tmp_path, monkeypatch):
    from matplotlib.image import imread

    monkeypatch.delenv("DISPLAY", raising=False)
    picture = picture_folder(lattice_folder(tmp_path))[0]
    red, green, blue = imread(picture)[coloured(picture)][:, :3].mean(axis=0)
    assert red < 0.5 * green < 0.5 * blue  # a blue, where a scale would begin with a purple without green


def test_without_anything_to_draw_with_the_reason_is_said_and_nothing_is_left(tmp_path, monkeypatch):
    folder = lattice_folder(tmp_path)
    before = sorted(path.name for path in folder.iterdir())
    crash = [sys.executable, "-c", "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"]
    run = subprocess.run

    def crashing(command, **options):
        return run(crash, **options)

    monkeypatch.setattr("packgen.page.picture.subprocess.run", crashing)
    with pytest.raises(PackgenError, match="apt-get install libegl1"):
        write_pictures(folder)
    assert sorted(path.name for path in folder.iterdir()) == before


def test_a_spoilt_bed_has_no_picture_but_a_reason(tmp_path):
    (tmp_path / "bed.npz").write_text("x")
    with pytest.raises(PackgenError, match="no pictures: "):
        write_pictures(tmp_path)
