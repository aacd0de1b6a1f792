"""A bed that is packed in pieces has the spheres of the bed that is packed in one."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.arrange.crew import Alone
from packgen.errors import PackingError
from packgen.filling.in_pieces import pack_in_pieces
from packgen.filling.pack import pack
from packgen.pieces.bed import NAMES
from packgen.report_in_pieces import check_pieces
from tests.scenes import box, constant, read_scene, uniform

TROUGH = box([0, 0, 0], [4.6, 0.8, 2])


def rows(bed):
    table = np.column_stack([getattr(bed, name) for name in NAMES])
    return table[np.lexsort(table.T)]


def test_the_pieces_have_the_spheres_of_the_bed_in_one(tmp_path):
    sets = [constant(0.05), uniform(0.03, 0.04) | {"density": 3000.0}]
    zones = [{"n_particles": 2500, "set_proportions": [0.6, 0.4]}]
    scene, vessel = read_scene(tmp_path, TROUGH, sets, zones=zones, params={"tile": 20})
    wanted = pack(scene, vessel, threads=1)
    folder = tmp_path / "bed"
    folder.mkdir()
    found = pack_in_pieces(scene, vessel, folder, crew=Alone(), threads=1, spheres=300)
    assert len(found.bed.pieces) > 3
    assert np.array_equal(rows(found.bed.gathered()), rows(wanted.bed))
    assert found.zones == wanted.zones
    assert found.warnings == wanted.warnings
    assert found.bed.provenance == wanted.bed.provenance
    assert check_pieces(found.bed).within_tolerance


def test_sets_in_proportion_until_full_are_refused_before_the_first_sphere(tmp_path):
    scene, vessel = read_scene(
        tmp_path, TROUGH, [constant(0.05), constant(0.04)], params={"tile": 20},
        zones=[{"set_proportions": [0.5, 0.5]}],
    )  # fmt: skip
    with pytest.raises(PackingError, match="found several sets and no amount, expected n_particles"):
        pack_in_pieces(scene, vessel, tmp_path, crew=Alone())


def test_a_bed_to_go_on_from_is_refused_before_the_first_sphere(tmp_path):
    (tmp_path / "old.csv").write_text("x,y,z,r\n0.4,0.4,0.05,0.05\n")
    scene, vessel = read_scene(
        tmp_path, TROUGH, constant(0.05), params={"tile": 20}, start_from="old.csv",
        zones=[{"n_particles": 500}],
    )  # fmt: skip
    with pytest.raises(PackingError, match="start_from: found a bed to go on from, expected none"):
        pack_in_pieces(scene, vessel, tmp_path, crew=Alone())


def test_a_zone_of_its_own_says_what_is_not_looked_at(tmp_path):
    scene, vessel = read_scene(
        tmp_path, TROUGH, constant(0.05), params={"tile": 20},
        zones=[{"n_particles": 500, "location": {"slice": {"axis": 2, "min_bound": 0.0, "max_bound": 1.0}}}],
    )  # fmt: skip
    found = pack_in_pieces(scene, vessel, tmp_path, crew=Alone(), threads=1)
    assert any("whether anything holds it up is not looked at" in line for line in found.warnings)
