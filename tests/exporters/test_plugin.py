"""A third party's exporter, installed as any package is, is on the command line."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

ROOT = Path(__file__).resolve().parents[2]
SCENE = """\
container: {box: {min: [0, 0, 0], max: [1, 1, 1]}}
particle_sets: [{radius_distribution: constant, radius: 0.2}]
zones: [{n_particles: 5}]
"""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A folder with the plug-in installed by pip; the environment of the tests stays as it is."""
    folder = tmp_path_factory.mktemp("site")
    install = [sys.executable, "-m", "pip", "install", "--quiet", "--no-deps", "--no-build-isolation"]
    subprocess.run(
        [*install, "--target", str(folder), str(ROOT / "tests" / "plugin")],
        check=True, capture_output=True, timeout=120,
    )  # fmt: skip
    return folder


def run(site, folder, *arguments):
    (folder / "five.yaml").write_text(SCENE)
    paths = os.pathsep.join([str(site), str(ROOT)])
    return subprocess.run(
        [sys.executable, "-m", "packgen", "five.yaml", "--quiet", *arguments], cwd=folder,
        env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, timeout=120, check=False,
    )  # fmt: skip


def test_an_installed_plug_in_exports_the_bed(site, tmp_path):
    done = run(site, tmp_path, "--export", "heights", "--export-option", "heights.axis=x")
    assert done.returncode == 0, done.stderr
    heights = np.loadtxt(tmp_path / "five" / "heights" / "heights.txt")
    with np.load(tmp_path / "five" / "bed.npz") as bed:
        assert np.array_equal(heights, bed["position"][:, 0])


def test_without_it_the_name_is_unknown(site, tmp_path):
    done = run(tmp_path / "nowhere", tmp_path, "--export", "heights")
    assert done.returncode == 2
    assert "no exporter is called 'heights'" in done.stderr
