"""``bed.npz`` there and back, with bodies and without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from packgen.bedfile import COLUMNS, load_columns, save_bed
from packgen.errors import ReadError
from packgen.reading import read_bed
from tests.beds import box_container, cubic_lattice, make_bed
from tests.clump_beds import lattice_of_clumps


def lattice_bed(**changes):
    return make_bed(cubic_lattice(3, 0.1), 0.1, box_container([0, 0, 0], [0.6] * 3), **changes)


BODIES = np.repeat(np.arange(9, dtype=np.int32), 3)


@pytest.mark.parametrize("body_index", [None, BODIES], ids=["spheres", "bodies"])
def test_columns_come_back_as_they_were(tmp_path, body_index):
    bed = lattice_bed(body_index=body_index)
    save_bed(bed, tmp_path / "bed.npz")
    found = load_columns(tmp_path / "bed.npz")
    for name in COLUMNS:
        np.testing.assert_array_equal(getattr(found, name), getattr(bed, name))
    if body_index is None:
        assert found.body_index is None
    else:
        assert found.body_index.dtype == np.int32
        np.testing.assert_array_equal(found.body_index, body_index)


def test_the_file_of_a_bed_without_bodies_has_no_column_of_them(tmp_path):
    save_bed(lattice_bed(), tmp_path / "bed.npz")
    with np.load(tmp_path / "bed.npz") as read:
        assert set(read.files) == {*COLUMNS, "provenance"}


def test_a_bed_holds_its_bodies_read_only_and_refuses_those_of_another_bed():
    bed = lattice_bed(body_index=BODIES.tolist())
    assert bed.body_index.dtype == np.int32
    assert not bed.body_index.flags.writeable
    assert replace(bed, body_index=None).body_index is None
    with pytest.raises(ValueError, match=r"bed\.body_index: shape \(3,\), expected \(27,\)"):
        lattice_bed(body_index=BODIES[:3])


def test_a_file_without_a_column_is_refused(tmp_path):
    np.savez(tmp_path / "bed.npz", position=np.zeros((1, 3)))
    with pytest.raises(KeyError, match="radius"):
        load_columns(tmp_path / "bed.npz")


@pytest.mark.parametrize("singles", [False, True])
def test_bodies_come_back_whole(tmp_path, singles):
    bed = lattice_of_clumps(singles=singles)
    save_bed(bed, tmp_path / "bed.npz")
    with np.load(tmp_path / "bed.npz") as read:
        assert read["body_position"].shape == (27, 3)
        assert read["body_orientation"].shape == (27, 4)
        assert read["body_template"].dtype == np.int32
    for found in (load_columns(tmp_path / "bed.npz").bodies, read_bed(tmp_path / "bed.npz").bodies):
        for name in ("template_index", "scale", "position", "orientation"):
            np.testing.assert_array_equal(getattr(found, name), getattr(bed.bodies, name))
        for one, other in zip(found.templates, bed.bodies.templates, strict=True):
            assert (one.name, one.volume) == (other.name, other.volume)
            np.testing.assert_array_equal(one.spheres, other.spheres)
            np.testing.assert_array_equal(one.inertia, other.inertia)


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("body_template", np.full(27, 2, np.int32), "from -1 to 1"),
        ("body_orientation", np.ones((27, 4)), "unit quaternion"),
        ("body_scale", None, "without body_scale"),
        ("templates", np.array("[3]"), "templates that are none"),
        ("body_index", np.zeros(81, np.int32), "27 bodies that are not those of body_index"),
    ],
)
def test_bodies_that_are_none_are_refused_by_name(tmp_path, key, value, words):
    save_bed(lattice_of_clumps(), tmp_path / "bed.npz")
    with np.load(tmp_path / "bed.npz") as read:
        arrays = dict(read) | {key: value}
    if key == "body_index":
        arrays[key] = np.zeros(len(arrays["radius"]), np.int32)
    np.savez(tmp_path / "bed.npz", **{name: each for name, each in arrays.items() if each is not None})
    with pytest.raises(ReadError, match=words):
        read_bed(tmp_path / "bed.npz")


def test_a_bed_refuses_bodies_that_are_not_those_of_its_spheres():
    bed = lattice_of_clumps()
    with pytest.raises(ValueError, match=r"27 bodies are not those of bed\.body_index"):
        replace(bed, body_index=np.roll(bed.body_index, 1))


def test_lengths_in_another_unit_scale_bodies_as_well(tmp_path):
    bed = lattice_of_clumps()
    save_bed(bed, tmp_path / "bed.npz")
    found = read_bed(tmp_path / "bed.npz", units="mm")
    np.testing.assert_allclose(found.bodies.volume, 1e-9 * bed.bodies.volume)
    np.testing.assert_allclose(found.bodies.position, 1e-3 * bed.bodies.position)
