from __future__ import annotations

import shutil

import pytest

from exporters import lammps
from packgen.validation import Limits, validate
from tests.beds import make_bed
from tests.exporters.beds import RADIUS, lattice
from tests.validation.beds import OVERLAP, bed_in

pytestmark = [
    pytest.mark.solver,
    pytest.mark.skipif(shutil.which("lmp") is None, reason="lammps (lmp) is not installed"),
]


def judge(bed, folder, **limits):
    lammps.write(bed, folder, lammps.Options())
    return validate(bed, folder, solver="lammps", limits=Limits(**limits))


@pytest.mark.parametrize("kind", ["box", "cylinder", "drum", "cone", "hopper", "ball"])
def test_forces_at_step_zero_are_those_of_the_law_in_every_container(tmp_path, kind):
    zero = judge(bed_in(kind), tmp_path, free_fall_times=0.01).step_zero
    assert (zero.pair_count, zero.wall_count) == (1, 2)
    assert zero.worst_pair == (0, 2)
    assert zero.pair_overlap_max == pytest.approx(OVERLAP, rel=1e-9)
    assert zero.wall_overlap_max == pytest.approx(OVERLAP, rel=1e-9)
    assert zero.law_error < 1e-9


def test_touching_spheres_pass(tmp_path):
    report = judge(lattice(), tmp_path)
    assert report.missed == ()
    assert report.gravity_run.still
    assert "LAMMPS" in report.version


def test_a_sphere_beyond_the_wall_is_found_and_named(tmp_path):
    bed = lattice()
    position = bed.position.copy()
    position[7] = [-1.5 * RADIUS, RADIUS, RADIUS]
    report = judge(make_bed(position, RADIUS, bed.container), tmp_path)
    assert report.step_zero.worst_outside == 7
    assert 7 in report.gravity_run.lost
    assert any("spheres lost" in line and "7" in line for line in report.missed)
