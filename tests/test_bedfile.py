"""``bed.npz`` there and back, with bodies and without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from packgen.bedfile import COLUMNS, load_columns, save_bed
from tests.beds import box_container, cubic_lattice, make_bed


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
