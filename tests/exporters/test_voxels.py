"""Voxels: exact shares, middles, and images that Pillow reads."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

from exporters import voxels
from packgen.errors import ExportError
from packgen.measure.core import Core
from packgen.measure.fraction import solid_volume
from tests.beds import box_container, cubic_lattice, make_bed


def pages(path):
    """The image as an array of pages, rows and columns."""
    with Image.open(path) as image:
        found = []
        for index in range(image.n_frames):
            image.seek(index)
            found.append(np.array(image))
    return np.stack(found)


def cloud(**changes):
    rng = np.random.default_rng(9)
    box = box_container((-0.1, 0.2, 0.3), (0.5, 0.6, 0.5), changes.pop("periodic", (False,) * 3))
    position = rng.uniform(box.bounds[0] + 0.05, box.bounds[1] - 0.05, (3, 3))
    return make_bed(position, [0.05, 0.03, 0.02], box, **changes)


def test_shares_are_exact_in_every_voxel(tmp_path):
    bed = cloud()
    voxels.write(bed, tmp_path, voxels.Options(size="0.04"))
    share, told = np.load(tmp_path / "voxels.npy"), json.loads((tmp_path / "voxels.json").read_text())
    assert share.shape == tuple(told["shape"]) == (5, 10, 15)
    spacing, low = np.array(told["voxel_size_xyz"]), np.array(told["lower_corner_xyz"])
    touched = 0
    for z, y, x in np.ndindex(share.shape):
        middle = low + spacing * (np.array([x, y, z]) + 0.5)
        box = Core(middle, np.eye(3), spacing / 2, "a voxel")
        expected = min(solid_volume(bed.position, bed.radius, box) / spacing.prod(), 1.0)
        assert share[z, y, x] == pytest.approx(expected, abs=1e-9)
        touched += 0 < expected < 1
    assert touched > 20
    assert told["volume_cut_off_at_1"] < 1e-12
    assert told["solid_volume_in_voxels"] == pytest.approx(told["spheres_volume"], rel=1e-12)


def test_the_image_has_a_page_for_each_layer(tmp_path):
    bed = cloud()
    paths = voxels.write(bed, tmp_path, voxels.Options(size="0.03"))
    assert [path.name for path in paths] == ["voxels.json", "voxels.npy", "voxels.tif"]
    share = np.load(tmp_path / "voxels.npy")
    image = pages(tmp_path / "voxels.tif")
    assert image.dtype == np.float32
    assert np.array_equal(image, share.astype(np.float32))


def test_binary_voxels_are_solid_where_their_middles_are(tmp_path):
    bed = cloud()
    voxels.write(bed, tmp_path, voxels.Options(size="0.011", binary="true"))
    solid, told = np.load(tmp_path / "voxels.npy"), json.loads((tmp_path / "voxels.json").read_text())
    spacing, low = np.array(told["voxel_size_xyz"]), np.array(told["lower_corner_xyz"])
    z, y, x = np.meshgrid(*(np.arange(count) for count in solid.shape), indexing="ij")
    middle = low + spacing * (np.stack([x, y, z], axis=-1) + 0.5)
    apart = np.linalg.norm(middle[..., None, :] - bed.position, axis=-1)
    assert np.array_equal(solid, (apart <= bed.radius).any(axis=-1))
    image = pages(tmp_path / "voxels.tif")
    assert image.dtype == np.uint8
    assert np.array_equal(image, 255 * solid)


@pytest.mark.parametrize("binary", [False, True])
def test_spheres_across_a_seam_are_on_both_sides(tmp_path, binary):
    box = box_container((0, 0, 0), (1, 1, 1), (True, False, False))
    voxels.write(make_bed([[0.0, 0.5, 0.5]], 0.3, box), tmp_path, voxels.Options(size=0.05, binary=binary))
    share = np.load(tmp_path / "voxels.npy").astype(float)
    assert np.allclose(share, share[:, :, ::-1], atol=1e-12)
    assert share[:, :, :6].sum() > 0


def test_one_file_alone_and_a_size_of_its_own(tmp_path):
    bed = make_bed(cubic_lattice(2, 0.1), 0.1, box_container((0, 0, 0), (0.4, 0.4, 0.4)))
    paths = voxels.write(bed, tmp_path, voxels.Options(format="npy"))
    assert [path.name for path in paths] == ["voxels.json", "voxels.npy"]
    assert np.load(tmp_path / "voxels.npy").shape == (20, 20, 20)
    paths = voxels.write(bed, tmp_path, voxels.Options(format="tif", size=0.2))
    assert [path.name for path in paths] == ["voxels.json", "voxels.tif"]
    assert np.allclose(pages(tmp_path / "voxels.tif"), np.pi / 6)


def test_what_overlaps_is_cut_off_and_said(tmp_path):
    bed = make_bed([[0.5, 0.5, 0.5], [0.5, 0.5, 0.5]], 0.4, box_container((0, 0, 0), (1, 1, 1)))
    voxels.write(bed, tmp_path, voxels.Options(size=0.1))
    assert np.load(tmp_path / "voxels.npy").max() == 1.0
    assert json.loads((tmp_path / "voxels.json").read_text())["volume_cut_off_at_1"] > 0.1


def test_too_many_voxels_are_refused_with_the_size_that_will_do(tmp_path):
    bed = make_bed(cubic_lattice(2, 0.1), 0.1, box_container((0, 0, 0), (0.4, 0.4, 0.4)))
    with pytest.raises(ExportError, match=r"voxels: 6.4e\+10 voxels of 0.0001 m, .* voxels.size to 0.000698"):
        voxels.write(bed, tmp_path, voxels.Options(size=1e-4))
    assert list(tmp_path.iterdir()) == []
