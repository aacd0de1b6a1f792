"""A bed that wraps around, several times side by side."""

from __future__ import annotations

import numpy as np
import pytest

from packgen.bedfile import save_bed
from packgen.check import check_bed, near_pairs
from packgen.errors import GeometryError
from packgen.reading import read_bed
from packgen.reshape.repeat import GAP, repeat_bed
from tests.beds import box_container, cubic_lattice, make_bed
from tests.clump_beds import lattice_of_clumps


def lattice(periodic=(True, True, False), shift=0.0):
    """27 touching spheres of radius 0.25 in a box of 1.5."""
    position = cubic_lattice(3, 0.25) + np.array([shift, 0, 0])
    return make_bed(position, 0.25, box_container((0, 0, 0), (1.5, 1.5, 1.5), periodic))


def contacts(bed):
    found = near_pairs(
        bed.position, bed.radius, gap_fraction=GAP, period=bed.container.period, body_index=bed.body_index
    )
    return sum(len(each.gap) for each in found)


def test_copies_are_counted_exactly_and_keep_what_they_have():
    bed = lattice()
    bed = make_bed(bed.position, 0.25, bed.container, zone_index=np.arange(27), batch_index=np.arange(27) + 3)
    found = repeat_bed(bed, (4, 3, 1))
    copied = found.bed
    assert copied.count == 12 * 27
    assert copied.container.bounds.tolist() == [[0, 0, 0], [6, 4.5, 1.5]]
    assert copied.container.volume == 6 * 4.5 * 1.5
    assert copied.container.periodic == (True, True, False)
    assert np.array_equal(copied.position[:27], bed.position)
    assert np.array_equal(copied.position[27:54], bed.position + np.array([1.5, 0, 0]))
    assert np.array_equal(copied.position[4 * 27 : 5 * 27], bed.position + np.array([0, 1.5, 0]))
    assert np.array_equal(copied.zone_index, np.tile(np.arange(27), 12))
    assert np.array_equal(copied.batch_index, np.tile(np.arange(27) + 3, 12))


@pytest.mark.parametrize("shift", [0.0, 0.125])
def test_contacts_across_the_seams_are_all_there(shift):
    bed = lattice(shift=shift)
    assert contacts(bed) == 27 * 2 + 18
    found = repeat_bed(bed, (4, 2, 1))
    assert contacts(found.bed) == 8 * (27 * 2 + 18)
    assert (found.contacts, found.seam_contacts) == (18, 8 * 18)
    assert found.worst_overlap == pytest.approx(0.0, abs=1e-12)
    assert check_bed(found.bed).within_tolerance
    assert repeat_bed(bed, (1, 5, 1)).contacts == 9
    assert repeat_bed(bed, (1, 1, 1)).seam_contacts == 0


def test_an_overlap_across_a_seam_is_found():
    bed = make_bed([[0.1, 0.5, 0.5], [0.9, 0.5, 0.5]], 0.11, box_container((0, 0, 0), (1, 1, 1), (True,) * 3))
    found = repeat_bed(bed, (3, 1, 1))
    assert found.worst_overlap == pytest.approx(0.02 / 0.11)
    assert check_bed(found.bed).overlap_count == 3


def test_walls_are_refused_by_the_names_of_their_axes():
    with pytest.raises(
        GeometryError, match=r"2 3 4: .* walls along y \(found 3\) and z \(found 4\), .*along x$"
    ):
        repeat_bed(lattice((True, False, False)), (2, 3, 4))
    with pytest.raises(GeometryError, match="wraps around along no axis"):
        repeat_bed(lattice((False,) * 3), (2, 1, 1))


def test_too_many_spheres_are_refused():
    with pytest.raises(GeometryError, match=r"found 2,700,000,000 spheres, expected at most 2,147,483,647"):
        repeat_bed(lattice(), (10_000, 10_000, 1))


def test_clumps_that_a_seam_tore_apart_hang_together_again():
    box = box_container((0, 0, 0), (4, 4, 4), (True, False, False))
    position = [[3.9, 2, 2], [0.1, 2, 2], [2.0, 2, 2]]
    bed = make_bed(position, 0.15, box, body_index=np.array([7, 7, 9]))
    copied = repeat_bed(bed, (3, 1, 1)).bed
    assert len(set(copied.body_index.tolist())) == 6
    for body in set(copied.body_index.tolist()):
        x = np.sort(copied.position[copied.body_index == body, 0])
        assert len(x) in (1, 2)
        if len(x) == 2:
            assert min(x[1] - x[0], x[0] + 12 - x[1]) == pytest.approx(0.2)
    assert check_bed(copied).overlap_count == 0


def test_the_file_knows_its_larger_box(tmp_path):
    settings = {
        "particle_sets": [{"name": "p", "density": 900, "material": "wax"}], "materials": [{"name": "wax"}],
        "gravity_direction": [0, 0, -1], "gravity": 9.81, "wall_material": "wax", "params": {},
        "container": {"box": {"min": [0, 0, 0], "max": [1.5, 1.5, 1.5]}, "periodic": [True, True, False]},
    }  # fmt: skip
    bed = lattice()
    bed = make_bed(bed.position, 0.25, bed.container, provenance={"settings": settings})
    found = repeat_bed(bed, (2, 2, 1))
    save_bed(found.bed, tmp_path / "bed.npz")
    again = read_bed(tmp_path / "bed.npz")
    assert again.container.bounds.tolist() == [[0, 0, 0], [3, 3, 1.5]]
    assert again.container.periodic == (True, True, False)
    assert again.provenance["repeated"]["contacts_between_copies"] == found.seam_contacts == 4 * 18


def test_known_bodies_are_copied_whole_across_the_seams():
    bed = lattice_of_clumps(singles=True, periodic=(True, True, False))
    found = repeat_bed(bed, (2, 3, 1)).bed
    assert len(found.bodies) == 6 * len(bed.bodies)
    assert len(found.bodies.templates) == 2
    checked = check_bed(found)
    assert checked.bodies.misplaced_count == 0
    assert checked.overlap_max == 0.0
    assert (found.position >= found.container.bounds[0])[:, :2].all()
    assert (found.position < found.container.bounds[1])[:, :2].all()
